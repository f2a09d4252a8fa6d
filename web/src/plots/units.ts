// Display units: the API has base units (m/s, rad), rows show km/h and degrees. Pure.

export type SpeedUnit = "km/h" | "m/s";

/** A number with so many digits and a real minus sign, which 0 never has. */
export function fixed(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** A value that is uncertain, with its standard deviation if that is known: `≈ 1.43 ± 0.80`. */
export function uncertainText(text: string, deviation: number | null | undefined, digits: number): string {
  const spread = deviation === null || deviation === undefined ? "" : fixed(deviation, digits);
  return Number(spread) === 0 ? `≈ ${text}` : `≈ ${text} ± ${spread}`;
}

/** How a quantity is shown. */
export interface Scale {
  /** Shown beside the number; empty for pure numbers. */
  unit: string;
  /** Shown number = number in the API times this. */
  by: number;
  digits: number;
  /** Least height of an axis, in the shown unit, so that noise does not fill a row. */
  least: number;
}

const DEGREES = 180 / Math.PI;
const SCALES: Readonly<Record<string, Scale>> = {
  m: { unit: "m", by: 1, digits: 2, least: 1 },
  s: { unit: "s", by: 1, digits: 2, least: 1 },
  "m/s2": { unit: "m/s²", by: 1, digits: 2, least: 2 },
  "m/s3": { unit: "m/s³", by: 1, digits: 2, least: 2 },
  rad: { unit: "°", by: DEGREES, digits: 1, least: 10 },
  "rad/s": { unit: "°/s", by: DEGREES, digits: 1, least: 10 },
  "1/m": { unit: "1/m", by: 1, digits: 4, least: 0.01 },
};

/** How numbers with the API's `unit` are shown; null is a pure number. An unknown unit is shown unchanged. */
export function scaleOf(unit: string | null | undefined, speeds: SpeedUnit): Scale {
  if (unit === "m/s") return speeds === "km/h" ? { unit: "km/h", by: 3.6, digits: 1, least: 20 } : { unit: "m/s", by: 1, digits: 2, least: 5 };
  return SCALES[unit ?? ""] ?? { unit: unit ?? "", by: 1, digits: 2, least: 1 };
}

/** A number with its unit: a space between them but before a degree sign (SI brochure, 5.4.3). */
export const withUnit = (number: string, unit: string): string => (unit === "" ? number : `${number}${spaceBefore(unit)}${unit}`);

/** What stands between a number and this unit. */
export const spaceBefore = (unit: string): string => (unit.startsWith("°") ? "" : " ");

/** A column in the shown unit; unknown stays unknown. */
export function scaled(values: readonly (number | null)[] | undefined, scale: Scale): (number | null)[] {
  return (values ?? []).map((v) => (v === null ? null : v * scale.by));
}
