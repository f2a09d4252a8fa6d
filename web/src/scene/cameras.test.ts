// Choosing a camera: by name across tasks, round and round by key.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { CameraView } from "../api/types.ts";
import { cameraName, chosenCamera, nextCamera } from "./cameras.ts";

const camera = (name: string, pictures: number): CameraView => ({
  camera: name,
  frames: Array.from({ length: pictures }, (_, index) => ({ index, t_index: index, t_s: index, url: `${name}/${index}` })),
});

test("a name that this drive has is kept, else the first camera with pictures is shown", () => {
  const all = [camera("roof", 0), camera("front", 3), camera("rear", 2)];
  assert.equal(chosenCamera(all, "rear")?.camera, "rear");
  assert.equal(chosenCamera(all, "side")?.camera, "front");
  assert.equal(chosenCamera([camera("roof", 0)], "")?.camera, "roof");
  assert.equal(chosenCamera([], "front"), undefined);
});

test("names of PhysicalAI-AV, nuScenes and Argoverse are words; others stay as they are", () => {
  assert.equal(cameraName("cross_left_120fov", "zh"), "交叉·左·120°");
  assert.equal(cameraName("front_wide_120fov", "en"), "front wide 120°");
  assert.equal(cameraName("CAM_BACK_RIGHT", "zh"), "后·右");
  assert.equal(cameraName("ring_front_center", "en"), "ring front center");
  assert.equal(cameraName("front_a7", "zh"), "front_a7");
});

test("keys go round", () => {
  const all = [camera("left", 1), camera("front", 1), camera("right", 1)];
  assert.equal(nextCamera(all, "right", 1), "left");
  assert.equal(nextCamera(all, "left", -1), "right");
  assert.equal(nextCamera(all, "", 1), "front");
  assert.equal(nextCamera([], "front", 1), "front");
});
