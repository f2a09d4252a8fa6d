// Pictures of every screen at 1280 and 1920 px, in both languages, light and dark: `node e2e/pictures.mjs FOLDER
// [NAMES]` (a regular expression), with what `whyroad demo --out` wrote in WHYROAD_DEMO, or any folder with `lake` and
// `mined` in it. LOOKS and WIDTHS choose some of them. For people to look at; asserts nothing.
import { cpSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium as driver } from "playwright-core";
import { ask, person, settled, signIn } from "./people.mjs";
import { picture } from "./png.mjs";
import { chromium, serve, whyroad } from "./service.mjs";

const [folder, part = ""] = process.argv.slice(2);
const demo = process.env.WHYROAD_DEMO;
if (!folder || !demo) throw new Error("usage: WHYROAD_DEMO=DIR node e2e/pictures.mjs FOLDER [NAMES]");
mkdirSync(folder, { recursive: true });
const PASSWORD = "落霞与孤鹜齐飞-2026";
const wantedNames = new RegExp(part);
const SIZES = [[1280, 800], [1920, 1080]].filter(([width]) => (process.env.WIDTHS ?? "1280,1920").includes(String(width)));
const LOOKS = (process.env.LOOKS ?? "zh light,en light,zh dark,en dark").split(",").map((look) => look.split(" "));

const scratch = mkdtempSync(join(tmpdir(), "whyroad-pictures-"));
const lake = join(scratch, "lake");
cpSync(join(demo, "lake"), lake, { recursive: true });
filmed("multilane");
const browser = await driver.launch({ executablePath: chromium() ?? undefined, args: ["--no-sandbox", "--disable-gpu", "--font-render-hinting=none"] });
const service = await serve({ data: join(scratch, "data"), lake, mined: join(demo, "mined") });
const faults = [];

/** Gives the drive with such a name images of two cameras, the others none. */
function filmed(wanted) {
  const drive = readdirSync(join(lake, "drives")).find((name) => name.includes(wanted));
  if (!drive) return;
  for (const [camera, color] of [["front_wide_120fov", [52, 78, 104]], ["cross_left_120fov", [96, 72, 60]]]) {
    const images = join(scratch, camera);
    mkdirSync(images);
    for (let n = 0; n < 120; n++) writeFileSync(join(images, `${n}.png`), picture(160, 90, color.map((c) => c + (n % 60))));
    try {
      whyroad("media", "add", "--lake", lake, "--drive", drive, "--camera", camera, "--pictures", images, "--rate", "2", "--copy");
    } catch {
      // Images after the end of the drive are left out, and said to be.
    }
  }
}

/** Takes the screen in all sizes, languages and appearances; `then` opens what is not there after a reload. */
async function shoot(name, page, path, then = async () => {}) {
  if (!wantedNames.test(name)) return;
  for (const [width, height] of SIZES) {
    await page.setViewportSize({ width, height });
    for (const [lang, theme] of LOOKS) {
      await page.evaluate(([lang, theme]) => {
        localStorage.setItem("whyroad.lang", lang);
        localStorage.setItem("whyroad.theme", theme);
      }, [lang, theme]);
      await page.goto(service.url + path);
      await settled(page);
      await then(page).catch((e) => console.log(`${name}: ${e.message.split("\n")[0]}`));
      await settled(page);
      await page.screenshot({ path: join(folder, `${name}-${width}-${lang}-${theme}.png`) });
    }
  }
}

