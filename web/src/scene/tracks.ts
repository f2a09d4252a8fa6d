// Objects of the bird's-eye view: boxes with heading and class color, tails, rings. One fill per color, not per object.
import type { TrackView } from "../api/types.ts";
import { classColor } from "./colors.ts";
import type { SceneFrame } from "./scene_frame.ts";
import { type Pose, trackPose, trackValue } from "./motion.ts";

/** Under this share the ego does not see an object (docs/reference/signals.md, `target.emerges`). */
const HIDDEN_BELOW = 0.1;
/** Duration of the tracks' tails, and of their steps, s. */
const TAIL_S = 3;
const TAIL_STEP_S = 0.4;

export interface Placed {
  track: TrackView;
  pose: Pose;
  color: string;
}

/** Objects of the frame that can be on the screen: others cost nothing. */
export function inView(p: SceneFrame): Placed[] {
  const reach = Math.hypot(p.size.width, p.size.height) / p.view.scale + 15;
  const out: Placed[] = [];
  for (const track of p.scene.tracks) {
    const pose = trackPose(track, p.index, p.share);
    if (!pose || Math.abs(pose.x - p.view.x) > reach || Math.abs(pose.y - p.view.y) > reach) continue;
    out.push({ track, pose, color: classColor(p.palette, track.class) });
  }
  return out;
}

/** Tails, then boxes; one stroke or fill per color, since each call costs far more than its points. */
export function drawTracks(ctx: CanvasRenderingContext2D, p: SceneFrame, placed: readonly Placed[]): void {
  const colors = [...new Set(placed.map((o) => o.color))];
  if (p.history) {
    ctx.globalAlpha = 0.55;
    ctx.lineWidth = 1.5 / p.view.scale;
    for (const color of colors) {
      ctx.beginPath();
      for (const o of placed) if (o.color === color) tail(ctx, p, o.track);
      ctx.strokeStyle = color;
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }
  const special = placed.filter((o) => isHidden(o.track, p.index) || ring(p, o.track.id) !== null);
  for (const color of colors) {
    ctx.beginPath();
    for (const o of placed) if (o.color === color && !special.includes(o)) box(ctx, p, o.pose, ...drawn(p, o.track));
    ctx.fillStyle = color;
    ctx.fill();
  }
  for (const o of special) drawSpecial(ctx, p, o);
}

function tail(ctx: CanvasRenderingContext2D, p: SceneFrame, track: TrackView): void {
  const last = p.index - track.first;
  const step = Math.max(1, Math.round(TAIL_STEP_S * p.scene.frame_rate));
  let pen = false;
  for (let n = Math.floor((TAIL_S * p.scene.frame_rate) / step); n >= 0; n--) {
    const i = last - n * step;
    if (i < 0) continue;
    const x = track.x[i];
    const y = track.y[i];
    if (x == null || y == null) {
      pen = false;
      continue;
    }
    if (pen) ctx.lineTo(x - p.origin[0], y - p.origin[1]);
    else ctx.moveTo(x - p.origin[0], y - p.origin[1]);
    pen = true;
  }
}

/** Adds a box with a pointed nose to the path, so that its heading can be read. */
export function box(ctx: CanvasRenderingContext2D, p: SceneFrame, at: Pose, length: number, width: number): void {
  const cos = Math.cos(at.heading);
  const sin = Math.sin(at.heading);
  const x = at.x - p.origin[0];
  const y = at.y - p.origin[1];
  const l = length / 2;
  const w = width / 2;
  const nose = Math.min(width * 0.45, length * 0.25);
  const to = (a: number, b: number, move = false): void => {
    const px = x + a * cos - b * sin;
    const py = y + a * sin + b * cos;
    if (move) ctx.moveTo(px, py);
    else ctx.lineTo(px, py);
  };
  to(-l, -w, true);
  to(l - nose, -w);
  to(l, 0);
  to(l - nose, w);
  to(-l, w);
  ctx.closePath();
}

function isHidden(track: TrackView, index: number): boolean {
  const visible = trackValue(track, "visible", index);
  return visible !== null && visible < HIDDEN_BELOW;
}

/** Color of the ring around a marked object; null for the others. */
function ring(p: SceneFrame, id: string): string | null {
  if (id === p.picked) return p.palette.picked;
  if (p.linked.has(id)) return p.palette.linked;
  return id === p.target ? p.palette.target : null;
}

/** An object with a ring, or an occluded one with a dashed outline. */
function drawSpecial(ctx: CanvasRenderingContext2D, p: SceneFrame, o: Placed): void {
  const hidden = isHidden(o.track, p.index);
  const around = ring(p, o.track.id);
  const px = 1 / p.view.scale;
  ctx.beginPath();
  box(ctx, p, o.pose, ...drawn(p, o.track));
  ctx.fillStyle = o.color;
  ctx.globalAlpha = hidden ? 0.18 : 1;
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.strokeStyle = around ?? o.color;
  ctx.lineWidth = (around ? 3 : 1.5) * px;
  ctx.setLineDash(hidden ? [4 * px, 3 * px] : []);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** Minimum length and width on the screen, px: a distant person can still be seen and selected. */
const LEAST_PX = 6;

/** Box of a track as it is drawn. */
function drawn(p: SceneFrame, track: TrackView): [number, number] {
  const [length, width] = sizeOf(track);
  const least = LEAST_PX / p.view.scale;
  return [Math.max(length, least), Math.max(width, least)];
}

/** Box of a track; where the source gives none, a point-like 0.6 m. */
export function sizeOf(track: TrackView): [number, number] {
  return [track.length ?? 0.6, track.width ?? 0.6];
}
