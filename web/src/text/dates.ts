// Dates and durations in the current language.
import type { Lang } from "./text.svelte.ts";

const locale = (lang: Lang): string => (lang === "zh" ? "zh-CN" : "en-GB");

/** Local date and time of milliseconds since 1970. */
export function formatDateTime(ms: number, lang: Lang): string {
  return new Date(ms).toLocaleString(locale(lang), { dateStyle: "medium", timeStyle: "short" });
}

/** A duration in minutes below an hour, in hours below two days, in days above. */
export function formatDuration(hours: number, lang: Lang): string {
  const [n, unit] = hours < 1 ? [Math.ceil(hours * 60), "minute"] : hours < 48 ? [hours, "hour"] : [hours / 24, "day"];
  const style = { style: "unit", unit, maximumFractionDigits: n < 10 ? 1 : 0 } as const;
  return new Intl.NumberFormat(locale(lang), style).format(n);
}
