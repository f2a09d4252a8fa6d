// Heights of the labeling form for each of the 122 leaves: `node e2e/heights.mjs [PART OF A LEAF'S ID]`, with what
// `whyroad demo --out` wrote in WHYROAD_DEMO. An episode of the demo is named as each leaf in turn, so that records,
// keyframes and decisions of all leaves are shown, in a window of 1280 x 800, in both languages: Stage I, Stage II when
// it opens, and Stage II with what a submission without any work finds. Prints what is higher than its room; takes some
// ten minutes. SHOTS: folder for screenshots of these.
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium as driver } from "playwright-core";
import { ask, makeFirstAccount, person, readStageOne, settled, signIn, tooHigh } from "./people.mjs";
import { chromium, serve } from "./service.mjs";

const PASSWORD = "大漠孤烟直长河落日圆-2026";
const demo = process.env.WHYROAD_DEMO;
const scratch = mkdtempSync(join(tmpdir(), "whyroad-heights-"));
const browser = await driver.launch({ executablePath: chromium(), args: ["--no-sandbox", "--disable-gpu"] });
const service = await serve({ data: join(scratch, "data"), demo });
const faults = [];
const higher = [];
let leaves = 0;

/** Notes by how much the form is higher than its room, in both languages. */
const measure = (page, where) =>
  tooHigh(page, async (lang, px) => {
    higher.push(px);
    console.log(`${where}, ${lang}: ${px} px`);
    if (process.env.SHOTS) await page.screenshot({ path: join(process.env.SHOTS, `${where}-${lang}.png`) });
  });

/** One task, by one person. */
async function look(page, leaf) {
  await page.locator(".form [data-section]").first().waitFor();
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-action="lock"]').waitFor();
  await settled(page);
  await measure(page, `${leaf} 1 Stage I`);
  if ((await page.locator("[data-component]").count()) === 0) {
    await page.keyboard.press("t");
    await page.keyboard.press("c");
    await page.keyboard.insertText("前方道路情况需要自车作出反应");
    await page.keyboard.press("Escape");
    await page.locator('[data-saving="saved"]').waitFor();
  }
  await page.evaluate(() => document.activeElement?.blur());
  for (let n = 0; n < 3 && !(await page.locator('[data-section="decisions"]').isVisible()); n++) {
    await readStageOne(page);
    await page.keyboard.press("Control+Enter");
    await page.locator('[data-section="decisions"]').waitFor({ timeout: 5_000 }).catch(() => {});
    // Some leaves ask for a component of high uncertainty.
    if (!(await page.locator('[data-section="decisions"]').isVisible())) await page.keyboard.press("x");
  }
  await page.locator('[data-section="decisions"]').waitFor({ timeout: 1_000 });
  await page.locator(".board .later").waitFor({ state: "detached" });
  await measure(page, `${leaf} 2 Stage II`);
  await page.keyboard.press("Control+Enter");
  await settled(page);
  await page.waitForTimeout(300);
  await measure(page, `${leaf} 3 with findings`);
}

try {
  const lead = await person(browser, service.url, { faults });
  await makeFirstAccount(lead.page, "wang", "王芳", PASSWORD);
  const api = (method, path, body) => ask(lead.page, method, path, body);
  const project = (await api("POST", "/projects", { name: "高度", settings: { history: "episode" } })).id;
  const mined = readFileSync(join(demo, "mined", "episodes.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
  const { taxonomy } = await api("GET", "/framework");
  const all = taxonomy.flatMap((l1) => l1.l2.flatMap((l2) => l2.l3.map((l3) => [l1.id, l2.id, l3.id].join("."))));
  const wanted = all.filter((id) => id.includes(process.argv[2] ?? ""));
  for (const leaf of wanted) {
    const base = mined.find((e) => e.scenario_id === leaf) ?? mined.find((e) => e.target_id) ?? mined[0];
    const name = `p${leaves++}`;
    const made = await api("POST", `/projects/${project}/tasks:create`, { episodes: [{ ...base, episode_id: `${name}-${leaf}`, scenario_id: leaf, is_primary: true }] });
    await api("POST", "/users", { name, display: name, password: PASSWORD });
    await api("POST", `/projects/${project}/members`, { user: name, roles: ["annotator"] });
    const { page, context } = await person(browser, service.url, { faults });
    await signIn(page, name, PASSWORD);
    const { tasks } = made;
    if (!tasks[0]) throw new Error(`${leaf}: ${JSON.stringify(made)}`);
    await api("POST", `/tasks/${tasks[0]}/assign`, { user: name });
    await page.goto(`${service.url}/tasks/${tasks[0]}`);
    await look(page, leaf).catch(async (e) => {
      console.log(`${leaf}: ${String(e.message).split("\n")[0]}`);
      if (process.env.SHOTS) await page.screenshot({ path: join(process.env.SHOTS, `${leaf}-failed.png`) });
    });
    await context.close();
  }
  console.log(`${leaves} leaves; ${higher.length} of ${leaves * 6} higher than their room, at most ${Math.max(0, ...higher)} px; ${faults.length} faults`);
} finally {
  await browser.close();
  await service.stop("SIGKILL");
  rmSync(scratch, { recursive: true, force: true });
}
