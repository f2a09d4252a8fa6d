// Where objects are, in the words of the drafts (`crates/whyroad-label/src/draft/components.rs`, `place`).
import assert from "node:assert/strict";
import { test } from "vitest";
import { bearingOf } from "./objects.ts";

test("a bus that comes over from the right is ahead on the right, as its draft says", () => {
  // A bus of 11.6 m and an ego of 4.8 m overlap along the way up to 8.2 m. Its center 11 m ahead and 2.5 m right is at
  // 13 degrees: eighths of a circle called that "ahead".
  assert.equal(bearingOf(11, -2.5, 8.2), "ahead_right");
  assert.equal(bearingOf(8, -2.5, 8.2), "right");
  assert.equal(bearingOf(11, -1.5, 8.2), "ahead");
  // 62 m behind and 10 m left: 9 degrees from straight behind.
  assert.equal(bearingOf(-62, 10, 4.6), "behind_left");
  assert.equal(bearingOf(-2, 0.5, 1), "behind");
});
