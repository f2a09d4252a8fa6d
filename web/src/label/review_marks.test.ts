// What an annotator confirmed survives a reload, and ends with the submission.
import assert from "node:assert/strict";
import { test } from "vitest";
import { ReviewMarks } from "./review_marks.svelte.ts";

function reloaded(task: string): ReviewMarks {
  const marks = new ReviewMarks(task);
  marks.load();
  return marks;
}

test("accepted fields are remembered per task", () => {
  const marks = new ReviewMarks("t1");
  marks.accept("/coc_trace");
  marks.accept("/causes/lateral");
  assert.deepEqual([...reloaded("t1").accepted], ["/coc_trace", "/causes/lateral"]);
  assert.equal(reloaded("t2").accepted.size, 0);
});

test("after the submission nothing is left, and broken data counts as nothing", () => {
  const marks = new ReviewMarks("t1");
  marks.accept("/coc_trace");
  marks.clearStored();
  assert.equal(reloaded("t1").accepted.size, 0);
  localStorage.setItem("whyroad.accepted.t1", "{half");
  assert.equal(reloaded("t1").accepted.size, 0);
});
