// The view of the scene: following and leaving it free, without a jump. Expected values by hand.
import assert from "node:assert/strict";
import { beforeEach, test } from "vitest";
import type { Pose } from "./motion.ts";
import { SceneCamera } from "./scene_camera.svelte.ts";
import { toScreen } from "./view.ts";

let ego: Pose | null;
let camera: SceneCamera;

beforeEach(() => {
  ego = { x: 5000, y: -300, heading: 0.5 };
  camera = new SceneCamera(() => ego);
  camera.size = { width: 800, height: 600 };
});

test("it follows the ego with its heading up", () => {
  assert.deepEqual(camera.view, { x: 5000, y: -300, scale: 7, turn: Math.PI / 2 - 0.5 });
  ego = { x: 5010, y: -290, heading: 0.6 };
  assert.equal(camera.view.x, 5010);
});

test("leaving the ego keeps the view where it is, not at the origin of the world", () => {
  const before = camera.view;
  camera.toggleFollowing();
  assert.deepEqual(camera.view, before);
  ego = { x: 6000, y: 0, heading: 0 };
  assert.deepEqual(camera.view, before, "the ego drives on");
  camera.toggleFollowing();
  assert.equal(camera.view.x, 6000);
});

test("dragging leaves the ego and moves the point under the pointer", () => {
  const from = camera.view;
  const grabbed = toScreen(from, camera.size, 5004, -298);
  camera.drag(from, grabbed[0], grabbed[1], grabbed[0] + 50, grabbed[1] - 20);
  assert.equal(camera.following, false);
  const now = toScreen(camera.view, camera.size, 5004, -298);
  assert.ok(Math.abs(now[0] - grabbed[0] - 50) < 1e-6 && Math.abs(now[1] - grabbed[1] + 20) < 1e-6);
});

test("the target is in sight afterwards, also when the view was elsewhere; it is not magnified beyond the limit", () => {
  camera.drag(camera.view, 0, 0, 4000, 4000);
  const target = { x: 5000 + 90 * Math.cos(0.5), y: -300 + 90 * Math.sin(0.5), heading: 0 };
  camera.showTarget(target);
  const [x, y] = toScreen(camera.view, camera.size, target.x, target.y);
  assert.ok(x > 0 && x < 800 && y > 0 && y < 600, `${x}, ${y}`);
  camera.showTarget({ x: 5005, y: -300, heading: 0 }, 12);
  assert.equal(camera.view.scale, 12);
});

test("a target that was put in sight stays there when the canvas shrinks, unless the view was zoomed by hand", () => {
  const target = { x: 5000 + 50 * Math.cos(0.5), y: -300 + 50 * Math.sin(0.5), heading: 0 };
  const visible = (): boolean => {
    const [x, y] = toScreen(camera.view, camera.size, target.x, target.y);
    return x > 0 && x < camera.size.width && y > 0 && y < camera.size.height;
  };
  camera.showTarget(target);
  camera.resize({ width: 800, height: 260 });
  assert.ok(visible());
  camera.showTarget(target);
  camera.zoom(1.5);
  const scale = camera.view.scale;
  camera.resize({ width: 800, height: 200 });
  assert.equal(camera.view.scale, scale);
});

test("without an ego the view is where it was put", () => {
  ego = null;
  camera.centerOn(70, 80);
  assert.deepEqual([camera.view.x, camera.view.y], [70, 80]);
  camera.showTarget({ x: 100, y: 110, heading: 0 });
  assert.deepEqual([camera.view.x, camera.view.y], [100, 110]);
});
