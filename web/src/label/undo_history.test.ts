// What one press of undo takes back. Expected values by hand.
import assert from "node:assert/strict";
import { beforeEach, test, vi } from "vitest";
import { UndoHistory } from "./undo_history.svelte.ts";

let history: UndoHistory;
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["performance"] });
  history = new UndoHistory();
  return () => vi.useRealTimers();
});

test("text typed without a pause is one step, a pause begins another", () => {
  history.record({ path: "/a", value: "x", before: "" });
  vi.advanceTimersByTime(200);
  history.record({ path: "/a", value: "xy", before: "x" });
  vi.advanceTimersByTime(2000);
  history.record({ path: "/a", value: "xyz", before: "xy" });
  assert.deepEqual(history.undo(), [{ path: "/a", value: "xy" }]);
  assert.deepEqual(history.undo(), [{ path: "/a", value: "" }]);
  assert.equal(history.undo(), null);
  assert.deepEqual(history.redo(), [{ path: "/a", value: "xy" }]);
});

test("numbers and other fields are steps of their own", () => {
  history.record({ path: "/a", value: 1, before: 0 });
  history.record({ path: "/a", value: 2, before: 1 });
  history.record({ path: "/b", value: "x", before: "" });
  assert.deepEqual(history.undo(), [{ path: "/b", value: "" }]);
  assert.deepEqual(history.undo(), [{ path: "/a", value: 1 }]);
});

test("a group is undone backwards and redone forwards, also when groups are nested", () => {
  history.group(() => {
    history.record({ path: "/a", value: 1, before: 0 });
    history.group(() => history.record({ path: "/b", value: 1, before: 0 }));
  });
  assert.deepEqual(history.undo(), [{ path: "/b", value: 0 }, { path: "/a", value: 0 }]);
  assert.deepEqual(history.redo(), [{ path: "/a", value: 1 }, { path: "/b", value: 1 }]);
});

test("an empty group is no step, and a failed one is closed", () => {
  history.group(() => {});
  assert.equal(history.canUndo, false);
  assert.throws(() => history.group(() => { throw new Error("stop"); }));
  history.record({ path: "/a", value: 1, before: 0 });
  assert.equal(history.undo()?.length, 1);
});

test("a new step ends what could be redone; clearing ends everything", () => {
  history.record({ path: "/a", value: 1, before: 0 });
  history.undo();
  assert.deepEqual([history.canUndo, history.canRedo], [false, true]);
  history.record({ path: "/b", value: 1, before: 0 });
  assert.deepEqual([history.canUndo, history.canRedo], [true, false]);
  history.clear();
  assert.deepEqual([history.canUndo, history.canRedo], [false, false]);
});
