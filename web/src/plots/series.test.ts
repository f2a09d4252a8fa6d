// Rows of the board: unknown is a gap, never 0; axes end at round numbers. Expected values by hand.
import assert from "node:assert/strict";
import { test } from "vitest";
import { bandPath, bounds, columnOf, linePath, percent, roundStep, runs, runSpan, split, ticks, withoutOutliers } from "./series.ts";

const span = { from: 0, to: 4 };

test("a false value at the end does not flatten the curve", () => {
  const driven = Array.from({ length: 100 }, (_, n) => 30 + n / 50);
  assert.deepEqual(bounds(withoutOutliers([...driven, null, -100]), 1), bounds(driven, 1));
  // What brakes hard at last is what the keyframe is about: the last of 40 values, on a 7 times longer axis.
  const braked = [...Array.from({ length: 38 }, (_, n) => (n % 2) / 2), -0.5, -4.5];
  assert.ok(bounds(withoutOutliers(braked), 1).low > -4.5 && bounds(withoutOutliers(braked, 39), 1).low <= -4.5);
  // Braking to a stop is no outlier.
  const braking = [...Array.from({ length: 60 }, () => 30), ...Array.from({ length: 40 }, (_, n) => 30 * (1 - n / 39))];
  assert.equal(bounds(withoutOutliers(braking), 1).low, 0);
});

test("a line has a gap where the value is unknown", () => {
  assert.equal(linePath([0, 1, 2, 3, 4], [0, 10, null, 5, 5], span, 0, 10), "M0.0 100.0L250.0 0.0M750.0 50.0L1000.0 50.0");
  assert.equal(linePath([0, 1, 2], [null, 5, null], span, 0, 10), "M250.0 50.0h1", "a lone value is a dot");
  assert.equal(linePath([0, 1], [Infinity, null], span, 0, 10), "");
  assert.equal(percent({ from: 2, to: 2 }, 2), 0);
});

test("bounds are round, and a flat line is not blown up", () => {
  assert.deepEqual(bounds([13.2, 47], 20, 0), { low: 0, high: 60 });
  assert.deepEqual(bounds([0.01, 0.02], 4), { low: -2, high: 3 });
  assert.deepEqual(bounds([-0.2, 47], 20, 0), { low: 0, high: 60 }, "noise under the floor");
  assert.deepEqual(bounds([-0.2, 0.1], 20, 0), { low: 0, high: 20 }, "noise of what stands");
  assert.deepEqual(bounds([-12, 28], 20, 0), { low: -20, high: 30 }, "reversing is none");
  assert.deepEqual(bounds([null], 2), { low: -1, high: 1 });
  assert.deepEqual([roundStep(0.13), roundStep(3), roundStep(70)].map((v) => Math.round(v * 10) / 10), [0.2, 5, 100]);
});

test("runs end where the value changes or is unknown", () => {
  const r = runs(["a", "a", null, "a", "b"]);
  assert.deepEqual(r, [
    { value: "a", from: 0, to: 2 },
    { value: "a", from: 3, to: 4 },
    { value: "b", from: 4, to: 5 },
  ]);
  assert.deepEqual(runSpan([0, 1, 2, 3, 4], { from: 0, to: 2 }), { from: 0, to: 2 });
  assert.deepEqual(runSpan([0, 1, 2, 3, 4], { from: 4, to: 5 }), { from: 4, to: 4.5 });
});

test("ticks are whole steps inside the span", () => {
  assert.deepEqual(ticks({ from: -2.2, to: 6 }, 8), [-2, 0, 2, 4, 6]);
});

test("a column is what the server says it is; none is endless, unknown a gap", () => {
  assert.equal(columnOf([null, null], "number"), null);
  assert.deepEqual(columnOf([null, true], "flag"), { kind: "flags", values: [null, true] });
  assert.deepEqual(columnOf([1, "none", null], "number"), { kind: "line", values: [1, Infinity, null] });
  assert.deepEqual(columnOf(["none", "none"], "number"), { kind: "line", values: [Infinity, Infinity] });
  assert.deepEqual(columnOf(["none", "car"], "category"), { kind: "words", values: ["none", "car"] });
});

test("what is uncertain is a line of its own that meets the other one", () => {
  assert.deepEqual(split([1, 2, 3, 4, 5], [[3, 5]]), { certain: [1, 2, 3, null, null], uncertain: [null, null, 3, 4, 5] });
  // In Stage II the curve goes on.
  assert.deepEqual(split([1, 2, 3, 4], [[1, 2]]), { certain: [1, null, 3, 4], uncertain: [1, 2, 3, null] });
  assert.deepEqual(split([1, 2], []), { certain: [1, 2], uncertain: [] });
});

test("a band is one standard deviation to either side, cut at the axis, with a gap where one is unknown", () => {
  // x: 0, 250, 500 of 1000; y of 0 to 10 on 100 down to 0.
  assert.equal(bandPath([0, 1, 2], [5, 5, 9], [1, 2, 4], span, 0, 10), "M0.0 40.0L250.0 30.0L500.0 0.0L500.0 50.0L250.0 70.0L0.0 60.0Z");
  assert.equal(bandPath([0, 1, 2, 3], [5, null, 5, 5], [1, 1, 1, null], span, 0, 10), "", "one moment has no area");
});
