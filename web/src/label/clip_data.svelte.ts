// What was recorded around the keyframe of one task, as far as the stage may show it: scene, map, clock and player.
import * as api from "../api/calls.generated.ts";
import { LONG_TIMEOUT_MS, Offline } from "../api/client.ts";
import type { MapView, SceneView } from "../api/types.ts";
import { buildRoad, type Road } from "../scene/road.ts";
import { trackNames } from "../scene/objects.ts";
import { Player } from "../scene/player.svelte.ts";
import { type Clock, clockOf, frameNear, secondOf } from "./times.ts";

/** Waits between attempts to load the next stage, ms. */
const RETRY_MS = { first: 1_000, max: 10_000 };

export class ClipData {
  scene = $state.raw<SceneView | null>(null);
  road = $state.raw<Road | null>(null);
  clock = $state.raw<Clock | null>(null);
  /** World point, m, that drawing is relative to. */
  origin: readonly [number, number] = [0, 0];
  readonly player = new Player();
  #task: string;
  #closed = false;

  /** Short display names of the tracks by id. */
  trackNames = $derived(trackNames(this.scene?.tracks ?? []));

  constructor(task: string) {
    this.#task = task;
  }

  async load(): Promise<void> {
    const [scene, map] = await Promise.all([
      api.getTaskScene(this.#task, { timeoutMs: LONG_TIMEOUT_MS }),
      api.getTaskMap(this.#task),
    ]);
    this.put(scene, map);
  }

  /** Shows what is here already. */
  put(scene: SceneView, map: MapView): void {
    const i = scene.keyframe_index;
    const first = map.lanes[0]?.centre[0];
    this.origin = [scene.ego?.x[i] ?? first?.[0] ?? 0, scene.ego?.y[i] ?? first?.[1] ?? 0];
    this.clock = clockOf(scene);
    this.scene = scene;
    this.road = buildRoad(map, this.origin);
    // With the scene, not after it: a scene without its times must never be drawn.
    this.player.load(scene.t_s);
  }

  /**
   * As `load`, repeated while the service cannot be reached: a stage is locked only once, so what it opened must
   * arrive.
   */
  async loadUntilReached(): Promise<void> {
    for (let wait = RETRY_MS.first; !this.#closed; wait = Math.min(RETRY_MS.max, wait * 2)) {
      try {
        return await this.load();
      } catch (error) {
        if (!(error instanceof Offline)) throw error;
        await new Promise((done) => setTimeout(done, wait));
      }
    }
  }

  close(): void {
    this.#closed = true;
    this.player.pause();
  }

  /** Seconds from the suggested keyframe of a moment of the label; null for anything else. */
  second(iso: unknown): number | null {
    return this.clock ? secondOf(this.clock, iso) : null;
  }

  /** The short name of a track; its id where it is not in the scene. */
  trackName(id: string): string {
    return this.trackNames.get(id) ?? id;
  }

  /** The frame nearest to `t` seconds. */
  frameNear(t: number): number {
    return this.clock ? frameNear(this.clock, t) : 0;
  }
}
