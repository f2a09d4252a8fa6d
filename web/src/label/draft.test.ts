// Nothing that an annotator typed is lost: not while offline, not by another's change, not by a lost lease. The server
// here is a few lines that answer as the OpenAPI document of the service says.
import assert from "node:assert/strict";
import { beforeEach, test } from "vitest";
import type { Task } from "../api/types.ts";
import { Draft } from "./draft.svelte.ts";
import { findingCounts } from "../components/label/finding_counts.ts";
import type { Json } from "./pointer.ts";

type Answer = { status: number; body: unknown } | "offline";
let answer: (body: { base_version: number; changes: { path: string; value: Json; remove?: boolean }[] }) => Answer;
let sent: string[][] = [];

beforeEach(() => {
  localStorage.clear();
  sent = [];
  answer = ({ base_version }) => ({ status: 200, body: { version: base_version + 1, findings: [], lease_until: 0 } });
  Object.assign(globalThis, {
    BroadcastChannel: class {
      postMessage(): void {}
      close(): void {}
    },
    fetch: (_url: string, init: RequestInit) => {
      const body = JSON.parse(String(init.body));
      sent.push(body.changes.map((c: { path: string }) => c.path));
      const a = answer(body);
      if (a === "offline") return Promise.reject(new TypeError("no network"));
      return Promise.resolve(new Response(JSON.stringify(a.body), { status: a.status }));
    },
  });
});

const task = (draft: Json, version = 1): Task =>
  ({ task: { id: "t", state: "stage2" }, draft, version, fence: 7, findings: [] }) as unknown as Task;

function opened(doc: Json = { coc_trace: "" }): Draft {
  const draft = new Draft("anna");
  draft.load(task(doc));
  return draft;
}

test("a change is on this machine before it is sent, and only there until it is acknowledged", async () => {
  const draft = opened();
  draft.set("/coc_trace", "前车刹车");
  assert.equal(draft.queue.unsaved, 1);
  assert.ok(Object.values({ ...localStorage }).join().includes("前车刹车"));
  assert.equal(sent.length, 0, "typing rests before it is sent");
  assert.ok(await draft.flush());
  assert.deepEqual(sent, [["/coc_trace"]]);
  assert.equal(draft.queue.status, "saved");
  assert.equal(localStorage.length, 0);
  draft.close();
});

test("findings about a text that cannot be saved are not about what is shown", async () => {
  const draft = opened({ coc_trace: "", records: {} });
  draft.set("/coc_trace", "a");
  assert.ok(!draft.isUnchecked("/coc_trace"), "it will be sent in a moment");
  answer = () => "offline";
  await draft.flush();
  assert.ok(draft.isUnchecked() && draft.isUnchecked("/coc_trace") && !draft.isUnchecked("/records"));
  assert.equal(findingCounts([], draft.isUnchecked()), "unsaved changes are not checked yet");
  answer = ({ base_version }) => ({ status: 200, body: { version: base_version + 1, findings: [], lease_until: 0 } });
  assert.ok(await draft.flush());
  assert.ok(!draft.isUnchecked());
  assert.equal(findingCounts([], draft.isUnchecked()), "No findings");
  draft.close();
});

test("offline keeps everything, a new visit finds it again and sends it", async () => {
  const draft = opened();
  answer = () => "offline";
  draft.set("/coc_trace", "a");
  draft.set("/driving_decision", { longitudinal: "resume" });
  assert.equal(await draft.flush(), false);
  assert.equal(draft.queue.status, "offline");
  assert.equal(draft.queue.unsaved, 2);
  draft.close();

  answer = ({ base_version }) => ({ status: 200, body: { version: base_version + 1, findings: [], lease_until: 0 } });
  const next = opened();
  assert.equal(next.text("/coc_trace"), "a");
  assert.deepEqual(next.notice, { kind: "restored" });
  assert.ok(await next.flush());
  assert.deepEqual(sent.at(-1), ["/coc_trace", "/driving_decision"]);
  assert.equal(localStorage.length, 0);
  next.close();
});

