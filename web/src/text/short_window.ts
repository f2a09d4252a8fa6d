// What a drive lacks of the window of a training sample around a keyframe, in words.
import type { ShortWindow } from "../api/types.ts";
import { t } from "./text.svelte.ts";

/** Which part of the window is too short, and what follows from that. */
export function shortWindow(window: ShortWindow): string {
  const parts: string[] = [];
  if (typeof window.before_s === "number") parts.push(t("window.before", { s: window.before_s.toFixed(1) }));
  if (typeof window.after_s === "number") parts.push(t("window.after", { s: window.after_s.toFixed(1) }));
  return t("window.short", { parts: parts.join(t("window.and")) });
}
