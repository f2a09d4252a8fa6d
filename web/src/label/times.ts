// Times of a label (ISO 8601, exact) and frames of the scene (seconds from the suggested keyframe). Pure.
import type { SceneView } from "../api/types.ts";
import { nearestIndex, type Ns, secondsBetween, toNs } from "./ns.ts";

export interface Clock {
  /** The suggested keyframe: second 0. */
  zero: Ns;
  ns: readonly Ns[];
  iso: readonly string[];
  t: readonly number[];
  /** Frame number in the clip; outside of it negative or beyond the clip's last. */
  frames: readonly number[];
}

export function clockOf(scene: SceneView): Clock {
  const ns = scene.times.map(toNs);
  return {
    zero: ns[scene.keyframe_index] ?? ns[0] ?? 0n,
    ns,
    iso: scene.times,
    t: scene.t_s,
    frames: scene.clip_frames,
  };
}

/** Seconds of a time of the label; null for anything else. */
export function secondOf(clock: Clock, iso: unknown): number | null {
  if (typeof iso !== "string") return null;
  try {
    return secondsBetween(clock.zero, toNs(iso));
  } catch {
    return null;
  }
}

/** The frame nearest to `t` seconds. */
export function frameNear(clock: Clock, t: number): number {
  return nearestIndex(clock.ns, clock.zero + BigInt(Math.round(t * 1e9)));
}

/** Seconds with their sign: `−0.3`, `+1.2`, `0.0`. */
export function signed(seconds: number, digits = 1): string {
  const text = Math.abs(seconds).toFixed(digits);
  if (Number(text) === 0) return text;
  return `${seconds < 0 ? "−" : "+"}${text}`;
}
