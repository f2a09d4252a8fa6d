// Everything that is drawn at one moment: the scene, the view of it, and what is marked.
import type { SceneView } from "../api/types.ts";
import type { Palette } from "./colors.ts";
import type { Road } from "./road.ts";
import type { Size, View } from "./view.ts";

export interface SceneFrame {
  scene: SceneView;
  road: Road | null;
  origin: readonly [number, number];
  view: View;
  size: Size;
  ratio: number;
  palette: Palette;
  /** Frame, and the share of the way to the next one. */
  index: number;
  share: number;
  picked: string | null;
  linked: ReadonlySet<string>;
  target: string | null;
  history: boolean;
  names: boolean;
  occlusion: boolean;
}
