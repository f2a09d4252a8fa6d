// Choosing a camera: by name across tasks, round and round by key.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { CameraView } from "../api/types.ts";
import { cameraBeside, cameraNow } from "./cameras.ts";

const camera = (name: string, pictures: number): CameraView => ({
  camera: name,
  frames: Array.from({ length: pictures }, (_, index) => ({ index, t_index: index, t_s: index, url: `${name}/${index}` })),
});

test("a name that this drive has is kept, else the first camera with pictures is shown", () => {
  const all = [camera("roof", 0), camera("front", 3), camera("rear", 2)];
  assert.equal(cameraNow(all, "rear")?.camera, "rear");
  assert.equal(cameraNow(all, "side")?.camera, "front");
  assert.equal(cameraNow([camera("roof", 0)], "")?.camera, "roof");
  assert.equal(cameraNow([], "front"), undefined);
});

test("keys go round", () => {
  const all = [camera("left", 1), camera("front", 1), camera("right", 1)];
  assert.equal(cameraBeside(all, "right", 1), "left");
  assert.equal(cameraBeside(all, "left", -1), "right");
  assert.equal(cameraBeside(all, "", 1), "front");
  assert.equal(cameraBeside([], "front", 1), "front");
});
