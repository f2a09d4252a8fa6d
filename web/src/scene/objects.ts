// The objects at a frame as a list: the content of the canvas. Pure.
import type { SceneView, TrackView } from "../api/types.ts";
import { LONGEST_TRACK } from "../text/short_id.ts";
import { gapBetween } from "./gap.ts";
import { egoPose, trackPose, trackValue } from "./motion.ts";
import { sizeOf } from "./tracks.ts";

export type Bearing = "ahead" | "ahead_left" | "left" | "behind_left" | "behind" | "behind_right" | "right" | "ahead_right";

/** On a side of the ego from this far on, and beside it up to this at least, m: as drafts of components say it. */
const ASIDE_M = 1.8;
const BESIDE_M = 3;

/**
 * Where an object is, `along` and `left` of the ego in m, as drafts of components say it: beside the ego where the
 * boxes overlap along its way, whose half lengths add up to `reach`.
 */
export function bearingOf(along: number, left: number, reach: number): Bearing {
  const side = left > ASIDE_M ? "left" : left < -ASIDE_M ? "right" : null;
  const beside = Math.max(reach, BESIDE_M);
  if (side && Math.abs(along) <= beside) return side;
  const way = along >= 0 ? "ahead" : "behind";
  return side ? `${way}_${side}` : way;
}

export interface ListedObject {
  id: string;
  class: string;
  /** From the ego's center to its center, m; null without an ego. */
  distance: number | null;
  /** From side to side, m: what lies free between them. */
  gap: number | null;
  bearing: Bearing | null;
  /** m/s. */
  speed: number | null;
  /** The ego sees less than a tenth of it. */
  hidden: boolean;
}

/**
 * Display names of tracks: short ids as they are, long ones as `#1`, `#2`, … in the order of their first frame. Tracks
 * that only Stage II shows appear later and so do not renumber those of Stage I.
 */
export function trackNames(tracks: readonly TrackView[]): ReadonlyMap<string, string> {
  const inOrder = [...tracks].sort((a, b) => a.first - b.first || a.id.localeCompare(b.id));
  return new Map(inOrder.map((track, n) => [track.id, track.id.length > LONGEST_TRACK ? `#${n + 1}` : track.id]));
}

/** Objects present at frame `i`: the rule's `target`, then the nearest first. */
export function objectsAt(scene: SceneView, i: number, target: string | null): ListedObject[] {
  const ego = egoPose(scene.ego, i);
  const out: ListedObject[] = [];
  for (const track of scene.tracks) {
    const pose = trackPose(track, i);
    if (!pose) continue;
    const visible = trackValue(track, "visible", i);
    const seen: ListedObject = {
      id: track.id,
      class: track.class,
      distance: null,
      gap: null,
      bearing: null,
      speed: trackValue(track, "speed", i),
      hidden: visible !== null && visible < 0.1,
    };
    if (ego) {
      const dx = pose.x - ego.x;
      const dy = pose.y - ego.y;
      const [cos, sin] = [Math.cos(ego.heading), Math.sin(ego.heading)];
      seen.distance = Math.hypot(dx, dy);
      const [length, width] = sizeOf(track);
      const [egoLength, egoWidth] = scene.ego?.size ?? [];
      const turned = pose.heading - ego.heading;
      seen.gap = gapBetween({ pose: ego, length: egoLength ?? 4.5, width: egoWidth ?? 1.9 }, { pose, length, width });
      const reach = ((egoLength ?? 4.5) + length * Math.abs(Math.cos(turned)) + width * Math.abs(Math.sin(turned))) / 2;
      seen.bearing = bearingOf(dx * cos + dy * sin, dy * cos - dx * sin, reach);
    }
    out.push(seen);
  }
  const rank = (o: ListedObject): number => (o.id === target ? 0 : 1);
  return out.sort((a, b) => rank(a) - rank(b) || (a.gap ?? 0) - (b.gap ?? 0) || a.id.localeCompare(b.id));
}
