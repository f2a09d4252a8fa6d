// Rows that the labelling screen shows of a scene: the four plots of LABELING.md 6 and the signals that the rule reads.
import type { MatchedCondition, SceneView } from "../api/types.ts";
import { type Column, columnOf } from "./series.ts";

/** Signals that the four plots and the meta rows show already. */
const SHOWN = new Set(["ego.speed", "ego.forward_speed", "ego.accel", "ego.steering", "ego.turn_signal", "ego.meta_longitudinal", "ego.meta_lateral"]);

export interface SignalRow {
  name: string;
  column: Column | null;
  /** Conditions of the rule that speak of it, with what they measured. */
  note?: string;
}

/** `target_vehicle.lateral_offset > 0.5m` speaks of `target.lateral_offset`: the target has another name in messages. */
function speaksOf(condition: string, signal: string): boolean {
  const subject = /^[a-z_][\w.]*/i.exec(condition)?.[0] ?? "";
  const last = (s: string): string => s.slice(s.lastIndexOf(".") + 1);
  return subject === signal || (last(subject) === last(signal) && subject.split("_")[0] === signal.split(".")[0]);
}

export function measured(c: MatchedCondition): string {
  const v = c.actual_value;
  const text = typeof v === "number" ? String(Math.round(v * 1000) / 1000) : v === null || v === undefined ? "?" : String(v);
  return `${c.condition} (${text})`;
}

export function signalRows(scene: SceneView, asked: readonly string[], conditions: readonly MatchedCondition[]): SignalRow[] {
  const names = [...asked.filter((n) => n in scene.signals), ...Object.keys(scene.signals).filter((n) => !asked.includes(n))];
  return names
    .filter((name) => !SHOWN.has(name))
    .map((name) => {
      const notes = conditions.filter((c) => speaksOf(c.condition, name)).map(measured);
      const row: SignalRow = { name, column: columnOf(scene.signals[name] ?? []) };
      return notes.length > 0 ? { ...row, note: notes.join("; ") } : row;
    });
}
