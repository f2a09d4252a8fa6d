// Talks HTTP with the server: cookies, the CSRF header, ETags, problem+json. Knows no route; those are in calls.ts.

/** What the server refused, in its own words. `body` holds extra members, such as the two sides of a conflict. */
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

export async function call<T>(method: Method, path: string, body?: unknown): Promise<Reply<T>> {
  const headers: Record<string, string> = { accept: "application/json" };
  if (method !== "GET") headers["x-csrf-token"] = csrf;
  if (body !== undefined) headers["content-type"] = "application/json";
  let response: Response;
  try {
    const init: RequestInit = { method, headers, credentials: "same-origin" };
    if (body !== undefined) init.body = JSON.stringify(body);
    response = await fetch(`/api/v1${path}`, init);
  } catch {
    throw new Offline(path);
  }
  const text = await response.text();
  if (!response.ok) throw problem(response.status, text);
  return { data: parse<T>(text), status: response.status, etag: response.headers.get("etag") };
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
