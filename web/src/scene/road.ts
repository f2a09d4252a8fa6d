// The map as a few paths, built once per task: a frame only strokes them.
import type { LaneView, MapView } from "../api/types.ts";

type Points = readonly (readonly number[])[];
type Point = readonly [number, number];

export interface LaneEnd {
  x: number;
  y: number;
  heading: number;
  /** Of the lane at its end, m. */
  width: number;
}

/** Width of a lane without boundaries, m. */
const USUAL_WIDTH = 3.2;

export interface Road {
  lanes: Path2D;
  junctionLanes: Path2D;
  walks: Path2D;
  bikes: Path2D;
  junctions: Path2D;
  crosswalks: Path2D;
  stopLines: Path2D;
  buildings: Path2D;
  facilities: Path2D;
  centers: Path2D;
  solid: Path2D;
  dashed: Path2D;
  unknown: Path2D;
  /** End and direction of each lane, where its light is drawn. */
  ends: Map<string, LaneEnd>;
  /** Walls of buildings, in world meters: static occluders. */
  walls: [Point, Point][];
}

export function buildRoad(map: MapView, origin: readonly [number, number]): Road {
  const line = (path: Path2D, points: Points, closed = false, shift = 0): void => {
    points.forEach((p, i) => {
      const [nx, ny] = shift === 0 ? [0, 0] : normal(points, i);
      const x = (p[0] ?? 0) - origin[0] + nx * shift;
      const y = (p[1] ?? 0) - origin[1] + ny * shift;
      if (i === 0) path.moveTo(x, y);
      else path.lineTo(x, y);
    });
    if (closed) path.closePath();
  };
  const road: Road = {
    lanes: new Path2D(),
    junctionLanes: new Path2D(),
    walks: new Path2D(),
    bikes: new Path2D(),
    junctions: new Path2D(),
    crosswalks: new Path2D(),
    stopLines: new Path2D(),
    buildings: new Path2D(),
    facilities: new Path2D(),
    centers: new Path2D(),
    solid: new Path2D(),
    dashed: new Path2D(),
    unknown: new Path2D(),
    ends: new Map(),
    walls: [],
  };
  const edge = (points: Points, mark: string): void => {
    // Double lines are two strokes 0.24 m apart; each side has its own kind. Normals point left.
    const sides: Record<string, [Path2D, number][]> = {
      solid: [[road.solid, 0]],
      dashed: [[road.dashed, 0]],
      double_solid: [[road.solid, 0.12], [road.solid, -0.12]],
      double_dashed: [[road.dashed, 0.12], [road.dashed, -0.12]],
      solid_dashed: [[road.solid, 0.12], [road.dashed, -0.12]],
      dashed_solid: [[road.dashed, 0.12], [road.solid, -0.12]],
      unknown: [[road.unknown, 0]],
    };
    for (const [path, shift] of sides[mark] ?? []) line(path, points, false, shift);
  };
  for (const lane of map.lanes) {
    if (lane.left.length > 1 && lane.right.length > 1) {
      const ground = lane.kind === "sidewalk" ? road.walks : lane.kind === "bike" ? road.bikes : lane.in_junction ? road.junctionLanes : road.lanes;
      line(ground, [...lane.left, ...[...lane.right].reverse()], true);
    }
    edge(lane.left, lane.left_mark);
    edge(lane.right, lane.right_mark);
    // Across a junction they would be a web of crossing dashes where nothing is painted.
    if (!lane.in_junction) line(road.centers, lane.centre);
    const end = laneEnd(lane);
    if (end) road.ends.set(lane.id, end);
  }
  for (const s of map.drivable) line(road.lanes, s.points, true);
  for (const s of map.junctions) line(road.junctions, s.points, true);
  for (const s of map.crosswalks) line(road.crosswalks, s.points, true);
  for (const s of map.stop_lines) line(road.stopLines, s.points);
  for (const s of map.facilities) {
    if (s.kind === "building") {
      s.points.forEach((p, i) => {
        const q = s.points[(i + 1) % s.points.length] ?? p;
        road.walls.push([[p[0] ?? 0, p[1] ?? 0], [q[0] ?? 0, q[1] ?? 0]]);
      });
    }
    line(s.kind === "building" ? road.buildings : road.facilities, s.points, s.points.length > 2);
  }
  return road;
}

function laneEnd(lane: LaneView): LaneEnd | null {
  const a = lane.centre.at(-2);
  const b = lane.centre.at(-1);
  if (!a || !b) return null;
  const [left, right] = [lane.left.at(-1), lane.right.at(-1)];
  const width = left && right ? Math.hypot((left[0] ?? 0) - (right[0] ?? 0), (left[1] ?? 0) - (right[1] ?? 0)) : 0;
  return {
    x: b[0] ?? 0,
    y: b[1] ?? 0,
    heading: Math.atan2((b[1] ?? 0) - (a[1] ?? 0), (b[0] ?? 0) - (a[0] ?? 0)),
    width: width > 1 ? Math.min(width, 6) : USUAL_WIDTH,
  };
}

function normal(points: Points, i: number): [number, number] {
  const a = points[Math.max(0, i - 1)] ?? [0, 0];
  const b = points[Math.min(points.length - 1, i + 1)] ?? [0, 0];
  const dx = (b[0] ?? 0) - (a[0] ?? 0);
  const dy = (b[1] ?? 0) - (a[1] ?? 0);
  const n = Math.hypot(dx, dy) || 1;
  return [-dy / n, dx / n];
}
