// Which camera is looked at. Pure.
import type { CameraView } from "../api/types.ts";

/** The camera of that name; else the first that has pictures; else the first. */
export function chosenCamera(cameras: readonly CameraView[], name: string): CameraView | undefined {
  return cameras.find((c) => c.camera === name) ?? cameras.find((c) => c.frames.length > 0) ?? cameras[0];
}

/** The name of the camera `by` places on, round and round. */
export function nextCamera(cameras: readonly CameraView[], name: string, by: 1 | -1): string {
  const now = chosenCamera(cameras, name);
  const at = now ? cameras.indexOf(now) : 0;
  return cameras[(at + by + cameras.length) % cameras.length]?.camera ?? name;
}
