// Rows of the rule's signals: units, what the rule measured. Conditions as DATA_FORMAT.md 5.1 writes them.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { SceneView } from "../api/types.ts";
import { measured, noteOf, signalRows, unitOf } from "./signal_rows.ts";

test("a condition's value is told in the condition's unit", () => {
  assert.equal(measured({ condition: "target_vehicle.lateral_offset > 0.5m", actual_value: 0.8249 }), "target_vehicle.lateral_offset > 0.5m (0.825 m)");
  assert.equal(measured({ condition: "ego.speed > 20 km/h for 2 s", actual_value: 31 }), "ego.speed > 20 km/h for 2 s (31 km/h)");
  assert.equal(measured({ condition: "light.state == red", actual_value: "red" }), "light.state == red (red)");
  assert.equal(measured({ condition: "ttc < 5s", actual_value: null }), "ttc < 5s (?)");
  assert.deepEqual(["x > 2", "x > 2 m/s2", "x < 10deg/s", "x >= 50%"].map(unitOf), ["", "m/s2", "deg/s", "%"]);
});

test("a condition goes to the row of its signal, whatever the target is called", () => {
  const conditions = [
    { condition: "target_vehicle.gap < 30m", actual_value: 12 },
    { condition: "ego.speed > 5m/s", actual_value: 9 },
  ];
  assert.equal(noteOf(["target.gap"], conditions), "target_vehicle.gap < 30m (12 m)");
  assert.equal(noteOf(["ego.speed", "ego.forward_speed"], conditions), "ego.speed > 5m/s (9 m/s)");
  assert.equal(noteOf(["target.ttc"], conditions), undefined);
});

test("rows are in the reader's units and language", () => {
  const about = (unit: string | null) => ({ kind: "number" as const, unit, meaning: { zh: "中", en: "en" } });
  const scene = {
    signals: { "target.lane_lateral_speed": [0.4, 0], "target.speed": [10, null], "target.heading_change": [Math.PI / 2, 0], "ego.accel": [1, 1] },
    about: { "target.lane_lateral_speed": about("m/s"), "target.speed": about("m/s"), "target.heading_change": about("rad"), "ego.accel": about("m/s2") },
  } as unknown as SceneView;
  const rows = signalRows(scene, ["target.heading_change"], [], { speeds: "km/h", lang: "zh" });
  assert.deepEqual(rows.map((r) => [r.name, r.scale.unit, r.meaning]), [["target.heading_change", "°", "中"], ["target.lane_lateral_speed", "m/s", "中"], ["target.speed", "km/h", "中"]], "what the rule reads comes first; the plots' own signals have rows already");
  assert.deepEqual(rows[2]?.column?.values, [36, null]);
});
