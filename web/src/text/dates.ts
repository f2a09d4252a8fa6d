// Dates and durations in the current language.
import type { Lang } from "./text.svelte.ts";

const locale = (lang: Lang): string => (lang === "zh" ? "zh-CN" : "en-GB");

/** Date and time of milliseconds since 1970, in the reader's time zone unless another is given. */
export function formatDateTime(ms: number, lang: Lang, timeZone?: string): string {
  return new Intl.DateTimeFormat(locale(lang), { dateStyle: "medium", timeStyle: "short", ...(timeZone && { timeZone }) }).format(ms);
}

/** The same to the second, with the zone. */
export function exactDateTime(ms: number, lang: Lang, timeZone?: string): string {
  const parts = { year: "numeric", month: "short", day: "numeric", hour: "2-digit", minute: "2-digit", second: "2-digit", timeZoneName: "short" } as const;
  return new Intl.DateTimeFormat(locale(lang), { ...parts, ...(timeZone && { timeZone }) }).format(ms);
}

/** A clock that is ahead of UTC by so many minutes: `UTC`, `UTC+8`, `UTC−3:30`. */
export function clockName(minutes: number): string {
  if (minutes === 0) return "UTC";
  const hours = Math.floor(Math.abs(minutes) / 60);
  const rest = Math.abs(minutes) % 60;
  return `UTC${minutes < 0 ? "−" : "+"}${hours}${rest === 0 ? "" : `:${String(rest).padStart(2, "0")}`}`;
}

/** Minutes by which the reader's clock is ahead of UTC now. */
export const ownOffset = (): number => -new Date().getTimezoneOffset();

/** The clocks that exist, in minutes ahead of UTC (IANA time zone database, 2025). */
export const OFFSETS: readonly number[] = [
  -720, -660, -600, -570, -540, -480, -420, -360, -300, -240, -210, -180, -150, -120, -60, 0, 60, 120, 180, 210, 240, 270, 300, 330, 345,
  360, 390, 420, 480, 525, 540, 570, 600, 630, 660, 720, 765, 780, 825, 840,
];

/** A duration in minutes below an hour, in hours below two days, in days above. */
export function formatDuration(hours: number, lang: Lang): string {
  const [n, unit] = hours < 1 ? [Math.ceil(hours * 60), "minute"] : hours < 48 ? [hours, "hour"] : [hours / 24, "day"];
  const style = { style: "unit", unit, maximumFractionDigits: n < 10 ? 1 : 0 } as const;
  return new Intl.NumberFormat(locale(lang), style).format(n);
}
