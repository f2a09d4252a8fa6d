// Poses at a time between two frames. Pure; null (unknown) stays null and is never drawn as 0.
import type { EgoView, LightView, TrackView } from "../api/types.ts";

export interface Pose {
  x: number;
  y: number;
  heading: number;
}

type Column = readonly (number | null)[];

/** Linear between row `i` and the next by the fraction `share`; the row itself where the next is unknown. */
function between(column: Column, i: number, share: number): number | null {
  const a = column[i];
  if (a === undefined || a === null) return null;
  const b = column[i + 1];
  return share === 0 || b === undefined || b === null ? a : a + (b - a) * share;
}

function angleBetween(column: Column, i: number, share: number): number | null {
  const a = column[i];
  if (a === undefined || a === null) return null;
  const b = column[i + 1];
  if (share === 0 || b === undefined || b === null) return a;
  const turn = Math.atan2(Math.sin(b - a), Math.cos(b - a));
  return a + turn * share;
}

function poseIn(o: { x: Column; y: Column; heading: Column }, i: number, share: number): Pose | null {
  if (i < 0) return null;
  const x = between(o.x, i, share);
  const y = between(o.y, i, share);
  if (x === null || y === null) return null;
  return { x, y, heading: angleBetween(o.heading, i, share) ?? 0 };
}

export function egoPose(ego: EgoView | null | undefined, i: number, share = 0): Pose | null {
  return ego ? poseIn(ego, i, share) : null;
}

/** `i` counts in the scene's times; the track's own columns start at `first`. */
export function trackPose(track: TrackView, i: number, share = 0): Pose | null {
  return poseIn(track, i - track.first, share);
}

export function trackValue(track: TrackView, column: "speed" | "visible", i: number): number | null {
  return track[column][i - track.first] ?? null;
}

/** Light states at frame `i`: the last one of each lane and movement that began at or before it. */
export function lightsAt(lights: readonly LightView[], i: number): LightView[] {
  const now = new Map<string, LightView>();
  for (const l of lights) if (l.t_index <= i) now.set(`${l.lane_id}\n${l.to_lane_id ?? ""}`, l);
  return [...now.values()];
}

/** Is the point inside the box at `pose`, widened by `margin`? */
export function hits(pose: Pose, length: number, width: number, x: number, y: number, margin: number): boolean {
  const cos = Math.cos(pose.heading);
  const sin = Math.sin(pose.heading);
  const along = (x - pose.x) * cos + (y - pose.y) * sin;
  const across = (y - pose.y) * cos - (x - pose.x) * sin;
  return Math.abs(along) <= length / 2 + margin && Math.abs(across) <= width / 2 + margin;
}
