// Fields changed on both sides, until each is decided.
import assert from "node:assert/strict";
import { test } from "vitest";
import { ConflictList } from "./conflicts.svelte.ts";

const trace = { path: "/coc_trace", mine: "a", theirs: "b" };

test("each conflict is taken once; then nothing blocks", () => {
  const list = new ConflictList();
  list.show([trace, { path: "/records/gap", mine: 1, theirs: 2 }]);
  assert.ok(list.isOpen);
  assert.deepEqual(list.take("/coc_trace"), trace);
  assert.equal(list.take("/coc_trace"), null);
  assert.ok(list.isOpen);
  list.take("/records/gap");
  assert.ok(!list.isOpen);
});

test("the same value on both sides is no conflict, in whatever order its members are", () => {
  const list = new ConflictList();
  list.show([{ path: "/keyframe", mine: { a: 1, b: [2] }, theirs: { b: [2], a: 1 } }]);
  assert.ok(!list.isOpen);
});
