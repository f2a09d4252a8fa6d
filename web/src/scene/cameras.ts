// The choice of a camera. Pure.
import type { CameraView } from "../api/types.ts";

/** The camera of that name; else the first with images; else the first. */
export function chosenCamera(cameras: readonly CameraView[], name: string): CameraView | undefined {
  return cameras.find((c) => c.camera === name) ?? cameras.find((c) => c.frames.length > 0) ?? cameras[0];
}

/** The name of the next (`by` 1) or previous (-1) camera, cyclically. */
export function nextCamera(cameras: readonly CameraView[], name: string, by: 1 | -1): string {
  const now = chosenCamera(cameras, name);
  const at = now ? cameras.indexOf(now) : 0;
  return cameras[(at + by + cameras.length) % cameras.length]?.camera ?? name;
}