try {
  const one = await person(browser, service.url, { faults });
  const { page } = one;
  await shoot("setup", page, "/");
  await page.goto(service.url);
  await page.locator("#name").fill("wang");
  await page.locator("#display").fill("王芳");
  await page.locator("#password").fill(PASSWORD);
  await page.locator("#repeated").fill(PASSWORD);
  await page.keyboard.press("Enter");
  await page.locator("header .who").waitFor();
  const api = (method, path, body) => ask(page, method, path, body);
  await shoot("projects-empty", page, "/");
  await shoot("users-first", page, "/users");
  await shoot("new-user", page, "/users", (page) => page.locator("main button.primary").first().click());
  const project = (await api("POST", "/projects", { name: "城区因果标注", guide: "先写近因，再写决策。" })).id;
  const staff = [["li", "李明", ["annotator"]], ["chen", "陈静", ["checker"]], ["zhao", "赵强", ["annotator"]], ["sun", "孙悦", ["auditor"]]];
  for (const [name, display, roles] of staff) {
    await api("POST", "/users", { name, display, password: PASSWORD });
    await api("POST", `/projects/${project}/members`, { user: name, roles });
  }
  // Otherwise the lead could label, too, and would see no pictures.
  await api("POST", `/projects/${project}/members`, { user: "wang", roles: ["lead"] });
  await shoot("tasks-empty", page, `/projects/${project}/tasks`);
  await shoot("dashboard-empty", page, `/projects/${project}/dashboard`);
  await shoot("make-tasks", page, `/projects/${project}/tasks`, (page) => page.locator(".head button").click());
  const mined = (await api("GET", "/mined")).items[0].name;
  await api("POST", `/projects/${project}/tasks:create`, { mined });
  await shoot("tasks-pending", page, `/projects/${project}/tasks`);
  for (;;) {
    if ((await api("GET", `/projects/${project}/work`)).pending === 0) break;
    await new Promise((done) => setTimeout(done, 300));
  }
  const all = (await api("GET", `/projects/${project}/tasks?limit=200`)).items;
  const people = {};
  for (const [name] of staff) {
    people[name] = await person(browser, service.url, { faults });
    await signIn(people[name].page, name, PASSWORD);
  }
  const as = (name) => (method, path, body) => ask(people[name].page, method, path, body);
  const wanted = ["cutin.urgent", "cutin", ""].map((part) => all.find((t) => t.scenario_id.includes(part))).find(Boolean);
  const begin = async (name, id) => (await as(name)("POST", `/tasks/${id}/lease`, { action: "take" })).fence;
  const others = all.filter((t) => t.drive_id !== wanted.drive_id);
  const fence = await begin("li", wanted.id);
  await shoot("stage1-first", people.li.page, `/tasks/${wanted.id}`);
  await shoot("keys", people.li.page, `/tasks/${wanted.id}`, (page) => page.keyboard.press("?"));
  const open = await as("li")("POST", `/tasks/${wanted.id}/actions`, { action: "lock_stage1", fence });
  const stranger = await person(browser, service.url, { faults });
  await shoot("sign-in", stranger.page, "/");
  await shoot("sign-in-wrong", stranger.page, "/", async (page) => {
    await page.locator("#name").fill("wang");
    await page.locator("#password").fill("wrong-password");
    await page.keyboard.press("Enter");
    await page.locator("[role=alert]").waitFor();
  });
  await stranger.context.close();
  await shoot("projects", page, "/");
  await shoot("new-project", page, "/", (page) => page.locator("main button.primary").first().click());
  await shoot("tasks", page, `/projects/${project}/tasks`);
  await shoot("tasks-bulk", page, `/projects/${project}/tasks`, async (page) => {
    for (const n of [0, 1, 2]) await page.locator("tbody input[type=checkbox]").nth(n).check();
  });
  await shoot("tasks-annotator", people.li.page, `/projects/${project}/tasks`);
  await shoot("stage2", people.li.page, `/tasks/${wanted.id}`);
  await shoot("unsafe", people.li.page, `/tasks/${wanted.id}`, (page) => page.locator("[data-section=safety] button").nth(1).click());
  if (others[0]) {
    await begin("zhao", others[0].id);
    await shoot("stage1", people.zhao.page, `/tasks/${others[0].id}`);
    await shoot("guide", people.zhao.page, `/tasks/${others[0].id}`, (page) => page.locator("[data-action=guide]").click());
    await shoot("skip", people.zhao.page, `/tasks/${others[0].id}`, (page) => page.locator("[data-action=skip]").click());
  }
  const trace = "左侧车道的车在前方 22 m 处压线切入；原有车距不足以保持安全，需要让出空间，因此自车减速让行。";
  const changes = [
    { path: "/coc_trace", value: trace },
    { path: "/driving_decision/longitudinal", value: "yield_to_agent" },
    { path: "/driving_decision/lateral", value: null },
    ...(open.spec?.records ?? []).map((r) => ({ path: `/records/${r.id}`, value: r.choices?.[0]?.id === "yes" ? true : (r.choices?.[0]?.id ?? (r.unit ? 1 : "car")) })),
  ];
  await shoot("keys-stage2", people.li.page, `/tasks/${wanted.id}`, (page) => page.keyboard.press("?"));
  await shoot("reject", people.li.page, `/tasks/${wanted.id}`, (page) => page.locator("[data-action=reject]").click());
  const answered = await as("li")("POST", `/tasks/${wanted.id}/safety`, { fence: open.fence, answer: "safe" });
  await shoot("stage2-answered", people.li.page, `/tasks/${wanted.id}`);
  await shoot("submit-early", people.li.page, `/tasks/${wanted.id}`, (page) => page.keyboard.press("Control+Enter"));
  await shoot("findings", people.li.page, `/tasks/${wanted.id}`, (page) => page.locator("[data-section=findings]").scrollIntoViewIfNeeded());
  await shoot("offline", people.li.page, `/tasks/${wanted.id}`, async (page) => {
    const look = await page.evaluate(() => `${localStorage.getItem("whyroad.lang")}-${localStorage.getItem("whyroad.theme")}`);
    await page.context().setOffline(true);
    try {
      await page.keyboard.press("ArrowRight");
      await page.keyboard.press("u");
      await page.locator("[data-saving=offline]").waitFor();
      await page.screenshot({ path: join(folder, `offline-now-${page.viewportSize().width}-${look}.png`) });
      await page.keyboard.press("Control+z");
    } finally {
      await page.context().setOffline(false);
    }
    await page.locator("[data-saving=saved]").waitFor();
  });
  await shoot("of-another", people.zhao.page, `/tasks/${wanted.id}`);
  await shoot("no-task", people.li.page, "/tasks/nothing");
  await shoot("forbidden", people.li.page, `/projects/${project}/members`);
  await shoot("insert", people.li.page, `/tasks/${wanted.id}`, async (page) => {
    await page.keyboard.press("5");
    await page.keyboard.press("Alt+i");
  });
  const saved = await as("li")("PATCH", `/tasks/${wanted.id}/draft`, { fence: open.fence, base_version: answered.version, changes });
  if (saved.findings.some((f) => f.severity === "error")) console.log(saved.findings);
  await as("li")("POST", `/tasks/${wanted.id}/actions`, { action: "submit", fence: open.fence });
  await shoot("own-submitted", people.li.page, `/tasks/${wanted.id}`);
  const check = await begin("chen", wanted.id);
  await shoot("check", people.chen.page, `/tasks/${wanted.id}`);
  await as("chen")("POST", `/tasks/${wanted.id}/actions`, { action: "send_back", fence: check, reason: "请补充车距。", comments: [{ path: "/coc_trace", text: "请写明车距。" }] });
  const again = await as("li")("POST", `/tasks/${wanted.id}/lease`, { action: "take" });
  await shoot("rework", people.li.page, `/tasks/${wanted.id}`);
  const now = await as("li")("GET", `/tasks/${wanted.id}`);
  await as("li")("PATCH", `/tasks/${wanted.id}/draft`, { fence: again.fence, base_version: now.version, changes: [{ path: "/coc_trace", value: trace.replace("原有车距", "原有约 18 m 的车距") }] });
  await as("li")("POST", `/tasks/${wanted.id}/actions`, { action: "submit", fence: again.fence });
  const second = await begin("chen", wanted.id);
  await shoot("recheck", people.chen.page, `/tasks/${wanted.id}`);
  await shoot("history", people.chen.page, `/tasks/${wanted.id}`, (page) => page.locator("[data-action=history]").click());
  await as("chen")("POST", `/tasks/${wanted.id}/actions`, { action: "accept", fence: second });
  await shoot("nothing-next", people.chen.page, `/projects/${project}/tasks`, (page) => page.locator("main button.primary").first().click());
  // Two people label one episode, and the lead compares.
  const blind = (await api("POST", "/projects", { name: "独立标注对比", settings: { history: "episode" } })).id;
  await api("POST", `/projects/${blind}/members`, { user: "wang", roles: ["lead"] });
  for (const [name, display] of [["zhou", "周敏"], ["wu", "吴昊"]]) {
    await api("POST", "/users", { name, display, password: PASSWORD });
    await api("POST", `/projects/${blind}/members`, { user: name, roles: ["annotator"] });
    people[name] = await person(browser, service.url, { faults });
    await signIn(people[name].page, name, PASSWORD);
  }
  await api("POST", `/projects/${blind}/tasks:create`, { mined, limit: 2, overlap: 2 });
  let pair;
  for (const [name, words] of [["zhou", trace], ["wu", "前方左侧轿车正在并入本车道，两车接近，需要留出空间，因此减速让行。"]]) {
    const task = await as(name)("POST", `/projects/${blind}/tasks:next`, { kind: "label" });
    const id = (pair = task.task.id);
    await as(name)("POST", `/tasks/${id}/actions`, { action: "lock_stage1", fence: task.fence });
    const ready = await as(name)("POST", `/tasks/${id}/safety`, { fence: task.fence, answer: "safe" });
    const cause = { path: "/causes/longitudinal", value: { components: ["c1"] } };
    const all = [...changes.slice(1), cause, { path: "/coc_trace", value: words }].filter((c) => !c.path.startsWith("/records/"));
    const put = await as(name)("PATCH", `/tasks/${id}/draft`, { fence: ready.fence, base_version: ready.version, changes: all });
    await as(name)("POST", `/tasks/${id}/actions`, { action: "submit", fence: ready.fence }).catch((e) => console.log(e.message, put.findings));
  }
  await shoot("adjudicate", page, `/tasks/${pair}`, (page) => page.locator("section.adjudicate").waitFor());
  const screens = [["dashboard", "/dashboard"], ["analytics", "/analytics"], ["members", "/members"], ["exchange", "/exchange"], ["project", ""]];
  for (const [name, path] of screens) await shoot(name, page, `/projects/${project}${path}`);
  await shoot("dashboard-overlap", page, `/projects/${blind}/dashboard`);
  await shoot("episodes", page, `/projects/${project}/episodes`);
  await shoot("episodes-camera", page, `/projects/${project}/episodes`, async (page) => {
    const cards = page.locator("li .card");
    for (let n = 0; n < (await cards.count()); n++) {
      await cards.nth(n).click();
      if (await page.locator(".episode .camera img").waitFor({ timeout: 2000 }).then(() => true, () => false)) break;
    }
  });
  await shoot("episodes-wrong", page, `/projects/${project}/episodes`, async (page) => {
    await page.keyboard.press("2");
    await page.keyboard.press("Escape");
    await page.keyboard.press("g");
  });
  await shoot("settings", page, "/settings");
  await shoot("users", page, "/users");
  await shoot("not-found", page, "/nowhere");
  await shoot("task-as-lead", page, `/tasks/${all.find((t) => t.id !== wanted.id).id}`);
  if (faults.length > 0) console.log(faults);
} finally {
  await browser.close();
  await service.stop("SIGKILL");
  rmSync(scratch, { recursive: true, force: true });
}
