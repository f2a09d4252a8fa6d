// HTTP with the service: what is sent, what is tried again, what a refusal becomes.
import assert from "node:assert/strict";
import { beforeEach, test } from "vitest";
import { ApiError, call, clearCache, Offline, onStaleSession, queryString, TextBody, setCsrf } from "./client.ts";

interface Sent {
  url: string;
  init: RequestInit;
}
let sent: Sent[] = [];

/** Answers each request with the next of `replies`; "down" is a network that is away. */
function serve(...replies: (Response | "down")[]): void {
  globalThis.fetch = async (url, init) => {
    sent.push({ url: String(url), init: init ?? {} });
    const reply = replies.shift();
    if (reply === undefined || reply === "down") throw new TypeError("fetch failed");
    return reply;
  };
}
const json = (value: unknown, status = 200, headers: Record<string, string> = {}): Response =>
  new Response(JSON.stringify(value), { status, headers });
const header = (n: number, name: string): string | null => new Headers(sent[n]?.init.headers).get(name);

beforeEach(() => {
  sent = [];
  clearCache();
});

test("writes carry the CSRF value, reads do not", async () => {
  setCsrf("token");
  serve(json({}), json({}));
  await call("POST", "/x", { a: 1 });
  await call("GET", "/x");
  assert.equal(header(0, "x-csrf-token"), "token");
  assert.equal(header(0, "content-type"), "application/json");
  assert.equal(header(1, "x-csrf-token"), null);
});

test("a write whose token is out of date is sent once more with the new one, where the user is the same", async () => {
  const stale = (): Response => json({ code: "session.csrf" }, 403);
  setCsrf("old");
  onStaleSession(async () => (setCsrf("new"), true));
  serve(stale(), json({ done: 1 }));
  assert.deepEqual(await call("PATCH", "/x", { a: 1 }), { done: 1 });
  assert.deepEqual([header(0, "x-csrf-token"), header(1, "x-csrf-token")], ["old", "new"]);
  serve(stale(), stale(), json({}));
  await assert.rejects(call("PATCH", "/x"), { code: "session.csrf" });
  assert.equal(sent.length, 4, "not again and again");
  onStaleSession(async () => false);
  serve(stale(), json({}));
  await assert.rejects(call("PATCH", "/x"), { code: "session.csrf" });
  assert.equal(sent.length, 5, "another user, or nobody");
});

test("a read is tried again after a failed network and a passing 503, a write never", async () => {
  serve("down", json({}, 503), json({ here: true }));
  assert.deepEqual(await call("GET", "/again"), { here: true });
  assert.equal(sent.length, 3);
  sent = [];
  serve("down", json({}));
  await assert.rejects(call("POST", "/once", {}), Offline);
  assert.equal(sent.length, 1);
});

test("an unchanged answer is known, also where many others came while it was on its way", async () => {
  serve(json({ n: 1 }, 200, { etag: '"v1"' }));
  await call("GET", "/kept");
  let answer = (_: Response): void => {};
  globalThis.fetch = () => new Promise((done) => (answer = done));
  const waiting = call("GET", "/kept");
  const mine = answer;
  for (let n = 0; n < 60; n++) {
    serve(json({ n }, 200, { etag: `"o${n}"` }));
    await call("GET", `/other/${n}`);
  }
  mine(new Response(null, { status: 304 }));
  assert.deepEqual(await waiting, { n: 1 });
});

test("an unchanged answer is not sent twice, and is forgotten with its reader", async () => {
  serve(json({ n: 1 }, 200, { etag: '"v1"' }), new Response(null, { status: 304 }), json({ n: 2 }));
  await call("GET", "/kept");
  assert.deepEqual(await call("GET", "/kept"), { n: 1 });
  assert.equal(header(1, "if-none-match"), '"v1"');
  clearCache();
  assert.deepEqual(await call("GET", "/kept"), { n: 2 });
  assert.equal(header(2, "if-none-match"), null);
});

test("a problem keeps its code, both languages and what belongs to it", async () => {
  const body = { code: "lease.lost", title: "lost", detail_zh: "租约已失效", detail_en: "the lease is lost", more: { version: 3 } };
  serve(json(body, 409));
  const error = await call("PATCH", "/x", {}).then(() => null, (e: unknown) => e);
  assert.ok(error instanceof ApiError);
  assert.deepEqual([error.status, error.code, error.zh, error.en, error.more["version"]], [409, "lease.lost", "租约已失效", "the lease is lost", 3]);
  // A proxy's page is not problem+json: only its status is known.
  serve(new Response("<html>Bad</html>", { status: 400 }));
  await assert.rejects(call("POST", "/x"), /400/);
});

test("text goes out as it is; empty members of a queryString do not", async () => {
  serve(json({}));
  await call("POST", "/import", new TextBody("{}\n{}\n", "application/x-ndjson"));
  assert.equal(sent[0]?.init.body, "{}\n{}\n");
  assert.equal(header(0, "content-type"), "application/x-ndjson");
  assert.equal(queryString({ a: "1 2", b: "", c: false, d: null, e: undefined, f: 0 }), "?a=1+2&f=0");
  assert.equal(queryString({}), "");
});
