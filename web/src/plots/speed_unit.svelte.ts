// The unit of speeds, kept in this browser.
import type { SpeedUnit } from "./units.ts";

const KEY = "whyroad.speeds";

export const speedUnit = $state<{ unit: SpeedUnit }>({ unit: localStorage.getItem(KEY) === "m/s" ? "m/s" : "km/h" });

export function setSpeedUnit(unit: SpeedUnit): void {
  speedUnit.unit = unit;
  localStorage.setItem(KEY, unit);
}
