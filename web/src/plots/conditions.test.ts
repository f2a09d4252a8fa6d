// Conditions of rules on the timeline. Conditions as `whyroad mine` writes them; factors by definition (1 m/s = 3.6
// km/h).
import assert from "node:assert/strict";
import { test } from "vitest";
import { comparison, comparisonText, decidingRank, isAbout, noteOf, thresholdsOf } from "./conditions.ts";
import { scaleOf } from "./units.ts";

const met = (condition: string, actual_value: unknown = null) => ({ condition, actual_value });

test("a condition that its value does not meet is not shown as met", () => {
  const c = comparison("abs(ego.accel) < 1m/s2");
  assert.ok(c);
  assert.equal(comparisonText(c, 1.17, "zh"), "±1 m/s² 以内 (1.17 m/s²，此刻不满足)");
  assert.equal(comparisonText(c, -0.6, "zh"), "±1 m/s² 以内 (−0.6 m/s²)");
  const speed = comparison("ego.speed > 36km/h");
  assert.ok(speed);
  assert.doesNotMatch(comparisonText(speed, 40, "en"), /not met/);
  assert.match(comparisonText(speed, 30, "en"), /not met here/);
});

test("one signal compared with one number, also the other way round and as absolute value", () => {
  assert.deepEqual(comparison("target.ttc < 3s"), { signal: "target.ttc", absolute: false, operator: "<", value: 3, text: "3 s", unit: "s" });
  assert.equal(comparison("0m < target.path_longitudinal")?.operator, ">");
  assert.equal(comparison("abs(ego.accel) < 1m/s2")?.absolute, true);
  assert.equal(comparison("target.crossing_angle > 20deg")?.value, (20 * Math.PI) / 180);
  assert.equal(comparison("map.curvature_ahead >= 0.011/m")?.value, 0.011);
});

test("combinations are no comparison", () => {
  for (const c of ["not target.in_ego_lane", "target.is_lead", "abs(ego.speed - target.speed) < 2m/s", "(a.b < 5s) or (c.d < 2s)", "a.b < 5s within 3s"]) {
    assert.equal(comparison(c), null, c);
  }
});

test("thresholds are in the shown unit, each once", () => {
  const conditions = [met("ego.speed > 10m/s"), met("ego.speed > 10 m/s"), met("ego.speed < 72km/h"), met("abs(ego.accel) < 1m/s2")];
  assert.deepEqual(thresholdsOf(["ego.speed"], conditions, scaleOf("m/s", "km/h")), [36, 72]);
  assert.deepEqual(thresholdsOf(["ego.accel"], conditions, scaleOf("m/s2", "km/h")), [-1, 1]);
});

test("a condition goes to the row of its signal, whatever the target is called in messages", () => {
  const conditions = [met("target_vehicle.gap < 30m", 12), met("ego.speed > 5m/s", 9), met("0m < target.gap", 12.3456)];
  assert.equal(noteOf(["target.gap"], conditions, "en"), "< 30 m (12 m); > 0 m (12.346 m)");
  assert.equal(noteOf(["ego.speed", "ego.forward_speed"], conditions, "en"), "> 5 m/s (9 m/s)");
  assert.equal(noteOf(["target.ttc"], conditions, "en"), undefined);
  assert.equal(noteOf(["target.ttc"], [met("target.ttc < 5s", null)], "en"), "< 5 s (?)", "an unknown measurement is not 0");
  const twice = [met("target.gap < 30m", 9.548), met("target.gap < 10m", 9.548)];
  assert.equal(noteOf(["target.gap"], twice, "en"), "< 30 m; < 10 m (9.548 m)", "one value is said once");
  assert.equal(noteOf(["target.gap"], twice, "en", scaleOf("m", "km/h")), "< 30; < 10 m (9.55 m)", "and so is the row's unit");
  assert.ok(!isAbout("lead.gap", "target.gap"));
});

test("a note has the row's unit, and an absolute value is said in words", () => {
  const speed = [met("ego.speed > 10m/s", 20)];
  assert.equal(noteOf(["ego.speed"], speed, "zh", scaleOf("m/s", "km/h")), "> 36 km/h (72 km/h)");
  const gap = [met("target.gap >= 0m", 17.313)];
  assert.equal(noteOf(["target.gap"], gap, "en", scaleOf("m", "km/h")), "≥ 0 m (17.3 m)", "no more digits than tell something");
  const angle = [met("target.crossing_angle >= 60deg", 90)];
  assert.equal(noteOf(["target.crossing_angle"], angle, "en", scaleOf("rad", "km/h")), "≥ 60° (90°)");
  assert.equal(noteOf(["target.crossing_angle"], angle, "en"), "≥ 60° (90°)");
  const aside = [met("abs(target.path_lateral) < 7m", -6.27)];
  assert.equal(noteOf(["target.path_lateral"], aside, "zh"), "±7 m 以内 (−6.27 m)");
  assert.equal(noteOf(["target.path_lateral"], aside, "en"), "within ±7 m (−6.27 m)");
  assert.equal(noteOf(["ego.accel"], [met("abs(ego.accel) >= 2m/s2", 3)], "zh"), "超出 ±2 m/s² (3 m/s²)");
});

test("a limit that another one implies is left out, and a value never looks like the limit that it is not", () => {
  const gap = [met("0m < target.gap", 3.94), met("target.gap >= 0m", 3.94)];
  assert.equal(noteOf(["target.gap"], gap, "zh", scaleOf("m", "km/h")), "> 0 m (3.94 m)");
  const aside = [met("target.path_lateral < 0.8m", 0.7966)];
  assert.equal(noteOf(["target.path_lateral"], aside, "en", scaleOf("m", "km/h")), "< 0.8 m (0.797 m)");
  const same = [met("target.gap <= 2m", 2)];
  assert.equal(noteOf(["target.gap"], same, "en", scaleOf("m", "km/h")), "≤ 2 m (2 m)", "equal is equal");
});

test("the condition of the class itself decides more than what it shares, a comparison with 0 least", () => {
  // As `whyroad mine` writes them for an urgent cut-in.
  const conditions = ["target.wheel_over_line", "target.thw < 2s", "target.gap >= 0m", "target.ttc < 3s"].map((c) => met(c, 1));
  const order = ["target.gap", "target.thw", "target.ttc"].sort((a, b) => decidingRank(a, conditions) - decidingRank(b, conditions));
  assert.deepEqual(order, ["target.ttc", "target.thw", "target.gap"]);
  assert.equal(decidingRank("target.speed", conditions), Infinity);
});
