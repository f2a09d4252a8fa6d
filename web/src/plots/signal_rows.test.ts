// Rows of the rule's signals: names, order, units, thresholds, axes.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { SceneView } from "../api/types.ts";
import { signalRows } from "./signal_rows.ts";

const about = (unit: string | null, zh: string) => ({ kind: "number" as const, unit, title: { zh: zh.split(/[，。：]/)[0] ?? zh, en: `${zh} en` }, meaning: { zh, en: `${zh} en` } });
const scene = {
  signals: {
    "target.lane_lateral_speed": [0.4, 0],
    "target.speed": [10, null],
    "target.heading_change": [Math.PI / 2, 0],
    "target.ttc": [40, 2],
    "ego.accel": [1, 1],
  },
  about: {
    "target.lane_lateral_speed": about("m/s", "横向速度，朝向车道"),
    "target.speed": about("m/s", "速度。地面"),
    "target.heading_change": about("rad", "航向变化"),
    "target.ttc": about("s", "碰撞时间：沿路径"),
    "ego.accel": about("m/s2", "加速度"),
  },
} as unknown as SceneView;

test("what the rule reads comes first; rows have the reader's names and units; the plots' own signals have rows already", () => {
  const rows = signalRows(scene, ["target.heading_change"], [], { speeds: "km/h", lang: "zh" });
  assert.deepEqual(rows.map((r) => [r.id, r.name, r.scale.unit, r.inRule]), [
    ["target.heading_change", "航向变化", "°", true],
    ["target.lane_lateral_speed", "横向速度", "m/s", false],
    ["target.speed", "速度", "km/h", false],
    ["target.ttc", "碰撞时间", "s", false],
  ]);
  assert.deepEqual(rows[2]?.column?.values, [36, null]);
});

test("signals that the rule compares with a number come before the others that it reads", () => {
  const conditions = [{ condition: "target.ttc < 3s", actual_value: 2.48 }];
  const rows = signalRows(scene, ["target.speed", "target.ttc"], conditions, { speeds: "km/h", lang: "zh" });
  assert.deepEqual(rows.map((r) => [r.id, r.inRule]), [
    ["target.ttc", true],
    ["target.speed", true],
    ["target.lane_lateral_speed", false],
    ["target.heading_change", false],
  ]);
});

test("without conditions, as in Stage I, times to an event come first of what the rule reads", () => {
  const rows = signalRows(scene, ["target.speed", "target.ttc"], [], { speeds: "km/h", lang: "zh" });
  assert.deepEqual(rows.slice(0, 2).map((r) => r.id), ["target.ttc", "target.speed"]);
});

test("without conditions numbers of the target come before those of other vehicles", () => {
  const both = { ...scene, signals: { "lead.gap": [47, 46], "target.speed": [10, 9] }, about: { ...scene.about, "lead.gap": about("m", "净距") } } as unknown as SceneView;
  const rows = signalRows(both, ["lead.gap", "target.speed"], [], { speeds: "km/h", lang: "zh" });
  assert.deepEqual(rows.map((r) => r.id), ["target.speed", "lead.gap"]);
});

test("times to an event have an axis from 0 to 10 s, other signals fit their values; thresholds are drawn", () => {
  const rows = signalRows(scene, [], [{ condition: "target.ttc < 3s", actual_value: 2.48 }], { speeds: "km/h", lang: "en" });
  const ttc = rows.find((r) => r.id === "target.ttc");
  assert.deepEqual([ttc?.axisMax, ttc?.thresholds, ttc?.note], [10, [3], "< 3 s (2.48 s)"]);
  assert.equal(rows.find((r) => r.id === "target.speed")?.axisMax, undefined);
});

test("deviations are in the shown unit; where a rate is uncertain is told of the signal alone", () => {
  const spread = { ...scene, deviations: { "target.speed": [0.5, null] }, uncertain: { "target.heading_change": [[1, 2]] } } as unknown as SceneView;
  const rows = signalRows(spread, [], [], { speeds: "km/h", lang: "zh" });
  const of = (id: string) => rows.find((r) => r.id === id);
  assert.deepEqual(of("target.speed")?.deviations, [1.8, null]);
  assert.deepEqual(of("target.speed")?.uncertain, []);
  assert.deepEqual(of("target.heading_change")?.uncertain, [[1, 2]]);
});

test("the yaw rate has one row: the plot of the turn, where the log has no steering", () => {
  const turn = { signals: { "ego.yaw_rate": [0.1] }, about: { "ego.yaw_rate": about("rad/s", "自车横摆角速度") } };
  const ids = (steering: (number | null)[]): string[] =>
    signalRows({ ...turn, ego: { steering } } as unknown as SceneView, [], [], { speeds: "km/h", lang: "zh" }).map((r) => r.id);
  assert.deepEqual(ids([null]), []);
  assert.deepEqual(ids([0.2]), ["ego.yaw_rate"]);
});
