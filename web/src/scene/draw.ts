// Draws one frame of a scene. Called on every frame of a playback, so it allocates little and strokes the road in bulk.
import { lightStyle } from "./colors.ts";
import { egoPose, lightsAt, trackPose, trackValue } from "./motion.ts";
import type { Road } from "./road.ts";
import type { SceneFrame } from "./scene_frame.ts";
import { shadows } from "./shadow.ts";
import { box, drawTracks, inView, type Placed } from "./tracks.ts";
import { edgePoint, matrix, toScreen } from "./view.ts";

export function draw(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  ctx.setTransform(p.ratio, 0, 0, p.ratio, 0, 0);
  ctx.fillStyle = p.palette.ground;
  ctx.fillRect(0, 0, p.size.width, p.size.height);
  const m = matrix(p.view, p.size, p.origin);
  const world = (): void => {
    const r = p.ratio;
    ctx.setTransform((m.a ?? 1) * r, (m.b ?? 0) * r, (m.c ?? 0) * r, (m.d ?? 1) * r, (m.e ?? 0) * r, (m.f ?? 0) * r);
  };
  world();
  if (p.road) drawRoad(ctx, p, p.road);
  if (p.occlusion) drawShadows(ctx, p);
  // Below the vehicles: a light must not cover the car that waits at it.
  if (p.road) drawStopBars(ctx, p, p.road);
  drawEgoPath(ctx, p);
  const placed = inView(p);
  drawTracks(ctx, p, placed);
  if (p.velocities) drawVelocities(ctx, p, placed);
  const ego = egoPose(p.scene.ego, p.index, p.share);
  if (ego && p.scene.ego) {
    const [length, width] = p.scene.ego.size;
    ctx.fillStyle = p.palette.ego;
    ctx.beginPath();
    box(ctx, p, ego, length ?? 4.5, width ?? 1.9);
    ctx.fill();
  }
  ctx.setTransform(p.ratio, 0, 0, p.ratio, 0, 0);
  drawTarget(ctx, p);
  drawNames(ctx, p);
  drawRuler(ctx, p);
  drawScale(ctx, p);
}

function drawRoad(ctx: CanvasRenderingContext2D, p: SceneFrame, road: Road): void {
  const c = p.palette;
  const px = 1 / p.view.scale;
  const fill = (color: string, path: Path2D): void => {
    ctx.fillStyle = color;
    ctx.fill(path, "nonzero");
  };
  const stroke = (color: string, width: number, path: Path2D, dash: number[] = []): void => {
    ctx.strokeStyle = color;
    ctx.lineWidth = width;
    ctx.setLineDash(dash);
    ctx.stroke(path);
  };
  fill(c.building, road.buildings);
  fill(c.walk, road.walks);
  fill(c.road, road.lanes);
  fill(c.bike, road.bikes);
  fill(c.junction, road.junctions);
  fill(c.junction, road.junctionLanes);
  ctx.globalAlpha = 0.35;
  fill(c.facility, road.facilities);
  ctx.globalAlpha = 0.75;
  fill(c.crosswalk, road.crosswalks);
  ctx.globalAlpha = 1;
  stroke(c.facility, px, road.facilities);
  if (p.view.scale > 3) stroke(c.center, px, road.centers, [1, 3]);
  const mark = Math.max(0.15, 1.2 * px);
  stroke(c.mark, mark, road.solid);
  stroke(c.mark, mark, road.dashed, [3, 4]);
  stroke(c.center, px, road.unknown);
  stroke(c.stopLine, Math.max(0.35, 2 * px), road.stopLines);
  ctx.setLineDash([]);
}

/** Areas occluded from the ego, as one veil. */
function drawShadows(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  const ego = egoPose(p.scene.ego, p.index, p.share);
  if (!ego) return;
  ctx.beginPath();
  for (const wedge of shadows([ego.x, ego.y], p.scene.tracks, p.road?.walls ?? [], p.index, p.share)) {
    wedge.forEach(([x, y], i) => (i === 0 ? ctx.moveTo(x - p.origin[0], y - p.origin[1]) : ctx.lineTo(x - p.origin[0], y - p.origin[1])));
    ctx.closePath();
  }
  ctx.fillStyle = p.palette.veil;
  ctx.fill("nonzero");
}

function drawEgoPath(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  const ego = p.scene.ego;
  if (!ego) return;
  const px = 1 / p.view.scale;
  ctx.strokeStyle = p.palette.egoPath;
  ctx.lineWidth = 2 * px;
  // The past path is a line; the future one, where it may be shown, is dotted.
  for (const [from, to, dash] of [[0, p.index, []], [p.index, ego.x.length - 1, [0.6, 1.2]]] as const) {
    ctx.setLineDash([...dash]);
    ctx.beginPath();
    let pen = false;
    for (let i = from; i <= to; i++) {
      const x = ego.x[i];
      const y = ego.y[i];
      if (x == null || y == null) {
        pen = false;
        continue;
      }
      if (pen) ctx.lineTo(x - p.origin[0], y - p.origin[1]);
      else ctx.moveTo(x - p.origin[0], y - p.origin[1]);
      pen = true;
    }
    ctx.stroke();
  }
  ctx.setLineDash([]);
}

/**
 * A light is a colored bar across the end of its lane; lights of several movements of one lane are one behind the
 * other.
 */
