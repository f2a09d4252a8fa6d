// Conditions of a rule as the timeline shows them: thresholds on axes, comparisons with the measured value. Pure.
import type { MatchedCondition } from "../api/types.ts";
import { type Scale, withUnit } from "./units.ts";

/** `target.gap < 30m`, `0m < target.gap`, `abs(ego.accel) < 1m/s2`: one signal compared with one number. */
export interface Comparison {
  signal: string;
  /** The absolute value of the signal is compared. */
  absolute: boolean;
  operator: "<" | "<=" | ">" | ">=" | "==" | "!=";
  /** The number in the API's base unit. */
  value: number;
  /** The number and its unit as the rule writes them. */
  text: string;
  /** The unit as the rule writes it; empty for pure numbers. */
  unit: string;
}

/** Base units per unit of the rule language (docs: rules). */
const IN_BASE: Record<string, number> = {
  "": 1, m: 1, cm: 0.01, km: 1000, s: 1, ms: 0.001, min: 60, "m/s": 1, "km/h": 1 / 3.6, mph: 0.44704,
  "m/s2": 1, "m/s3": 1, rad: 1, deg: Math.PI / 180, "rad/s": 1, "deg/s": Math.PI / 180, "1/m": 1, "/m": 1, "%": 0.01,
};
const FLIPPED = { "<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!=" } as const;

const NUMBER = String.raw`(-?\d+(?:\.\d+)?)\s*([a-z/%\d]*)`;
const SIGNAL = String.raw`(abs\()?([a-z_][a-z0-9_]*(?:\.[a-z0-9_]+)*)\)?`;
const OPERATOR = "(<=|>=|==|!=|<|>)";
const SIGNAL_FIRST = new RegExp(`^${SIGNAL}\\s*${OPERATOR}\\s*${NUMBER}$`, "i");
const NUMBER_FIRST = new RegExp(`^${NUMBER}\\s*${OPERATOR}\\s*${SIGNAL}$`, "i");

/** The comparison that a condition is; null for anything else, such as a combination of several. */
export function comparison(condition: string): Comparison | null {
  const a = SIGNAL_FIRST.exec(condition);
  const b = a ? null : NUMBER_FIRST.exec(condition);
  const [abs, signal, operator, digits, unit] = a ? [a[1], a[2], a[3], a[4], a[5]] : b ? [b[4], b[5], b[3], b[1], b[2]] : [];
  const factor = IN_BASE[unit ?? ""];
  if (!signal || !operator || !digits || factor === undefined) return null;
  const op = operator as Comparison["operator"];
  return {
    signal,
    absolute: abs !== undefined,
    operator: a ? op : FLIPPED[op],
    value: Number(digits) * factor,
    text: `${digits} ${unit ?? ""}`.trim(),
    unit: unit ?? "",
  };
}

/** `target_vehicle.gap` in messages is the signal `target.gap`. */
export function isAbout(subject: string, signal: string): boolean {
  const last = (name: string): string => name.slice(name.lastIndexOf(".") + 1);
  return subject === signal || (last(subject) === last(signal) && subject.split("_")[0] === signal.split(".")[0]);
}

/** The comparisons of a rule with any of these signals, with the measured values. */
function comparisonsOf(signals: readonly string[], conditions: readonly MatchedCondition[]): { c: Comparison; actual: unknown }[] {
  return conditions.flatMap(({ condition, actual_value }) => {
    const c = comparison(condition);
    return c && signals.some((signal) => isAbout(c.signal, signal)) ? [{ c, actual: actual_value }] : [];
  });
}

/** Thresholds of these signals in the shown unit, ascending, each once; both signs for absolute values. */
export function thresholdsOf(signals: readonly string[], conditions: readonly MatchedCondition[], scale: Scale): number[] {
  const values = comparisonsOf(signals, conditions).flatMap(({ c }) => {
    const shown = Math.round(c.value * scale.by * 1e6) / 1e6;
    return c.absolute ? [-shown, shown] : [shown];
  });
  return [...new Set(values)].sort((a, b) => a - b);
}

/** Units as people write them, by the rule language's spelling; others are the same. */
const SHOWN_UNITS: Record<string, string> = {
  deg: "°", "deg/s": "°/s", "m/s2": "m/s²", "m/s3": "m/s³", "/m": "1/m",
};
const SIGNS: Record<Comparison["operator"], string> = { "<": "<", "<=": "≤", ">": ">", ">=": "≥", "==": "=", "!=": "≠" };

/**
 * A comparison without its signal, and the measured value: `< 30 m (12 m)`; of an absolute value, `within ±30 m`;
 * without `actual` the limit alone. In the unit of `scale` where one is given, else in the rule's.
 */
