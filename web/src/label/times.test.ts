// Times of labels and frames of scenes are compared in nanoseconds, not in doubles.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { SceneView } from "../api/types.ts";
import { clockOf, frameNear, secondOf, signed } from "./times.ts";

const times = ["2026-01-15T10:30:09.300000001Z", "2026-01-15T10:30:09.400000001Z", "2026-01-15T10:30:09.500000001Z"];
const clock = clockOf({ times, t_s: [-0.1, 0, 0.1], clip_frames: [-1, 0, 1], keyframe_index: 1 } as unknown as SceneView);

test("a moment of the label is a second of the scene", () => {
  assert.equal(secondOf(clock, "2026-01-15T10:30:09.400000001Z"), 0);
  assert.equal(secondOf(clock, "2026-01-15T10:30:07.400000001Z"), -2);
  assert.equal(secondOf(clock, null), null);
  assert.equal(secondOf(clock, "soon"), null);
});

test("a second of the scene is its nearest frame", () => {
  assert.equal(frameNear(clock, -9), 0);
  assert.equal(frameNear(clock, 0.04), 1);
  assert.equal(frameNear(clock, 0.06), 2);
  assert.equal(frameNear(clock, 9), 2);
});

test("differences are written with their sign", () => {
  assert.deepEqual([signed(-0.26), signed(0.3), signed(0.04), signed(-0.04)], ["−0.3", "+0.3", "0.0", "0.0"]);
});
