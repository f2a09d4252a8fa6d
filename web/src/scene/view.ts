// The camera over the bird's-eye view: world metres to screen pixels and back. Pure.

export interface View {
  /** World point in the middle, m. */
  x: number;
  y: number;
  /** Pixels a metre. */
  scale: number;
  /** Turn of the world, rad; pi/2 - heading puts that heading upwards. */
  turn: number;
}

export interface Size {
  width: number;
  height: number;
}

/** Scales between which one may zoom, px a metre: a whole district, and one person. */
const LEAST_SCALE = 0.8;
const MOST_SCALE = 60;

/** Where the view's centre is on the screen, as a share of its height: the ego sees more ahead than behind. */
const ANCHOR = 0.68;

/** Coefficients for `setTransform`, for points relative to `origin`: a canvas computes in 32 bits, maps may be far from 0. */
export function matrix(v: View, s: Size, origin: readonly [number, number]): DOMMatrix2DInit {
  const cos = Math.cos(v.turn) * v.scale;
  const sin = Math.sin(v.turn) * v.scale;
  const dx = origin[0] - v.x;
  const dy = origin[1] - v.y;
  return {
    a: cos,
    b: -sin,
    c: -sin,
    d: -cos,
    e: s.width / 2 + cos * dx - sin * dy,
    f: s.height * ANCHOR - sin * dx - cos * dy,
  };
}

export function toScreen(v: View, s: Size, x: number, y: number): [number, number] {
  const cos = Math.cos(v.turn) * v.scale;
  const sin = Math.sin(v.turn) * v.scale;
  return [
    s.width / 2 + cos * (x - v.x) - sin * (y - v.y),
    s.height * ANCHOR - sin * (x - v.x) - cos * (y - v.y),
  ];
}

export function toWorld(v: View, s: Size, px: number, py: number): [number, number] {
  const u = (px - s.width / 2) / v.scale;
  const w = (s.height * ANCHOR - py) / v.scale;
  const cos = Math.cos(v.turn);
  const sin = Math.sin(v.turn);
  return [v.x + cos * u + sin * w, v.y - sin * u + cos * w];
}

/** The view after zooming by `factor` about a point of the screen, which stays where it is. */
export function zoomed(v: View, s: Size, factor: number, px: number, py: number): View {
  const before = toWorld(v, s, px, py);
  const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, v.scale * factor));
  const after = toWorld({ ...v, scale }, s, px, py);
  return { ...v, scale, x: v.x + before[0] - after[0], y: v.y + before[1] - after[1] };
}

/** Room at the edges for the tools above, names beside and the scale below, px. */
const MARGIN = { top: 64, side: 48, bottom: 40 };

/** The greatest scale up to `most` at which a point `ahead` and `left` of the followed ego, m, is still in sight. */
export function fitting(s: Size, ahead: number, left: number, most: number): number {
  const up = s.height * ANCHOR - MARGIN.top;
  const down = s.height * (1 - ANCHOR) - MARGIN.bottom;
  const limits = [
    ahead > 0 ? up / ahead : ahead < 0 ? down / -ahead : most,
    left === 0 ? most : (s.width / 2 - MARGIN.side) / Math.abs(left),
  ];
  return Math.max(LEAST_SCALE, Math.min(most, ...limits));
}
