// Draws one moment of a scene. Called on every frame of a playback, so it allocates little and strokes the road in bulk.
import { lightColours } from "./colors.ts";
import { egoPose, lightsAt, trackPose } from "./motion.ts";
import { shortId } from "./objects.ts";
import type { Road } from "./road.ts";
import type { SceneFrame } from "./scene_frame.ts";
import { shadows } from "./shadow.ts";
import { box, drawTracks, inView } from "./tracks.ts";
import { matrix, toScreen } from "./view.ts";

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
  drawEgoPath(ctx, p);
  drawTracks(ctx, p, inView(p));
  const ego = egoPose(p.scene.ego, p.index, p.share);
  if (ego && p.scene.ego) {
    const [length, width] = p.scene.ego.size;
    ctx.fillStyle = p.palette.ego;
    ctx.beginPath();
    box(ctx, p, ego, length ?? 4.5, width ?? 1.9);
    ctx.fill();
  }
  ctx.setTransform(p.ratio, 0, 0, p.ratio, 0, 0);
  if (p.road) drawLights(ctx, p, p.road);
  drawNames(ctx, p);
  drawScale(ctx, p);
}

function drawRoad(ctx: CanvasRenderingContext2D, p: SceneFrame, road: Road): void {
  const c = p.palette;
  const px = 1 / p.view.scale;
  const fill = (colour: string, path: Path2D): void => {
    ctx.fillStyle = colour;
    ctx.fill(path, "nonzero");
  };
  const stroke = (colour: string, width: number, path: Path2D, dash: number[] = []): void => {
    ctx.strokeStyle = colour;
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
  if (p.view.scale > 3) stroke(c.centre, px, road.centres, [1, 3]);
  const mark = Math.max(0.15, 1.2 * px);
  stroke(c.mark, mark, road.solid);
  stroke(c.mark, mark, road.dashed, [3, 4]);
  stroke(c.centre, px, road.unknown);
  stroke(c.stopLine, Math.max(0.35, 2 * px), road.stopLines);
  ctx.setLineDash([]);
}

/** Areas that the ego does not see into, as one veil. */
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
  // What has been driven is a line; what is still to come, where it may be shown, is dotted.
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

function drawLights(ctx: CanvasRenderingContext2D, p: SceneFrame, road: Road): void {
  const perLane = new Map<string, number>();
  ctx.font = "bold 9px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  for (const light of lightsAt(p.scene.lights, p.index)) {
    const end = road.ends.get(light.lane_id);
    if (!end) continue;
    const n = perLane.get(light.lane_id) ?? 0;
    perLane.set(light.lane_id, n + 1);
    const [x, y] = toScreen(p.view, p.size, end.x - 1.1 * n * Math.cos(end.heading), end.y - 1.1 * n * Math.sin(end.heading));
    if (x < -20 || y < -20 || x > p.size.width + 20 || y > p.size.height + 20) continue;
    ctx.beginPath();
    ctx.arc(x, y, 6, 0, 2 * Math.PI);
    ctx.fillStyle = lightColours[light.colour] ?? lightColours.unknown ?? "#777";
    ctx.fill();
    ctx.strokeStyle = "#000";
    ctx.lineWidth = 1;
    ctx.stroke();
    ctx.fillStyle = light.colour === "yellow" ? "#000" : "#fff";
    ctx.fillText(light.colour.charAt(0).toUpperCase(), x, y + 0.5);
  }
  ctx.textAlign = "start";
}

function drawNames(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  ctx.font = "11px system-ui, sans-serif";
  ctx.textBaseline = "alphabetic";
  for (const track of p.scene.tracks) {
    const marked = track.id === p.picked || p.linked.has(track.id) || track.id === p.target;
    if (!marked && !p.names) continue;
    const pose = trackPose(track, p.index, p.share);
    if (!pose) continue;
    const [x, y] = toScreen(p.view, p.size, pose.x, pose.y);
    if (x < -40 || y < -20 || x > p.size.width + 40 || y > p.size.height + 20) continue;
    const name = shortId(track.id);
    ctx.lineWidth = 3;
    ctx.strokeStyle = p.palette.ground;
    ctx.strokeText(name, x + 8, y - 8);
    ctx.fillStyle = p.palette.text;
    ctx.fillText(name, x + 8, y - 8);
  }
}

function drawScale(ctx: CanvasRenderingContext2D, p: SceneFrame): void {
  const metres = [1, 2, 5, 10, 20, 50, 100].find((m) => m * p.view.scale > 50) ?? 100;
  const y = p.size.height - 12;
  ctx.strokeStyle = p.palette.text;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.moveTo(12, y);
  ctx.lineTo(12 + metres * p.view.scale, y);
  ctx.stroke();
  ctx.font = "11px system-ui, sans-serif";
  ctx.fillStyle = p.palette.text;
  ctx.fillText(`${metres} m`, 12, y - 5);
}
