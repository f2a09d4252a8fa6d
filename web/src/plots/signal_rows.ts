// Signal rows of the timeline: the signals that the rule reads, beside the four plots of LABELING.md 6. Pure.
import type { MatchedCondition, SceneView } from "../api/types.ts";
import { decidingRank, noteOf, thresholdsOf } from "./conditions.ts";
import { type Column, columnOf, type Intervals } from "./series.ts";
import { type Scale, scaled, scaleOf, type SpeedUnit } from "./units.ts";

/** Signals that the four plots and the meta action rows already show. */
const SHOWN = new Set([
  "ego.speed", "ego.forward_speed", "ego.accel", "ego.steering", "ego.turn_signal", "ego.meta_longitudinal", "ego.meta_lateral",
]);

/** Times to an event beyond this decide nothing: the axis ends here, s. */
const TIME_AXIS_MAX_S = 10;

export interface SignalRow {
  /** Signal id. */
  id: string;
  /** In the reader's language, as the head of its row. */
  name: string;
  /** The same within a sentence. */
  title: string;
  column: Column | null;
  /** How its numbers are shown. */
  scale: Scale;
  /** In the reader's language, with the id. */
  meaning: string;
  /** The rule reads it. */
  inRule: boolean;
  /** Unknown, or known to be absent, throughout. */
  isEmpty: boolean;
  /** What the rule compared it with, with measured values. */
  note: string | undefined;
  /** Of the rule, in the shown unit. */
  thresholds: readonly number[];
  /** The axis is from 0 to this, in the shown unit; without it the axis fits the values. */
  axisMax: number | undefined;
  /** Standard deviations, in the shown unit. */
  deviations: readonly (number | null)[] | undefined;
  /** Where the values are uncertain. */
  uncertain: Intervals;
}

/** Time to collision, headway and other times to an event. */
const isTimeToEvent = (id: string, unit: string | null | undefined): boolean => unit === "s" && /(^|[._])(ttc|thw|time_to)(_|$)/.test(id);

/** Where the numbers of a signal are uncertain. */
export const uncertainOf = (scene: SceneView, id: string): Intervals => (scene.uncertain?.[id] ?? []) as [number, number][];

/** How certain the numbers of a signal are, in the unit of `scale`. */
export function certaintyOf(scene: SceneView, id: string, scale: Scale): Pick<SignalRow, "deviations" | "uncertain"> {
  const deviations = scene.deviations?.[id];
  return { deviations: deviations && scaled(deviations, scale), uncertain: uncertainOf(scene, id) };
}

export function signalRows(
  scene: SceneView,
  read: readonly string[],
  conditions: readonly MatchedCondition[],
  reader: { speeds: SpeedUnit; lang: "zh" | "en" },
): SignalRow[] {
  // What the rule compares with a number decides most: first, what belongs to the class itself before what it shares.
  // Then what else it reads, then the rest; of each what has a value anywhere before what has none.
  const deciding = new Map(Object.keys(scene.signals).map((id) => [id, decidingRank(id, conditions)]));
  const compared = (id: string): number => deciding.get(id) ?? Infinity;
  const rank = (id: string): number => (compared(id) < Infinity ? 0 : read.includes(id) ? 1 : 2);
  const before = (a: number, b: number): number => (a < b ? -1 : a > b ? 1 : 0);
  const isEmpty = (id: string): number => ((scene.signals[id] ?? []).every((v) => v === null || v === "none") ? 1 : 0);
  // Stage I is not told the conditions: of what the rule reads a time to an event decides most, then numbers of the
  // target, a flag least.
  const kind = (id: string): number => {
    const about = scene.about[id];
    return conditions.length > 0 || !read.includes(id) ? 0 : isTimeToEvent(id, about?.unit) ? 0 : about?.kind !== "number" ? 3 : id.startsWith("target.") ? 1 : 2;
  };
  // Where the log has no steering, the plot of the turn is the yaw rate.
  const isPlotted = (id: string): boolean => SHOWN.has(id) || (id === "ego.yaw_rate" && !(scene.ego?.steering.some((v) => v !== null) ?? false));
  const position = (id: string): number => (read.includes(id) ? read.indexOf(id) : Infinity);
  return Object.keys(scene.signals)
    .sort(
      (a, b) =>
        rank(a) - rank(b) || isEmpty(a) - isEmpty(b) || before(compared(a), compared(b)) || kind(a) - kind(b) || before(position(a), position(b)),
    )
    .filter((id) => !isPlotted(id))
    .map((id) => {
      const about = scene.about[id];
      // Lateral speeds are tenths of a meter per second, and rules state them in m/s.
      const ofUnit = scaleOf(about?.unit, id.includes("lateral") ? "m/s" : reader.speeds);
      const column = columnOf(scene.signals[id] ?? [], about?.kind ?? "category");
      // Pure numbers that are all whole are counts.
      const isCount = ofUnit.unit === "" && column?.kind === "line" && column.values.every((v) => v === null || !Number.isFinite(v) || Number.isInteger(v));
      const scale = isCount ? { ...ofUnit, digits: 0 } : ofUnit;
      const [title, meaning] = [about?.title[reader.lang] ?? "", about?.meaning[reader.lang] ?? ""];
      return {
        id,
        name: title ? title[0]?.toUpperCase() + title.slice(1) : id,
        title: title || id,
        column: column?.kind === "line" ? { ...column, values: scaled(column.values, scale) } : column,
        scale,
        meaning: [meaning, id].filter(Boolean).join("\n"),
        inRule: rank(id) < 2,
        isEmpty: isEmpty(id) === 1,
        note: noteOf([id], conditions, reader.lang, scale),
        thresholds: thresholdsOf([id], conditions, scale),
        ...certaintyOf(scene, id, scale),
        axisMax: isTimeToEvent(id, about?.unit) ? TIME_AXIS_MAX_S * scale.by : undefined,
      };
    });
}
