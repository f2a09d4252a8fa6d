// Screenshots for the documentation, taken only when SHOTS names a folder.
import { join } from "node:path";

export async function shot(day, page, name) {
  if (!day.shots) return;
  // Fonts and the last frame of the canvas.
  await page.waitForTimeout(300);
  await page.screenshot({ path: join(day.shots, `${name}.png`) });
}
