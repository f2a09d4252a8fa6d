// A lease is kept by heartbeats, survives a network that is away, and ends when the service says so.
import assert from "node:assert/strict";
import { afterEach, beforeEach, test, vi } from "vitest";
import { Lease } from "./lease.svelte.ts";

interface Sent {
  action: string;
  fence: number | null;
}
let sent: Sent[];
let reply: () => Promise<Response>;
let lost: number;
let lease: Lease;

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  lost = 0;
  reply = () => Promise.resolve(new Response("{}"));
  vi.stubGlobal("fetch", (url: string, init: RequestInit) => {
    assert.equal(url, "/api/v1/tasks/t1/lease");
    sent.push(JSON.parse(String(init.body)) as Sent);
    return reply();
  });
  lease = new Lease("t1", () => lost++);
});
afterEach(() => {
  lease.stop();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("heartbeats come at a third of the lease, and carry its fence", async () => {
  lease.keep(7, Date.now() + 60_000);
  await vi.advanceTimersByTimeAsync(19_999);
  assert.deepEqual(sent, []);
  await vi.advanceTimersByTimeAsync(1);
  assert.deepEqual(sent, [{ action: "heartbeat", fence: 7 }]);
});

test("never more often than every 5 s, never less often than every 40 s", async () => {
  lease.keep(7, Date.now() + 1_000);
  await vi.advanceTimersByTimeAsync(5_000);
  assert.equal(sent.length, 1);
  lease.keep(8, Date.now() + 3_600_000);
  await vi.advanceTimersByTimeAsync(40_000);
  assert.deepEqual(sent.at(-1), { action: "heartbeat", fence: 8 });
  assert.equal(sent.length, 2, "the heartbeat of the earlier lease has ended");
});

test("a network that is away ends nothing; a lost lease ends the heartbeats", async () => {
  lease.keep(7, Date.now() + 15_000);
  reply = () => Promise.reject(new TypeError("no network"));
  await vi.advanceTimersByTimeAsync(5_000);
  assert.equal(lost, 0);
  reply = () => Promise.resolve(new Response(JSON.stringify({ code: "lease.lost" }), { status: 409 }));
  await vi.advanceTimersByTimeAsync(5_000);
  assert.equal(lost, 1);
  await vi.advanceTimersByTimeAsync(60_000);
  assert.equal(sent.length, 2);
});

test("without a fence there is nothing to keep or to release", async () => {
  lease.keep(null, 0);
  await lease.release();
  await vi.advanceTimersByTimeAsync(60_000);
  assert.deepEqual(sent, []);
  lease.keep(9, Date.now() + 60_000);
  await lease.release();
  assert.deepEqual(sent, [{ action: "release", fence: 9 }]);
});
