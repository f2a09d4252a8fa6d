// What a number on the wire is for people. Factors by definition: 1 m/s = 3.6 km/h, pi rad = 180 degrees.
import assert from "node:assert/strict";
import { test } from "vitest";
import { scaled, scaleOf, uncertainText, withUnit } from "./units.ts";

test("speeds are shown in the unit that the reader chose", () => {
  assert.equal(scaleOf("m/s", "km/h").unit, "km/h");
  assert.deepEqual(scaled([10, null, Infinity], scaleOf("m/s", "km/h")), [36, null, Infinity]);
  assert.deepEqual(scaled([10, null], scaleOf("m/s", "m/s")), [10, null]);
});

test("angles are shown in degrees, powers as people write them", () => {
  const half = scaled([Math.PI], scaleOf("rad", "km/h"))[0] ?? 0;
  assert.ok(Math.abs(half - 180) < 1e-9);
  assert.equal(scaleOf("rad/s", "m/s").unit, "°/s");
  assert.equal(scaleOf("m/s2", "m/s").unit, "m/s²");
});

test("a unit follows its number after a space, a degree sign without one (SI brochure, 5.4.3)", () => {
  assert.equal(withUnit("18.2", "km/h"), "18.2 km/h");
  assert.equal(withUnit("−4.5", "°"), "−4.5°");
  assert.equal(withUnit("3", ""), "3");
});

test("pure numbers have no unit, and an unknown unit is not dropped", () => {
  assert.equal(scaleOf(null, "km/h").unit, "");
  assert.equal(scaleOf("kg", "km/h").unit, "kg");
  assert.equal(scaleOf("kg", "km/h").by, 1);
});

test("an uncertain value says so, with its deviation where that is known", () => {
  assert.equal(uncertainText("1.43", 0.804, 2), "≈ 1.43 ± 0.80");
  assert.equal(uncertainText("−0.3", null, 1), "≈ −0.3");
  assert.equal(uncertainText("1.43", 0.001, 2), "≈ 1.43", "a deviation of 0.00 would say that it is certain");
});
