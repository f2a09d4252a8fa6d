// Occlusion in the ground plane: behind each occluding object a wedge away from the ego. Pure.
import type { TrackView } from "../api/types.ts";
import { type Pose, trackPose } from "./motion.ts";

/** How far wedges reach from the ego, m. */
export const REACH = 90;

type Point = readonly [number, number];

/** Classes that occlude; people, cones and two-wheelers occlude too little to be drawn. */
const HIDING = new Set(["car", "truck", "bus", "large_vehicle", "vehicle"]);

export function hides(track: TrackView): boolean {
  return HIDING.has(track.class) && (track.length ?? 0) > 2;
}

export function corners(pose: Pose, length: number, width: number): Point[] {
  const cos = Math.cos(pose.heading);
  const sin = Math.sin(pose.heading);
  return ([[1, 1], [-1, 1], [-1, -1], [1, -1]] as const).map(([a, b]) => [
    pose.x + (a * length * cos) / 2 - (b * width * sin) / 2,
    pose.y + (a * length * sin) / 2 + (b * width * cos) / 2,
  ]);
}

/**
 * A convex shape seen from an eye: its two outermost corners, their angles (`from` before `to`), its nearest distance.
 */
interface Outline {
  from: Point;
  to: Point;
  angleFrom: number;
  angleTo: number;
  nearest: number;
}

function outline(eye: Point, shape: readonly Point[]): Outline | null {
  const first = shape[0];
  if (!first) return null;
  const base = Math.atan2(first[1] - eye[1], first[0] - eye[0]);
  let least = 0;
  let most = 0;
  let from = first;
  let to = first;
  let nearest = Infinity;
  for (const p of shape) {
    const raw = Math.atan2(p[1] - eye[1], p[0] - eye[0]) - base;
    const turn = Math.atan2(Math.sin(raw), Math.cos(raw));
    if (turn < least) {
      least = turn;
      from = p;
    }
    if (turn > most) {
      most = turn;
      to = p;
    }
    nearest = Math.min(nearest, Math.hypot(p[0] - eye[0], p[1] - eye[1]));
  }
  if (nearest > REACH || most - least < 1e-4 || most - least > Math.PI) return null;
  return { from, to, angleFrom: base + least, angleTo: base + most, nearest };
}

/**
 * The area behind an outline, as near corner, far, far, near: the same orientation for all, so that a non-zero fill of
 * many is their union.
 */
function behind(eye: Point, o: Outline): Point[] {
  const far = (p: Point): Point => {
    const d = Math.hypot(p[0] - eye[0], p[1] - eye[1]) || 1;
    // The chord between two far points comes nearer than REACH: the points are moved out by that factor.
    const r = REACH / Math.cos(Math.min(1.4, (o.angleTo - o.angleFrom) / 2));
    return [eye[0] + ((p[0] - eye[0]) / d) * r, eye[1] + ((p[1] - eye[1]) / d) * r];
  };
  return [o.from, far(o.from), far(o.to), o.to];
}

/** The wedge behind a convex shape; null when the eye is in the shape or the shape is out of reach. */
export function wedge(eye: Point, shape: readonly Point[]): Point[] | null {
  const o = outline(eye, shape);
  return o && behind(eye, o);
}

/** Number of parts of the circle in which directions are counted. */
const PARTS = 1440;

/**
 * Wedges of all occluding tracks at frame `i` and of the walls of buildings. An object wholly behind nearer ones
 * occludes nothing more and has no wedge: in dense traffic a dozen of a hundred remain.
 */
export function shadows(eye: Point, tracks: readonly TrackView[], walls: readonly (readonly Point[])[], i: number, share: number): Point[][] {
  const outlines: Outline[] = [];
  const add = (shape: readonly Point[]): void => {
    const o = outline(eye, shape);
    if (o) outlines.push(o);
  };
  for (const track of tracks) {
    if (!hides(track)) continue;
    const pose = trackPose(track, i, share);
    if (pose && Math.abs(pose.x - eye[0]) < REACH && Math.abs(pose.y - eye[1]) < REACH) {
      add(corners(pose, track.length ?? 4.5, track.width ?? 1.9));
    }
  }
  for (const wall of walls) add(wall);
  outlines.sort((a, b) => a.nearest - b.nearest);
  const taken = new Uint8Array(PARTS);
  const part = (angle: number): number => (angle / (2 * Math.PI)) * PARTS;
  return outlines.filter((o) => !covered(taken, part(o.angleFrom), part(o.angleTo))).map((o) => behind(eye, o));
}

/** Is all of `from` to `to` covered already? Marks the whole parts in it as covered. */
function covered(taken: Uint8Array, from: number, to: number): boolean {
  let all = true;
  for (let n = Math.floor(from); n < Math.ceil(to); n++) all &&= taken[((n % PARTS) + PARTS) % PARTS] === 1;
  for (let n = Math.ceil(from); n < Math.floor(to); n++) taken[((n % PARTS) + PARTS) % PARTS] = 1;
  return all;
}
