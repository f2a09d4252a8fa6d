// Content of a timeline row: numbers as a line, categories and flags as strips. Pure.

/** Width and height of a row's drawing; the browser stretches it. */
export const WIDTH = 1000;
export const HEIGHT = 100;

/** Percent of the row below which a stretch has no room for a word. */
export const WIDE_ENOUGH = 5;

export interface Span {
  from: number;
  to: number;
}

/** Position of `t` between `span.from` and `span.to`, in percent. */
export function percent(span: Span, t: number): number {
  return span.to > span.from ? ((t - span.from) / (span.to - span.from)) * 100 : 0;
}

/** The SVG path of a line; a gap where values are unknown or infinite, a dot for an isolated value. */
export function linePath(t: readonly number[], values: readonly (number | null)[], span: Span, low: number, high: number): string {
  const scale = high > low ? HEIGHT / (high - low) : 0;
  const parts: string[] = [];
  let pen = false;
  values.forEach((v, i) => {
    const at = t[i];
    if (v === null || !Number.isFinite(v) || at === undefined) {
      pen = false;
      return;
    }
    const x = (percent(span, at) * WIDTH) / 100;
    const y = HEIGHT - (Math.min(high, Math.max(low, v)) - low) * scale;
    parts.push(`${pen ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`);
    const next = values[i + 1];
    if (!pen && (next === undefined || next === null || !Number.isFinite(next))) parts.push("h1");
    pen = true;
  });
  return parts.join("");
}

/** The SVG path of the band from `values` less `spread` to `values` plus `spread`; a gap where either is unknown. */
export function bandPath(t: readonly number[], values: readonly (number | null)[], spread: readonly (number | null)[], span: Span, low: number, high: number): string {
  const parts: string[] = [];
  const at = (i: number, sign: number): string => {
    const v = Math.min(high, Math.max(low, (values[i] as number) + sign * (spread[i] as number)));
    return `${((percent(span, t[i] as number) * WIDTH) / 100).toFixed(1)} ${(HEIGHT - ((v - low) * HEIGHT) / (high - low)).toFixed(1)}`;
  };
  const isKnown = (i: number): boolean => Number.isFinite(values[i] ?? Number.NaN) && Number.isFinite(spread[i] ?? Number.NaN);
  let from = 0;
  for (let i = 0; i <= values.length; i++) {
    if (i < values.length && isKnown(i)) continue;
    const run = Array.from({ length: i - from }, (_, n) => from + n);
    if (run.length > 1) parts.push(`M${run.map((n) => at(n, 1)).join("L")}L${run.toReversed().map((n) => at(n, -1)).join("L")}Z`);
    from = i + 1;
  }
  return parts.join("");
}

/** Intervals of indices: the first, and one past the last. */
export type Intervals = readonly (readonly [number, number])[];

export const isInside = (intervals: Intervals, i: number): boolean => intervals.some(([from, to]) => i >= from && i < to);

/** The values outside and inside of intervals, for two lines that meet. */
export function split(values: readonly (number | null)[], intervals: Intervals): { certain: readonly (number | null)[]; uncertain: readonly (number | null)[] } {
  if (intervals.length === 0) return { certain: values, uncertain: [] };
  const inside = values.map((_, i) => isInside(intervals, i));
  return {
    certain: values.map((v, i) => (inside[i] ? null : v)),
    uncertain: values.map((v, i) => (inside[i - 1] || inside[i] || inside[i + 1] ? v : null)),
  };
}

export interface Bounds {
  low: number;
  high: number;
}

/** The share of values at either end that may lie outside of the axis, and how much longer it would be with them. */
const OUTLYING = 0.02;
const MUCH_LONGER = 4;

/**
 * The known values without a few that lie far from all others, such as those of one false position. The value at index
 * `kept` is no outlier: the axis has what was decided on.
 */
