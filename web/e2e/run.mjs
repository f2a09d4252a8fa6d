// End-to-end test in a real browser against the real service: from a fresh store to labels that `whyroad validate`
// passes. WHYROAD_DEMO names what `whyroad demo --out` wrote (else the service prepares the bundled drives itself);
// SHOTS names a folder for screenshots.
import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium as driver } from "playwright-core";
import { begin } from "./begin.mjs";
import { check } from "./check.mjs";
import { label } from "./label.mjs";
import { model } from "./model.mjs";
import { oidc } from "./oidc.mjs";
import { otherClass } from "./other_class.mjs";
import { overlap } from "./overlap.mjs";
import { exchange } from "./exchange.mjs";
import { seriousFindings } from "./people.mjs";
import { screens } from "./screens.mjs";
import { second } from "./second.mjs";
import { chromium, serve } from "./service.mjs";
import { troubles } from "./troubles.mjs";

const executablePath = chromium();
if (!executablePath) {
  console.log("skipped: no Chromium");
  process.exit((process.env.WHYROAD_REQUIRE ?? "").split(",").includes("chromium") ? 1 : 0);
}

const scratch = mkdtempSync(join(tmpdir(), "whyroad-e2e-"));
const began = Date.now();
/** What all steps share. `faults` is what the page complained of anywhere; it has to stay empty. */
const day = {
  slots: { state: "左侧车道的车在前方 22 m 处压线切入本车道，其车速低于自车，两车正在接近", reason: "原有车距不足以保持安全，需要让出空间", decision: "自车减速让行" }, faults: [], scratch, people: {}, shots: process.env.SHOTS ?? null, data: join(scratch, "data"), demo: process.env.WHYROAD_DEMO };
if (day.shots) mkdirSync(day.shots, { recursive: true });

async function step(name, work) {
  const from = Date.now();
  try {
    await work(day);
    console.log(`ok   ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
  } catch (error) {
    console.error(`FAIL ${name}`);
    for (const [who, { page }] of Object.entries(day.people)) {
      const file = join(tmpdir(), `whyroad-e2e-${who}.png`);
      await page.screenshot({ path: file }).then(() => console.error(`${who} saw: ${file} (${page.url()})`), () => {});
    }
    if (day.faults.length > 0) console.error(day.faults.join("\n"));
    throw error;
  }
}

day.browser = await driver.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu", "--font-render-hinting=none"] });
try {
  day.restart = (port) => serve({ ...day, port });
  await step("the service starts on a fresh store", async () => (day.service = await day.restart(0)));
  for (const [name, work] of [...begin, ...label, ...check, ...exchange, ...troubles, ...overlap, ...second, ...model, ...otherClass, ...screens, ...oidc]) await step(name, work);
  await step("the page complained of nothing", () => assert.deepEqual(day.faults, []));
  await step("axe found nothing serious on any screen", () => assert.deepEqual(seriousFindings, []));
  await step("the service stops on SIGTERM", async () => assert.equal(await day.service.stop(), "0"));
  console.log(`The whole day: ${((Date.now() - began) / 1000).toFixed(0)} s`);
} finally {
  await day.browser.close();
  await day.service?.stop("SIGKILL");
  await day.own?.stop("SIGKILL");
  rmSync(scratch, { recursive: true, force: true });
}
