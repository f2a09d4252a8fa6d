// Screenshots for the documentation, taken only when SHOTS names a folder.
import { join } from "node:path";
import { settled } from "./people.mjs";

export async function shot(day, page, name) {
  if (!day.shots) return;
  await settled(page);
  await page.screenshot({ path: join(day.shots, `${name}.png`) });
}
