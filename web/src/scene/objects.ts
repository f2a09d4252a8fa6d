// The objects of a moment in words: what the canvas shows, for a list. Pure.
import type { SceneView } from "../api/types.ts";
import { egoPose, trackPose, trackValue } from "./motion.ts";

export type Bearing = "ahead" | "ahead_left" | "left" | "behind_left" | "behind" | "behind_right" | "right" | "ahead_right";

const BEARINGS: readonly Bearing[] = ["ahead", "ahead_left", "left", "behind_left", "behind", "behind_right", "right", "ahead_right"];

export interface ListedObject {
  id: string;
  class: string;
  /** From the ego's centre to its centre, m; null without an ego. */
  distance: number | null;
  bearing: Bearing | null;
  /** m/s. */
  speed: number | null;
  /** The ego sees less than a tenth of it. */
  hidden: boolean;
}

/** A track id for people: of long ones (UUIDs) the beginning, which tells them apart in a scene. */
export function shortId(id: string): string {
  return id.length > 16 ? `${id.slice(0, 8)}…` : id;
}

/** Objects present at frame `i`, the nearest first. */
export function objectsAt(scene: SceneView, i: number): ListedObject[] {
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
      bearing: null,
      speed: trackValue(track, "speed", i),
      hidden: visible !== null && visible < 0.1,
    };
    if (ego) {
      const dx = pose.x - ego.x;
      const dy = pose.y - ego.y;
      const raw = Math.atan2(dy, dx) - ego.heading;
      const eighth = Math.round(Math.atan2(Math.sin(raw), Math.cos(raw)) / (Math.PI / 4));
      seen.distance = Math.hypot(dx, dy);
      seen.bearing = BEARINGS[(eighth + 8) % 8] ?? null;
    }
    out.push(seen);
  }
  return out.sort((a, b) => (a.distance ?? 0) - (b.distance ?? 0) || a.id.localeCompare(b.id));
}