export function comparisonText(c: Comparison, actual: unknown, reader: "zh" | "en", scale?: Scale): string {
  const unit = scale?.unit ?? SHOWN_UNITS[c.unit] ?? c.unit;
  const factor = scale ? (IN_BASE[c.unit] ?? 1) * scale.by : 1;
  const shown = (number: number, digits: number, inUnit = unit): string =>
    withUnit(String(Math.round(number * factor * 10 ** digits) / 10 ** digits).replace("-", "−"), inUnit);
  // Another limit follows, in the same unit where that is the row's.
  const limitUnit = actual === undefined && scale ? "" : unit;
  const limit = shown(c.value / (IN_BASE[c.unit] ?? 1), 3, limitUnit);
  const compared = c.absolute ? aboutZero(c.operator, limit, reader) : `${SIGNS[c.operator]} ${limit}`;
  if (actual === undefined) return compared;
  if (typeof actual !== "number") return `${compared} (?)`;
  // As many digits as the row's value has beside it; of what is greater, fewer tell as much. More where it would look
  // like the limit that it is not.
  const wanted = scale ? Math.min(scale.digits, Math.abs(actual * factor) >= 10 ? 1 : 3) : 3;
  const differs = Math.abs(actual) !== Math.abs(c.value / (IN_BASE[c.unit] ?? 1));
  const alike = (digits: number): boolean => shown(Math.abs(actual), digits) === shown(Math.abs(c.value / (IN_BASE[c.unit] ?? 1)), 3);
  let digits = wanted;
  while (differs && digits < 3 && alike(digits)) digits++;
  const unmet = meets(c, actual * (IN_BASE[c.unit] ?? 1)) ? "" : reader === "zh" ? "，此刻不满足" : ", not met here";
  return `${compared} (${shown(actual, digits)}${unmet})`;
}

/**
 * Does a measured value, in base units, fulfill the comparison? One of several that a rule accepts may be listed with a
 * value that does not.
 */
function meets(c: Comparison, measured: number): boolean {
  const value = c.absolute ? Math.abs(measured) : measured;
  const off = value - c.value;
  // Values are rounded to four decimals.
  const near = Math.abs(off) <= 1e-4 * Math.max(1, IN_BASE[c.unit] ?? 1);
  switch (c.operator) {
    case "<":
    case "<=":
      return near || off < 0;
    case ">":
    case ">=":
      return near || off > 0;
    case "==":
      return near;
    case "!=":
      return !near;
  }
}

/** A limit of an absolute value in words. */
function aboutZero(operator: Comparison["operator"], limit: string, reader: "zh" | "en"): string {
  if (operator === "==" || operator === "!=") return `${SIGNS[operator]} ±${limit}`;
  const inside = operator.startsWith("<");
  if (reader === "zh") return inside ? `±${limit} 以内` : `超出 ±${limit}`;
  return `${inside ? "within" : "beyond"} ±${limit}`;
}

/** What the rule compared these signals with; undefined without any comparison. */
export function noteOf(
  signals: readonly string[],
  conditions: readonly MatchedCondition[],
  reader: "zh" | "en",
  scale?: Scale,
): string | undefined {
  // One value that is compared several times is said once, after the last of its limits; `>= 0` says nothing beside
  // `> 0`.
  const every = comparisonsOf(signals, conditions);
  const stricter = (a: Comparison, b: Comparison): boolean =>
    a !== b && a.signal === b.signal && a.absolute === b.absolute && a.value === b.value && `${a.operator}=` === b.operator;
  const found = every.filter(({ c }) => !every.some((other) => stricter(other.c, c)));
  const isSaidLater = (actual: unknown, i: number): boolean => found[i + 1] !== undefined && found[i + 1]?.actual === actual;
  const notes = found.map(({ c, actual }, i) => comparisonText(c, isSaidLater(actual, i) ? undefined : (actual ?? null), reader, scale));
  return notes.length > 0 ? notes.join("; ") : undefined;
}

/**
 * How much a rule's comparison with `signal` decides, the most first: the conditions of the class itself come last in
 * a rule, after those that it shares with its siblings; a comparison with 0 mostly says that there is a value at all.
 * `Infinity` where the rule does not compare it.
 */
export function decidingRank(signal: string, conditions: readonly MatchedCondition[]): number {
  const ranks = conditions.map(({ condition }, at) => {
    const c = comparison(condition);
    if (!c || !isAbout(c.signal, signal)) return Infinity;
    return conditions.length - at + (c.value === 0 ? conditions.length : 0);
  });
  return Math.min(Infinity, ...ranks);
}
