// What the bird's-eye view shows: kept in this browser, because people set it once and not for each task.

const KEY = "whyroad.layers";

interface Layers {
  follow: boolean;
  history: boolean;
  names: boolean;
  occlusion: boolean;
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

export const layers = $state<Layers>({
  follow: true,
  history: own.history !== false,
  names: own.names === true,
  occlusion: own.occlusion !== false,
  zoom: null,
});

export function keepLayers(): void {
  localStorage.setItem(KEY, JSON.stringify({ history: layers.history, names: layers.names, occlusion: layers.occlusion }));
}
