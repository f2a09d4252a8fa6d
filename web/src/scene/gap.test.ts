// Distances of boxes, by hand.
import assert from "node:assert/strict";
import { test } from "vitest";
import { gapBetween } from "./gap.ts";

const box = (x: number, y: number, heading: number, length = 4, width = 2): Parameters<typeof gapBetween>[0] => ({ pose: { x, y, heading }, length, width });

test("the gap is between the sides, not between the centers", () => {
  assert.equal(gapBetween(box(0, 0, 0), box(10, 0, 0, 12, 2)), 2);
  assert.equal(gapBetween(box(0, 0, 0), box(0, 5, 0)), 3);
  assert.ok(Math.abs(gapBetween(box(0, 0, 0), box(0, 5, Math.PI / 2)) - 2) < 1e-9);
  // Corner to corner: 3 along, 4 across.
  assert.equal(gapBetween(box(0, 0, 0), box(7, 6, 0)), 5);
  assert.equal(gapBetween(box(0, 0, 0), box(1, 0.5, 0.3)), 0);
  assert.equal(gapBetween(box(0, 0, 0, 20, 20), box(1, 1, 1)), 0, "one inside the other");
});
