// The choice of a camera, and its name for people. Pure.
import type { CameraView } from "../api/types.ts";

/** Parts of the names that data sets give to cameras, in Chinese and English. */
const PARTS: Record<string, readonly [zh: string, en: string]> = {
  front: ["前", "front"], rear: ["后", "rear"], back: ["后", "back"], left: ["左", "left"], right: ["右", "right"],
  center: ["中", "center"], side: ["侧", "side"], cross: ["交叉", "cross"], wide: ["广角", "wide"], tele: ["长焦", "tele"],
  ring: ["环视", "ring"], stereo: ["双目", "stereo"],
};

/**
 * The name of a camera for people: `cross_left_120fov` is “交叉·左·120°”, `CAM_FRONT` “前”. A name with any part that
 * is not known stays as the data set has it.
 */
export function cameraName(id: string, reader: "zh" | "en"): string {
  const parts = id.toLowerCase().replace(/^cam(era)?_/, "").split("_").map((part) => {
    const angle = /^(\d+)fov$/.exec(part)?.[1];
    return angle ? `${angle}°` : PARTS[part]?.[reader === "zh" ? 0 : 1];
  });
  return parts.every((part) => part !== undefined) ? parts.join(reader === "zh" ? "·" : " ") : id;
}

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
