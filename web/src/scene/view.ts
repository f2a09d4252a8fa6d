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

/** Where the view's centre is on the screen, as a share of its height: the ego sees more ahead than behind. */
const ANCHOR = 0.62;

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
  const scale = Math.min(60, Math.max(0.8, v.scale * factor));
  const after = toWorld({ ...v, scale }, s, px, py);
  return { ...v, scale, x: v.x + before[0] - after[0], y: v.y + before[1] - after[1] };
}
