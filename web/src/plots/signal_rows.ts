// Signal rows of the timeline: the signals that the rule reads, beside the four plots of LABELING.md 6.
import type { MatchedCondition, SceneView } from "../api/types.ts";
import { type Column, columnOf } from "./series.ts";
import { type Scale, scaled, scaleOf, type SpeedUnit } from "./units.ts";

/** Signals that the four plots and the meta action rows already show. */
const SHOWN = new Set(["ego.speed", "ego.forward_speed", "ego.accel", "ego.steering", "ego.turn_signal", "ego.meta_longitudinal", "ego.meta_lateral"]);

export interface SignalRow {
  name: string;
  column: Column | null;
  /** How its numbers are shown. */
  scale: Scale;
  /** What it means, in the reader's language. */
  meaning: string;
  /** Conditions of the rule on this signal, with measured values. */
  note: string | undefined;
}

/**
 * `target_vehicle.lateral_offset > 0.5m` is about `target.lateral_offset`: messages use another name for the target.
 */
function speaksOf(condition: string, signal: string): boolean {
  const subject = /^[a-z_][\w.]*/i.exec(condition)?.[0] ?? "";
  const last = (s: string): string => s.slice(s.lastIndexOf(".") + 1);
  return subject === signal || (last(subject) === last(signal) && subject.split("_")[0] === signal.split(".")[0]);
}

/** The unit of the number in a condition: `m` for `> 0.5m`; empty for pure numbers and categories. */
export function unitOf(condition: string): string {
  return /\d\s*(km\/h|mph|m\/s[23]|m\/s|rad\/s|deg\/s|1\/m|km|cm|min|ms|deg|rad|m|s|g|%)(?![\w/])/.exec(condition)?.[1] ?? "";
}

/** A condition with the measured value in the condition's unit. */
export function measured(c: MatchedCondition): string {
  const v = c.actual_value;
  if (v === null || v === undefined) return `${c.condition} (?)`;
  if (typeof v !== "number") return `${c.condition} (${String(v)})`;
  return `${c.condition} (${`${Math.round(v * 1000) / 1000} ${unitOf(c.condition)}`.trim()})`;
}

/** Conditions of the rule on any of these signals with measured values; undefined without any. */
export function noteOf(signals: readonly string[], conditions: readonly MatchedCondition[]): string | undefined {
  const notes = conditions.filter((c) => signals.some((s) => speaksOf(c.condition, s))).map(measured);
  return notes.length > 0 ? notes.join("; ") : undefined;
}

export function signalRows(
  scene: SceneView,
  asked: readonly string[],
  conditions: readonly MatchedCondition[],
  reader: { speeds: SpeedUnit; lang: "zh" | "en" },
): SignalRow[] {
  const names = [...asked.filter((n) => n in scene.signals), ...Object.keys(scene.signals).filter((n) => !asked.includes(n))];
  return names
    .filter((name) => !SHOWN.has(name))
    .map((name) => {
      const about = scene.about[name];
      // Lateral speeds are tenths of a meter per second, and rules state them in m/s.
      const scale = scaleOf(about?.unit, name.includes("lateral") ? "m/s" : reader.speeds);
      const column = columnOf(scene.signals[name] ?? [], about?.kind ?? "category");
      return {
        name,
        column: column?.kind === "line" ? { ...column, values: scaled(column.values, scale) } : column,
        scale,
        meaning: about?.meaning[reader.lang] ?? "",
        note: noteOf([name], conditions),
      };
    });
}