export function withoutOutliers(values: readonly (number | null)[], kept?: number): readonly number[] {
  const known = values.filter((v): v is number => v !== null && Number.isFinite(v));
  const sorted = [...known].sort((a, b) => a - b);
  const cut = Math.max(1, Math.floor(sorted.length * OUTLYING));
  if (sorted.length < 20) return known;
  const inner = sorted.slice(cut, -cut);
  const length = (of: readonly number[]): number => (of.at(-1) ?? 0) - (of[0] ?? 0);
  if (!(length(inner) > 0 && length(sorted) > MUCH_LONGER * length(inner))) return known;
  const decided = kept === undefined ? null : values[kept];
  return typeof decided === "number" && Number.isFinite(decided) ? [...inner, decided] : inner;
}

/** Least and greatest known value with some room, at least `least` apart, round numbers at both ends. */
export function bounds(values: readonly (number | null)[], least: number, floor?: number): Bounds {
  const known = values.filter((v): v is number => v !== null && Number.isFinite(v));
  let low = known.length > 0 ? Math.min(...known) : 0;
  let high = known.length > 0 ? Math.max(...known) : 0;
  // Noise a little under the floor is cut off rather than given a step of the axis.
  if (floor !== undefined) low = floor - low > 0.05 * Math.max(high - low, least) ? low : floor;
  const missing = least - (high - low);
  if (missing > 0) {
    high += floor === undefined ? missing / 2 : missing;
    low -= floor === undefined ? missing / 2 : 0;
  }
  const step = roundStep((high - low) / 4);
  return { low: Math.floor(low / step + 1e-9) * step, high: Math.ceil(high / step - 1e-9) * step };
}

/** 1, 2 or 5 times a power of ten, at least `step`. */
export function roundStep(step: number): number {
  if (!(step > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(step));
  const digit = step / power;
  return (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10) * power;
}

export interface Run<T> {
  value: T;
  /** First index. */
  from: number;
  /** One past the last. */
  to: number;
}

/** Stretches of equal values; null (unknown) makes none. */
export function runs<T extends string | boolean>(values: readonly (T | null | undefined)[]): Run<T>[] {
  const out: Run<T>[] = [];
  values.forEach((value, i) => {
    if (value === null || value === undefined) return;
    const last = out.at(-1);
    if (last && last.value === value && last.to === i) last.to = i + 1;
    else out.push({ value, from: i, to: i + 1 });
  });
  return out;
}

/** Start and end of a run in seconds: to the next frame, or half a frame past the last. */
export function runSpan(t: readonly number[], run: { from: number; to: number }): Span {
  const from = t[run.from] ?? 0;
  const last = t[run.to - 1] ?? from;
  return { from, to: t[run.to] ?? last + ((t[1] ?? 0.1) - (t[0] ?? 0)) / 2 };
}

/** Whole seconds (or rounder steps) inside the span, about `count` of them. */
export function ticks(span: Span, count: number): number[] {
  const step = Math.max(0.1, roundStep((span.to - span.from) / count));
  const out: number[] = [];
  for (let i = Math.ceil(span.from / step - 1e-9); i * step <= span.to + 1e-9; i++) out.push(i * step);
  return out;
}

export type Column =
  | { kind: "line"; values: (number | null)[] }
  | { kind: "words"; values: (string | null)[] }
  | { kind: "flags"; values: (boolean | null)[] };

/** A signal's column by its kind; null when no value is known. `none` (known to be absent) is `Infinity`. */
export function columnOf(values: readonly unknown[], kind: "number" | "flag" | "category"): Column | null {
  if (!values.some((v) => v !== null && v !== undefined)) return null;
  switch (kind) {
    case "number":
      return { kind: "line", values: values.map((v) => (typeof v === "number" ? v : v === "none" ? Infinity : null)) };
    case "category":
      return { kind: "words", values: values.map((v) => (typeof v === "string" ? v : null)) };
    case "flag":
      return { kind: "flags", values: values.map((v) => (typeof v === "boolean" ? v : null)) };
  }
}
