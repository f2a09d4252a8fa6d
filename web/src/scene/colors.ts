// Colors of the bird's-eye view and the plots, light and dark. Classes also differ in lightness, for color-blind
// readers.

export interface Palette {
  ground: string;
  road: string;
  junction: string;
  walk: string;
  bike: string;
  mark: string;
  yellowMark: string;
  center: string;
  crosswalk: string;
  stopLine: string;
  building: string;
  facility: string;
  text: string;
  faint: string;
  grid: string;
  ego: string;
  egoPath: string;
  picked: string;
  linked: string;
  target: string;
  cursor: string;
  /** Over occluded areas. */
  veil: string;
  line: string;
  classes: { vehicle: string; large: string; two: string; person: string; thing: string };
}

const light: Palette = {
  ground: "#e8ebe8",
  road: "#bcc2c5",
  junction: "#b3babd",
  walk: "#d6d2c6",
  bike: "#c0b3ad",
  mark: "#ffffff",
  yellowMark: "#b98300",
  center: "#8d969b",
  crosswalk: "#ffffff",
  stopLine: "#5b6165",
  building: "#a9a39a",
  facility: "#b9a06a",
  text: "#16191b",
  faint: "#565d62",
  grid: "#d5d9db",
  ego: "#0b5cad",
  egoPath: "#0b5cad",
  picked: "#c2185b",
  linked: "#7b3fb5",
  target: "#b34700",
  cursor: "#c2185b",
  veil: "rgb(40 44 48 / 9%)",
  line: "#0b5cad",
  classes: { vehicle: "#3c7d4f", large: "#265236", two: "#9a5b00", person: "#b3261e", thing: "#5f666b" },
};

const dark: Palette = {
  ground: "#14181a",
  road: "#2b3135",
  junction: "#333a3f",
  walk: "#23221d",
  bike: "#3a2f2c",
  mark: "#dfe3e5",
  yellowMark: "#e5b53b",
  center: "#5f686e",
  crosswalk: "#b9c0c4",
  stopLine: "#dfe3e5",
  building: "#5b564e",
  facility: "#77683f",
  text: "#eceff1",
  faint: "#a9b1b6",
  grid: "#343b40",
  ego: "#58a9ff",
  egoPath: "#58a9ff",
  picked: "#ff6fa5",
  linked: "#c79bff",
  target: "#ffa057",
  cursor: "#ff6fa5",
  veil: "rgb(0 0 0 / 30%)",
  line: "#7cbcff",
  classes: { vehicle: "#6fc488", large: "#a6e0b6", two: "#f0b45a", person: "#ff8a80", thing: "#98a1a7" },
};

export const palettes = { light, dark };

/** Object classes by their color in the view, in the order of the legend. Classes that are not listed are `thing`. */
export const classGroups: readonly { color: keyof Palette["classes"]; classes: readonly string[] }[] = [
  { color: "vehicle", classes: ["car", "emergency_vehicle", "tricycle", "vehicle"] },
  { color: "large", classes: ["truck", "bus", "large_vehicle"] },
  { color: "two", classes: ["motorcycle", "bicycle", "bicyclist", "motorcyclist", "e_bike"] },
  { color: "person", classes: ["pedestrian", "wheeled_pedestrian", "animal"] },
  { color: "thing", classes: ["cone", "barrier", "static_object", "unknown"] },
];

export function classColor(p: Palette, name: string): string {
  return p.classes[classGroups.find((group) => group.classes.includes(name))?.color ?? "thing"];
}

/** How a light is drawn: its color, and the dashes of its bar in parts of the bar's width. */
export interface LightStyle {
  color: string;
  pattern: readonly number[];
}

const GREEN = "#2e9e44";
const NOT_KNOWN: LightStyle = { color: "#757575", pattern: [0.1, 0.1] };

/** By the values of `light.state`. The patterns make states legible without color. */
const lights: Record<string, LightStyle> = {
  red: { color: "#e53935", pattern: [] },
  red_yellow: { color: "#f57c00", pattern: [0.3, 0.1] },
  yellow: { color: "#f9a825", pattern: [0.2, 0.2] },
  flashing_yellow: { color: "#f9a825", pattern: [0.05, 0.1] },
  green: { color: GREEN, pattern: [0.4, 0.2] },
  green_arrow: { color: GREEN, pattern: [0.7, 0.3] },
  green_round: { color: GREEN, pattern: [0.25, 0.125] },
  green_yield: { color: GREEN, pattern: [0.2, 0.2] },
  flashing_green: { color: GREEN, pattern: [0.05, 0.1] },
  off: NOT_KNOWN,
  unknown: NOT_KNOWN,
};

/** The style of a light in this state; of an unknown one where the state has none. */
export function lightStyle(state: string): LightStyle {
  return lights[state] ?? NOT_KNOWN;
}
