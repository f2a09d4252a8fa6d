// View settings and pane sizes of the labeling screen, kept in this browser.

const KEY = "whyroad.layers";

interface Layers {
  history: boolean;
  names: boolean;
  occlusion: boolean;
  /** Name of the camera shown last; empty for a drive's first. */
  camera: string;
  /**
   * The labeling specification is shown: in Stage I, where it is read, and in Stage II, which fits one screen without.
   */
  spec: boolean;
  spec2: boolean;
  /** Arrows of the objects' velocities. */
  velocities: boolean;
  legend: boolean;
  /** What the shown decision must not be confused with. */
  confusions: boolean;
}

function stored(): Partial<Layers> {
  try {
    const own: unknown = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    return typeof own === "object" && own !== null ? (own as Partial<Layers>) : {};
  } catch {
    return {};
  }
}

const own = stored();

export const viewSettings = $state<Layers>({
  history: own.history !== false,
  names: own.names === true,
  occlusion: own.occlusion !== false,
  camera: typeof own.camera === "string" ? own.camera : "",
  spec: own.spec !== false,
  spec2: own.spec2 === true,
  velocities: own.velocities === true,
  legend: own.legend !== false,
  confusions: own.confusions === true,
});

export function saveViewSettings(): void {
  const { history, names, occlusion, velocities, legend, camera, spec, spec2, confusions } = viewSettings;
  localStorage.setItem(KEY, JSON.stringify({ history, names, occlusion, velocities, legend, camera, spec, spec2, confusions }));
}

/** Position of a splitter in this browser, in percent. */
export function paneShare(name: string, otherwise: number): number {
  const kept = Number(localStorage.getItem(`whyroad.split.${name}`) ?? Number.NaN);
  return Number.isFinite(kept) && kept > 0 ? kept : otherwise;
}
