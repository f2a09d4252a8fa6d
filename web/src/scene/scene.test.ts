// The view's geometry. Expected values by hand.
import assert from "node:assert/strict";
import { test } from "vitest";
import { readFileSync } from "node:fs";
import { lightStyle } from "./colors.ts";
import { hits, lightsAt, trackPose } from "./motion.ts";
import { frameAt, imageAt } from "./player.svelte.ts";
import { corners, REACH, shadows, wedge } from "./shadow.ts";
import { trackNames } from "./objects.ts";
import { Ruler } from "./ruler.svelte.ts";
import { edgePoint, fitting, toScreen, toWorld, type View, zoomed } from "./view.ts";
import type { LightView, TrackView } from "../api/types.ts";

const near = (a: number, b: number, eps = 1e-9): void => assert.ok(Math.abs(a - b) < eps, `${a} is not ${b}`);

test("screen and world are inverse, ahead is up, and zooming keeps the point under the pointer", () => {
  const view: View = { x: 100, y: 50, scale: 8, turn: Math.PI / 2 - Math.PI / 3 };
  const size = { width: 800, height: 600 };
  const [x, y] = toWorld(view, size, 123, 456);
  const [px, py] = toScreen(view, size, x, y);
  near(px, 123);
  near(py, 456);
  const ahead = toScreen(view, size, 100 + 10 * Math.cos(Math.PI / 3), 50 + 10 * Math.sin(Math.PI / 3));
  const here = toScreen(view, size, 100, 50);
  near(ahead[0], here[0]);
  near(here[1] - ahead[1], 80);
  const closer = zoomed(view, size, 2, 123, 456);
  const [qx, qy] = toScreen(closer, size, x, y);
  near(qx, 123);
  near(qy, 456);
});

test("the target is in sight at first: ahead, behind or beside, and never closer than asked", () => {
  const size = { width: 700, height: 420 };
  for (const [ahead, left] of [[50, 0], [110, 20], [-30, 3], [5, -60]] as const) {
    const fit = fitting(size, ahead, left, 7);
    const [x, y] = toScreen({ x: 0, y: 0, ...fit, turn: Math.PI / 2 }, size, ahead, left);
    assert.ok(x > 40 && x < 660 && y > 60 && y < 385, `${ahead} m ahead, ${left} m left is at ${x}, ${y}`);
  }
  assert.equal(fitting(size, 8, 1, 7).scale, 7);
});

test("a target 62 m behind is in sight without losing the lanes: the ego moves up before the view zooms out", () => {
  const size = { width: 700, height: 420 };
  const fit = fitting(size, -62, 3, 7);
  const at = (ahead: number, left: number): [number, number] => toScreen({ x: 0, y: 0, ...fit, turn: Math.PI / 2 }, size, ahead, left);
  assert.ok(at(-62, 3)[1] < 385, "the target");
  assert.ok(at(0, 0)[1] > 96, "the ego, below the tools");
  // With the ego at its usual height 94 px are left for 62 m: 1.5 px per meter, a lane of 3.5 m is 5 px wide.
  assert.ok(fit.scale > 3, `${fit.scale} px per meter`);
  assert.deepEqual(fitting(size, 60, 3, 7).anchor, fitting(size, -5, 0, 7).anchor, "elsewhere nothing moves");
});

test("headings turn the short way round between two frames", () => {
  const track = { first: 2, x: [0, 1], y: [0, 0], heading: [3.1, -3.1] } as unknown as TrackView;
  assert.equal(trackPose(track, 1), null, "not there yet");
  const half = trackPose(track, 2, 0.5);
  near(half?.x ?? 9, 0.5);
  near(Math.cos(half?.heading ?? 0), -1, 1e-3);
});

test("a light holds until its next state", () => {
  const lights = [
    { lane_id: "a", t_index: 0, colour: "red" },
    { lane_id: "a", t_index: 5, colour: "green" },
    { lane_id: "b", t_index: 7, colour: "red" },
  ] as LightView[];
  assert.deepEqual(lightsAt(lights, 4).map((l) => l.colour), ["red"]);
  assert.deepEqual(lightsAt(lights, 7).map((l) => l.colour), ["green", "red"]);
});

test("a click hits a turned box and not the corner beside it", () => {
  const pose = { x: 0, y: 0, heading: Math.PI / 2 };
  assert.ok(hits(pose, 4, 2, 0, 1.9, 0));
  assert.ok(!hits(pose, 4, 2, 1.9, 0, 0));
});

