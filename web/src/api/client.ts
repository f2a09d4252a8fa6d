// Talks HTTP with the server: cookies, the CSRF header, ETags, retries, problem+json. Knows no route; those are in calls.ts.

/** What the server refused, in its own words. `more` holds what belongs to it, such as the two sides of a conflict. */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    readonly zh: string,
    readonly en: string,
    readonly body: Record<string, unknown>,
  ) {
    super(`${status} ${code}: ${en}`);
  }

  /** Extra members of the problem: `findings`, `retry_after_s`, conflicts. */
  get more(): Record<string, unknown> {
    const more = this.body["more"];
    return typeof more === "object" && more !== null ? (more as Record<string, unknown>) : {};
  }
}

/** The server could not be reached: nothing is known about what it did. */
export class Offline extends Error {}

let csrf = "";

/** The token that every write must carry; `GET /session` hands it out. */
export function setCsrf(token: string): void {
  csrf = token;
}

type Method = "GET" | "POST" | "PATCH" | "PUT" | "DELETE";

export interface Reply<T> {
  data: T;
  status: number;
  etag: string | null;
}

/** Text that goes out as it is, instead of a value that becomes JSON. */
export class Raw {
  constructor(
    readonly text: string,
    readonly type: string,
  ) {}
}

/** Longer than any answer takes, shorter than a person waits before thinking that nothing happens. */
const PATIENCE_MS = 30_000;
/** For work that grows with what is sent: thousands of episodes or labels. */
export const LONG_MS = 600_000;
/** Waits before a read is tried again. Writes are never repeated here: whoever wrote knows whether that is safe. */
const AGAIN_MS = [300, 1200];
/** Answers of reads that carried an ETag, the latest ones: an unchanged one is not sent twice. */
const fresh = new Map<string, Reply<unknown>>();
const FRESH_MOST = 40;

/** Forgets what was read: for somebody else may sign in next. */
export function forget(): void {
  fresh.clear();
}

export async function call<T>(method: Method, path: string, body?: unknown, patience = PATIENCE_MS): Promise<Reply<T>> {
  const again = method === "GET" ? AGAIN_MS : [];
  for (let attempt = 0; ; attempt++) {
    const wait = again[attempt];
    try {
      const response = await send(method, path, body, patience);
      const passing = [502, 503, 504].includes(response.status);
      if (!passing || wait === undefined) return await answer<T>(method, path, response);
    } catch (error) {
      if (!(error instanceof Offline) || wait === undefined) throw error;
    }
    await new Promise((done) => setTimeout(done, wait));
  }
}

async function send(method: Method, path: string, body: unknown, patience: number): Promise<Response> {
  const headers: Record<string, string> = { accept: "application/json" };
  const init: RequestInit = { method, headers, credentials: "same-origin", signal: AbortSignal.timeout(patience) };
  if (method === "GET") {
    // The browser's own cache would answer for whoever was signed in before.
    init.cache = "no-store";
    const etag = fresh.get(path)?.etag;
    if (etag) headers["if-none-match"] = etag;
  } else {
    headers["x-csrf-token"] = csrf;
  }
  if (body instanceof Raw) {
    headers["content-type"] = body.type;
    init.body = body.text;
  } else if (body !== undefined) {
    headers["content-type"] = "application/json";
    init.body = JSON.stringify(body);
  }
  try {
    return await fetch(`/api/v1${path}`, init);
  } catch {
    throw new Offline(path);
  }
}

async function answer<T>(method: Method, path: string, response: Response): Promise<Reply<T>> {
  if (response.status === 304) {
    const kept = fresh.get(path);
    if (kept) return kept as Reply<T>;
  }
  let text: string;
  try {
    text = await response.text();
  } catch {
    throw new Offline(path);
  }
  if (!response.ok) throw problem(response.status, text);
  const reply = { data: parse<T>(text), status: response.status, etag: response.headers.get("etag") };
  if (method === "GET" && reply.etag) {
    fresh.delete(path);
    fresh.set(path, reply);
    for (const oldest of fresh.keys()) {
      if (fresh.size <= FRESH_MOST) break;
      fresh.delete(oldest);
    }
  }
  return reply;
}

/** A query string of the members that have a value. */
export function query(members: Record<string, string | number | boolean | null | undefined>): string {
  const q = new URLSearchParams();
  for (const [k, v] of Object.entries(members)) {
    if (v !== undefined && v !== null && v !== "" && v !== false) q.set(k, String(v));
  }
  const text = q.toString();
  return text ? `?${text}` : "";
}

/** Nanoseconds do not fit a double: integers of 16 digits and more come out as text, for `ns.ts` to read. */
function parse<T>(text: string): T {
  if (text === "") return undefined as T;
  if (!/\d{16}/.test(text)) return JSON.parse(text) as T;
  const exact = (_key: string, value: unknown, context?: { source?: string }): unknown =>
    typeof value === "number" && context?.source && /^-?\d{16,}$/.test(context.source) ? context.source : value;
  return JSON.parse(text, exact as (key: string, value: unknown) => unknown) as T;
}

function problem(status: number, text: string): ApiError {
  let body: Record<string, unknown> = {};
  try {
    const read: unknown = JSON.parse(text);
    if (typeof read === "object" && read !== null) body = read as Record<string, unknown>;
  } catch {
    // A proxy's page or nothing at all: the status has to do.
  }
  const word = (key: string): string => (typeof body[key] === "string" ? body[key] : "");
  const title = word("title") || `HTTP ${status}`;
  return new ApiError(status, word("code"), word("detail_zh") || title, word("detail_en") || title, body);
}
