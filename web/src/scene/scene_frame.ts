// Everything that is drawn at one moment: the scene, the view of it, and what is marked.
import type { SceneView } from "../api/types.ts";
import type { Palette } from "./colors.ts";
import type { Road } from "./road.ts";
import type { Size, View } from "./view.ts";

type Point = readonly [x: number, y: number];

export interface SceneFrame {
  scene: SceneView;
  road: Road | null;
  origin: readonly [number, number];
  view: View;
  size: Size;
  ratio: number;
  palette: Palette;
  /** Frame, and the fraction of the time to the next one. */
  index: number;
  share: number;
  picked: string | null;
  linked: ReadonlySet<string>;
  target: string | null;
  history: boolean;
  names: boolean;
  /** Arrows of the way that each object covers in one second. */
  velocities: boolean;
  /** Display names by track id. */
  trackNames: ReadonlyMap<string, string>;
  /** The measured line in world points, m; null without one. */
  ruler: { from: Point; to: Point; distance: number } | null;
  occlusion: boolean;
}
