// What the labelling screen shows and how its panes are divided: kept in this browser, because people set it once and not for each task.

const KEY = "whyroad.layers";

interface Layers {
  follow: boolean;
  history: boolean;
  names: boolean;
  occlusion: boolean;
  /** Name of the camera that was looked at last; empty for a drive's first. */
  camera: string;
  /** The class's specification is shown above the form. */
  spec: boolean;
  /** Zooms the view that is there now, about its middle. */
  zoom: ((factor: number) => void) | null;
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
  follow: true,
  history: own.history !== false,
  names: own.names === true,
  occlusion: own.occlusion !== false,
  camera: typeof own.camera === "string" ? own.camera : "",
  spec: own.spec !== false,
  zoom: null,
});

export function saveViewSettings(): void {
  const { history, names, occlusion, camera, spec } = viewSettings;
  localStorage.setItem(KEY, JSON.stringify({ history, names, occlusion, camera, spec }));
}

/** Where a splitter stands in this browser, in percent. */
export function paneShare(name: string, otherwise: number): number {
  const kept = Number(localStorage.getItem(`whyroad.split.${name}`) ?? Number.NaN);
  return Number.isFinite(kept) && kept > 0 ? kept : otherwise;
}