test("a conflict sends nothing until each place is settled; both sides can win", async () => {
  for (const side of ["mine", "theirs"] as const) {
    const draft = opened({ coc_trace: "", records: {} });
    draft.set("/coc_trace", "mine");
    draft.set("/records/min_ttc", 2);
    answer = () => ({
      status: 409,
      body: {
        code: "draft.conflict",
        more: {
          version: 9,
          draft: { coc_trace: "theirs", records: {}, extra: true },
          conflicts: [{ path: "/coc_trace", mine: "mine", theirs: "theirs" }],
        },
      },
    });
    assert.equal(await draft.flush(), false);
    assert.equal(draft.conflicts.items.length, 1);
    assert.equal(draft.at("/extra"), true, "what they changed elsewhere is there");
    let got: unknown;
    answer = (body) => {
      got = body;
      return { status: 200, body: { version: 10, findings: [], lease_until: 0 } };
    };
    draft.settle("/coc_trace", side);
    assert.ok(await draft.flush());
    assert.equal(draft.text("/coc_trace"), side);
    const paths = (got as { changes: { path: string }[] }).changes.map((c) => c.path);
    assert.deepEqual(paths, side === "mine" ? ["/coc_trace", "/records/min_ttc"] : ["/records/min_ttc"]);
    assert.equal((got as { base_version: number }).base_version, 9);
    draft.close();
  }
});

test("an answer that got lost is no conflict with oneself", async () => {
  const draft = opened();
  draft.set("/coc_trace", "x");
  answer = () => ({
    status: 409,
    body: {
      code: "draft.conflict",
      more: { version: 2, draft: { coc_trace: "x" }, conflicts: [{ path: "/coc_trace", mine: "x", theirs: "x" }] },
    },
  });
  await draft.flush();
  assert.equal(draft.conflicts.items.length, 0);
  assert.equal(draft.queue.unsaved, 0);
  draft.close();
});

test("a task that is no longer there for one counts as lost", async () => {
  const draft = opened();
  answer = () => ({ status: 404, body: { code: "missing" } });
  draft.set("/coc_trace", "kept");
  assert.equal(await draft.flush(), false);
  assert.equal(draft.queue.status, "lost");
  assert.ok(Object.values({ ...localStorage }).join().includes("kept"));
  draft.close();
});

test("a lost lease stops the sending and keeps the text; with a new lease it goes out", async () => {
  const draft = opened();
  answer = () => ({ status: 409, body: { code: "lease.lost" } });
  draft.set("/coc_trace", "kept");
  assert.equal(await draft.flush(), false);
  assert.equal(draft.queue.status, "lost");
  assert.ok(Object.values({ ...localStorage }).join().includes("kept"));
  const before = sent.length;
  draft.set("/coc_trace", "kept too");
  await new Promise((done) => setTimeout(done, 450));
  assert.equal(sent.length, before, "nothing is sent under a fence that is void");
  answer = ({ base_version }) => ({ status: 200, body: { version: base_version + 1, findings: [], lease_until: 0 } });
  draft.load({ ...task({ coc_trace: "" }, 4), fence: 8 } as Task);
  assert.equal(draft.text("/coc_trace"), "kept too");
  assert.ok(await draft.flush());
  assert.equal(draft.queue.status, "saved");
  draft.close();
});

test("undo takes back an action as a whole, typing in one go as one step, and redo brings it back", () => {
  const draft = opened({ coc_trace: "", driving_decision: { longitudinal: "resume" }, causes: { longitudinal: { components: ["c1"] } } });
  draft.set("/coc_trace", "a");
  draft.set("/coc_trace", "ab");
  draft.group(() => {
    draft.set("/driving_decision/longitudinal", null);
    draft.set("/causes/longitudinal", undefined);
  });
  draft.undo();
  assert.deepEqual(draft.at("/causes/longitudinal"), { components: ["c1"] });
  assert.equal(draft.at("/driving_decision/longitudinal"), "resume");
  draft.undo();
  assert.equal(draft.text("/coc_trace"), "");
  draft.redo();
  draft.redo();
  assert.equal(draft.text("/coc_trace"), "ab");
  assert.equal(draft.at("/causes/longitudinal"), undefined);
  assert.equal(draft.undoHistory.canRedo, false);
  draft.close();
});
