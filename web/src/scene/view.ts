// The view of the bird's-eye scene: world meters to screen pixels and back. Pure.

export interface View {
  /** World point at the anchor of the screen, m. */
  x: number;
  y: number;
  /** Pixels per meter. */
  scale: number;
  /** Turn of the world, rad; pi/2 - heading puts that heading upwards. */
  turn: number;
  /** Height of the anchor on the screen, as a fraction from the top; more is shown ahead of the ego than behind it. */
  anchor?: number;
}

export interface Size {
  width: number;
  height: number;
}

/** Limits of zooming, px per meter: a whole district, and one person. */
const LEAST_SCALE = 0.8;
const MOST_SCALE = 60;

/** Heights of the anchor: usually, and the least, with which a target far behind the ego is in sight. */
const ANCHOR = 0.68;
const LEAST_ANCHOR = 0.4;

const anchorOf = (v: View, s: Size): number => s.height * (v.anchor ?? ANCHOR);

/**
 * Coefficients for `setTransform`, for points relative to `origin`: canvases compute in 32 bits, maps may be far from
 * 0.
 */
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
    f: anchorOf(v, s) - sin * dx - cos * dy,
  };
}

export function toScreen(v: View, s: Size, x: number, y: number): [number, number] {
  const cos = Math.cos(v.turn) * v.scale;
  const sin = Math.sin(v.turn) * v.scale;
  return [
    s.width / 2 + cos * (x - v.x) - sin * (y - v.y),
    anchorOf(v, s) - sin * (x - v.x) - cos * (y - v.y),
  ];
}

export function toWorld(v: View, s: Size, px: number, py: number): [number, number] {
  const u = (px - s.width / 2) / v.scale;
  const w = (anchorOf(v, s) - py) / v.scale;
  const cos = Math.cos(v.turn);
  const sin = Math.sin(v.turn);
  return [v.x + cos * u + sin * w, v.y - sin * u + cos * w];
}

/** The view after zooming by `factor` about a point of the screen, which keeps its world point. */
export function zoomed(v: View, s: Size, factor: number, px: number, py: number): View {
  const before = toWorld(v, s, px, py);
  const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, v.scale * factor));
  const after = toWorld({ ...v, scale }, s, px, py);
  return { ...v, scale, x: v.x + before[0] - after[0], y: v.y + before[1] - after[1] };
}

/** Room at the edges for the tools at the top, names at the sides and the scale at the bottom, px. */
const MARGIN = { top: 96, side: 48, bottom: 40 };

/**
 * The largest scale up to `most` at which a point `ahead` and `left` of the followed ego, m, is in sight, and the
 * anchor that it needs: for a point behind, the ego moves up the screen before the view zooms out.
 */
export function fitting(s: Size, ahead: number, left: number, most: number): { scale: number; anchor: number } {
  const side = left === 0 ? most : Math.min(most, (s.width / 2 - MARGIN.side) / Math.abs(left));
  const behind = Math.max(0, -ahead) * side + MARGIN.bottom;
  const anchor = Math.min(ANCHOR, Math.max(LEAST_ANCHOR, 1 - behind / s.height));
  const up = s.height * anchor - MARGIN.top;
  const down = s.height * (1 - anchor) - MARGIN.bottom;
  const length = ahead > 0 ? up / ahead : ahead < 0 ? down / -ahead : most;
  return { scale: Math.max(LEAST_SCALE, Math.min(side, length)), anchor };
}

/**
 * Where the line from the middle of the canvas to (`x`, `y`) px leaves it, `inset` px from the edge; null for a point
 * inside.
 */
export function edgePoint(s: Size, x: number, y: number, inset: number): [number, number] | null {
  const [cx, cy] = [s.width / 2, s.height / 2];
  const [dx, dy] = [x - cx, y - cy];
  const share = Math.min(
    dx === 0 ? Infinity : (cx - inset) / Math.abs(dx),
    dy === 0 ? Infinity : (cy - inset) / Math.abs(dy),
  );
  return share >= 1 ? null : [cx + dx * share, cy + dy * share];
}
