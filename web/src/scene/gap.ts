// The free distance between two boxes on the road. Pure.
import type { Pose } from "./motion.ts";

export type Box = { pose: Pose; length: number; width: number };
type Point = readonly [number, number];

function corners({ pose, length, width }: Box): Point[] {
  const [cos, sin] = [Math.cos(pose.heading), Math.sin(pose.heading)];
  return ([[1, 1], [1, -1], [-1, -1], [-1, 1]] as const).map(([a, b]) => {
    const [along, across] = [(a * length) / 2, (b * width) / 2];
    return [pose.x + along * cos - across * sin, pose.y + along * sin + across * cos];
  });
}

function toSide([x, y]: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy;
  const share = length === 0 ? 0 : Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / length));
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

/** No line along a side of one of them separates the two. */
function overlap(a: readonly Point[], b: readonly Point[]): boolean {
  return [a, b].every((box) =>
    box.every(([x, y], n) => {
      const [nextX, nextY] = box[(n + 1) % box.length] ?? [x, y];
      const [nx, ny] = [nextY - y, x - nextX];
      const along = (points: readonly Point[]): number[] => points.map(([px, py]) => px * nx + py * ny);
      const [one, other] = [along(a), along(b)];
      return Math.max(...one) >= Math.min(...other) && Math.max(...other) >= Math.min(...one);
    }),
  );
}

/** Least distance between two boxes, m; 0 where they overlap. */
export function gapBetween(one: Box, other: Box): number {
  const [a, b] = [corners(one), corners(other)];
  if (overlap(a, b)) return 0;
  const sides = (from: readonly Point[], to: readonly Point[]): number[] =>
    from.flatMap((p) => to.map((q, n) => toSide(p, q, to[(n + 1) % to.length] ?? q)));
  return Math.min(...sides(a, b), ...sides(b, a));
}