function drawStopBars(ctx: CanvasRenderingContext2D, p: SceneFrame, road: Road): void {
  const perLane = new Map<string, number>();
  const width = Math.max(0.5, 4 / p.view.scale);
  ctx.lineWidth = width;
  ctx.lineCap = "butt";
  for (const light of lightsAt(p.scene.lights, p.index)) {
    const end = road.ends.get(light.lane_id);
    if (!end) continue;
    const n = perLane.get(light.lane_id) ?? 0;
    perLane.set(light.lane_id, n + 1);
    const [cos, sin] = [Math.cos(end.heading), Math.sin(end.heading)];
    const x = end.x - p.origin[0] - n * 1.6 * width * cos;
    const y = end.y - p.origin[1] - n * 1.6 * width * sin;
    const half = end.width / 2;
    const style = lightStyle(light.colour);
    ctx.strokeStyle = style.color;
    ctx.setLineDash(style.pattern.map((part) => part * end.width));
    ctx.beginPath();
    ctx.moveTo(x - half * sin, y + half * cos);
    ctx.lineTo(x + half * sin, y - half * cos);
    ctx.stroke();
  }
  ctx.setLineDash([]);
}

/** Radius of the ring around the target, px: it is found at any zoom. */
const RING_PX = 16;
/** Distance of the pointer to a target outside of the view from the edge, px. */
const EDGE_PX = 22;

/** A ring around the rule's target; at the edge of the view an arrow in its direction where it is outside. */
function drawTarget(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  const track = p.scene.tracks.find((candidate) => candidate.id === p.target);
  const pose = track && trackPose(track, p.index, p.share);
  if (!pose) return;
  const [x, y] = toScreen(p.view, p.size, pose.x, pose.y);
  ctx.strokeStyle = ctx.fillStyle = p.palette.target;
  ctx.lineWidth = 2;
  const edge = edgePoint(p.size, x, y, EDGE_PX);
  ctx.beginPath();
  if (!edge) {
    ctx.arc(x, y, Math.max(RING_PX, (track.length ?? 0) * 0.65 * p.view.scale), 0, 2 * Math.PI);
    ctx.stroke();
    return;
  }
  const angle = Math.atan2(y - edge[1], x - edge[0]);
  for (const [turn, r] of [[0, 12], [2.5, 10], [-2.5, 10]] as const) {
    ctx.lineTo(edge[0] + r * Math.cos(angle + turn), edge[1] + r * Math.sin(angle + turn));
  }
  ctx.fill();
}

/** An arrow from the front of each moving object, as long as its way in one second. */
function drawVelocities(ctx: CanvasRenderingContext2D, p: SceneFrame, placed: readonly Placed[]): void {
  const px = 1 / p.view.scale;
  ctx.lineWidth = 1.5 * px;
  ctx.strokeStyle = p.palette.text;
  ctx.beginPath();
  for (const { track, pose } of placed) {
    const speed = trackValue(track, "speed", p.index);
    if (speed === null || Math.abs(speed) < 0.3) continue;
    const [cos, sin] = [Math.cos(pose.heading), Math.sin(pose.heading)];
    const front = (Math.sign(speed) * (track.length ?? 0)) / 2;
    const [x, y] = [pose.x - p.origin[0] + front * cos, pose.y - p.origin[1] + front * sin];
    const [endX, endY] = [x + speed * cos, y + speed * sin];
    ctx.moveTo(x, y);
    ctx.lineTo(endX, endY);
    for (const turn of [2.6, -2.6]) {
      const angle = Math.atan2(endY - y, endX - x) + turn;
      ctx.moveTo(endX, endY);
      ctx.lineTo(endX + 6 * px * Math.cos(angle), endY + 6 * px * Math.sin(angle));
    }
  }
  ctx.stroke();
}

function drawRuler(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  if (!p.ruler) return;
  const [x0, y0] = toScreen(p.view, p.size, ...p.ruler.from);
  const [x1, y1] = toScreen(p.view, p.size, ...p.ruler.to);
  ctx.strokeStyle = p.palette.picked;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  ctx.stroke();
  drawText(ctx, p, `${p.ruler.distance.toFixed(1)} m`, (x0 + x1) / 2 + 8, (y0 + y1) / 2 - 8);
}

/** Text that is legible on any ground. */
function drawText(ctx: CanvasRenderingContext2D, p: SceneFrame, text: string, x: number, y: number): void {
  ctx.font = "11px system-ui, sans-serif";
  ctx.textBaseline = "alphabetic";
  ctx.lineWidth = 3;
  ctx.strokeStyle = p.palette.ground;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = p.palette.text;
  ctx.fillText(text, x, y);
}

function drawNames(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  for (const track of p.scene.tracks) {
    const marked = track.id === p.picked || p.linked.has(track.id) || track.id === p.target;
    if (!marked && !p.names) continue;
    const pose = trackPose(track, p.index, p.share);
    if (!pose) continue;
    const [x, y] = toScreen(p.view, p.size, pose.x, pose.y);
    if (x < -40 || y < -20 || x > p.size.width + 40 || y > p.size.height + 20) continue;
    drawText(ctx, p, p.trackNames.get(track.id) ?? track.id, x + 8, y - 8);
  }
}

function drawScale(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  const meters = [1, 2, 5, 10, 20, 50, 100].find((m) => m * p.view.scale > 50) ?? 100;
  const y = p.size.height - 12;
  ctx.strokeStyle = p.palette.text;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(12, y);
  ctx.lineTo(12 + meters * p.view.scale, y);
  ctx.stroke();
  ctx.font = "11px system-ui, sans-serif";
  ctx.fillStyle = p.palette.text;
  ctx.fillText(`${meters} m`, 12, y - 5);
}
