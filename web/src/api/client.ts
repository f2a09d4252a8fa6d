// HTTP with the service: cookies, the CSRF header, ETags, retries, problem+json. Knows no route; calls.generated.ts
// does.

/** A refusal of the service in both languages. `body` is the whole problem document. */
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

/** The service could not be reached: whether it acted is unknown. */
export class Offline extends Error {}

/** Where the API begins. */
export const BASE = "/api/v1";

let csrf = "";

/** The token that every write must carry; `GET /session` returns it. */
export function setCsrf(token: string): void {
  csrf = token;
}

/** Asks who is signed in now, in this browser; true when it is still the user of this page, with a valid token. */
let renew: (() => Promise<boolean>) | null = null;

/** Another tab may sign out, and in again: the token of this page is then out of date, its user perhaps another. */
export function onStaleSession(ask: () => Promise<boolean>): void {
  renew = ask;
}

type Method = "GET" | "POST" | "PATCH" | "PUT" | "DELETE";

export interface CallOptions {
  /** How long to wait for the answer, ms. */
  timeoutMs?: number;
}

/** A body that is sent as it is instead of being serialized as JSON. */
export class TextBody {
  constructor(
    readonly text: string,
    readonly mediaType: string,
  ) {}
}

/** Longer than any ordinary answer takes. */
const TIMEOUT_MS = 30_000;
/** For work that grows with its input: thousands of episodes or labels. */
export const LONG_TIMEOUT_MS = 600_000;
/** Waits before a read is tried again. Writes are not repeated here: only the caller knows whether that is safe. */
const RETRY_DELAYS_MS = [300, 1200];
const TRANSIENT_STATUS = [502, 503, 504];

interface CachedResponse {
  etag: string;
  data: unknown;
}

/** The latest reads that carried an ETag: an unchanged one is not transferred twice. */
const cache = new Map<string, CachedResponse>();
const CACHE_SIZE = 40;

/** Empties the cache: another user may sign in next. */
export function clearCache(): void {
  cache.clear();
}

/** Calls a route. The result is null for an answer without content (204). */
export async function call<T>(method: Method, path: string, body?: unknown, options: CallOptions = {}): Promise<T> {
  const delays = method === "GET" ? RETRY_DELAYS_MS : [];
  for (let attempt = 0; ; attempt++) {
    const delay = delays[attempt];
    try {
      // Kept for the answer: while it is on its way, other answers may take its place in the cache.
      const known = method === "GET" ? cache.get(path) : undefined;
      const response = await send(method, path, body, known, options.timeoutMs ?? TIMEOUT_MS);
      if (delay === undefined || !TRANSIENT_STATUS.includes(response.status)) return await receive<T>(method, path, known, response);
    } catch (error) {
      // The service refused it before it did anything: it may be repeated.
      if (error instanceof ApiError && error.code === "session.csrf" && attempt === 0 && renew && (await renew())) continue;
      if (!(error instanceof Offline) || delay === undefined) throw error;
    }
    await new Promise((done) => setTimeout(done, delay));
  }
}

async function send(method: Method, path: string, body: unknown, known: CachedResponse | undefined, timeoutMs: number): Promise<Response> {
  const headers: Record<string, string> = { accept: "application/json" };
  const init: RequestInit = { method, headers, credentials: "same-origin", signal: AbortSignal.timeout(timeoutMs) };
  if (method === "GET") {
    // The browser's own cache would answer for the user who was signed in before.
    init.cache = "no-store";
    if (known) headers["if-none-match"] = known.etag;
  } else {
    headers["x-csrf-token"] = csrf;
  }
  if (body instanceof TextBody) {
    headers["content-type"] = body.mediaType;
    init.body = body.text;
  } else if (body !== undefined) {
    headers["content-type"] = "application/json";
    init.body = JSON.stringify(body);
  }
  try {
    return await fetch(BASE + path, init);
  } catch {
    throw new Offline(path);
  }
}

async function receive<T>(method: Method, path: string, known: CachedResponse | undefined, response: Response): Promise<T> {
  if (response.status === 304 && known) return known.data as T;
  let text: string;
  try {
    text = await response.text();
  } catch {
    throw new Offline(path);
  }
  if (!response.ok) throw problem(response.status, text);
  const data = parse<T>(text);
  const etag = response.headers.get("etag");
  if (method === "GET" && etag) {
    cache.delete(path);
    cache.set(path, { etag, data });
    for (const oldest of cache.keys()) {
      if (cache.size <= CACHE_SIZE) break;
      cache.delete(oldest);
    }
  }
  return data;
}

export type QueryValue = string | number | boolean | null | undefined;

/** A query string of the members that have a value. */
export function queryString(members: Record<string, QueryValue>): string {
  const q = new URLSearchParams();
  for (const [key, value] of Object.entries(members)) {
    if (value !== undefined && value !== null && value !== "" && value !== false) q.set(key, String(value));
  }
  const text = q.toString();
  return text ? `?${text}` : "";
}

/** Nanoseconds do not fit a double: integers of 16 digits and more become text, which `ns.ts` reads. */
function parse<T>(text: string): T {
  if (text === "") return null as T;
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
    // A proxy's page or an empty body: only the status is known.
  }
  const textOf = (key: string): string => (typeof body[key] === "string" ? body[key] : "");
  const title = textOf("title") || `HTTP ${status}`;
  return new ApiError(status, textOf("code"), textOf("detail_zh") || title, textOf("detail_en") || title, body);
}