test("a shadow lies behind what hides, as wide as it is seen", () => {
  // A wall 2 m wide, 10 m ahead of an eye at the origin.
  const w = wedge([0, 0], corners({ x: 11, y: 0, heading: 0 }, 2, 2));
  assert.ok(w);
  const angles = w.map(([x, y]) => Math.abs(Math.atan2(y, x)));
  for (const a of angles) near(a, Math.atan2(1, 10), 1e-9);
  assert.ok(Math.hypot(...(w[1] ?? [0, 0])) >= REACH);
  assert.equal(wedge([11, 0], corners({ x: 11, y: 0, heading: 0 }, 2, 2)), null, "from within nothing is hidden");
  assert.equal(wedge([0, 0], corners({ x: 500, y: 0, heading: 0 }, 2, 2)), null);
});

test("what stands wholly behind a nearer thing throws no shadow of its own; what looks out from behind it does", () => {
  const car = (x: number, y: number): TrackView =>
    ({ class: "car", length: 4, width: 2, first: 0, x: [x], y: [y], heading: [0] }) as unknown as TrackView;
  assert.equal(shadows([0, 0], [car(30, 0), car(10, 0)], [], 0, 0).length, 1);
  assert.equal(shadows([0, 0], [car(30, 3.5), car(10, 0)], [], 0, 0).length, 2);
  assert.equal(shadows([0, 0], [car(-30, 0), car(-10, 0)], [], 0, 0).length, 1, "also across the seam at pi");
});

test("the frame shown is the last one at or before now", () => {
  assert.deepEqual([-9, 0, 0.05, 0.1, 9].map((s) => frameAt([0, 0.1, 0.2], s)), [0, 0, 0, 1, 2]);
  // No picture before the camera's first one: it would be of a later moment; none long after its last.
  assert.deepEqual([-0.1, 0, 0.15, 1.2, 1.3].map((s) => imageAt([0, 0.1, 0.2], s)), [null, 0, 1, 2, null]);
  assert.equal(imageAt([], 0), null);
});

test("a target outside of the view has a pointer at the edge, in its direction", () => {
  const size = { width: 800, height: 600 };
  assert.equal(edgePoint(size, 700, 500, 20), null, "inside");
  assert.deepEqual(edgePoint(size, 400, -900, 20), [400, 20], "straight ahead");
  assert.deepEqual(edgePoint(size, 1920, 300, 20), [780, 300], "to the right");
  const corner = edgePoint(size, 400 + 2000, 300 + 2000, 20);
  assert.deepEqual(corner, [680, 580], "45 degrees: the lower edge comes first");
});

test("long ids become numbers by first frame, and keep them when later tracks are added", () => {
  const track = (id: string, first: number): TrackView => ({ id, first }) as TrackView;
  const a = track("7f9c24e8-3b12-4d3a-8b1e-0f5d5e5c9a11", 3);
  const b = track("0a000000-0000-4000-8000-000000000000", 0);
  const stageOne = trackNames([a, b, track("cutter", 0)]);
  assert.deepEqual([stageOne.get(b.id), stageOne.get("cutter"), stageOne.get(a.id)], ["#1", "cutter", "#3"]);
  const stageTwo = trackNames([track("00000000-0000-4000-8000-00000000000f", 40), a, b, track("cutter", 0)]);
  assert.equal(stageTwo.get(a.id), "#3");
});

test("the ruler measures between two world points", () => {
  const ruler = new Ruler();
  ruler.start();
  assert.equal(ruler.distance, null);
  ruler.press(10, 20);
  ruler.moveTo(13, 24);
  assert.equal(ruler.distance, 5);
  ruler.stop();
  assert.equal(ruler.distance, null);
});

test("every state of a light has its own look, and a green one is green", () => {
  const signals = readFileSync(`${import.meta.dirname}/../../../schema/signals.yaml`, "utf8");
  const values = /name: light\.state\n[\s\S]*?values: \[(.*?)\]/.exec(signals)?.[1] ?? "";
  const states = values.split(",").map((state) => state.trim().replaceAll('"', "")).filter((state) => state !== "none");
  assert.ok(states.length > 9, values);
  const looks = states.map((state) => JSON.stringify(lightStyle(state)));
  assert.equal(new Set(looks).size, states.length, "no two states look alike");
  for (const state of states) {
    assert.equal(lightStyle(state).color === lightStyle("green").color, state.includes("green"), state);
  }
});
