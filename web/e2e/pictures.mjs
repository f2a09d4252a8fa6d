// Pictures of every screen at 1280 and 1920 px, in both languages, light and dark: `node e2e/pictures.mjs FOLDER
// [PART]`, with what `whyroad demo --out` wrote in WHYROAD_DEMO. For people to look at; asserts nothing.
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium as driver } from "playwright-core";
import { ask, person, signIn } from "./people.mjs";
import { chromium, serve } from "./service.mjs";

const [folder, part = ""] = process.argv.slice(2);
if (!folder) throw new Error("usage: node e2e/pictures.mjs FOLDER [PART OF A NAME]");
mkdirSync(folder, { recursive: true });
const PASSWORD = "落霞与孤鹜齐飞-2026";
const SIZES = [[1280, 800], [1920, 1080]];
const LOOKS = (process.env.LOOKS ?? "zh light,en light,zh dark,en dark").split(",").map((look) => look.split(" "));

const scratch = mkdtempSync(join(tmpdir(), "whyroad-pictures-"));
const browser = await driver.launch({ executablePath: chromium() ?? undefined, args: ["--no-sandbox", "--disable-gpu", "--font-render-hinting=none"] });
const service = await serve({ data: join(scratch, "data"), demo: process.env.WHYROAD_DEMO });
const faults = [];
try {
  const one = await person(browser, service.url, { faults });
  const { page } = one;
  const api = (method, path, body) => ask(page, method, path, body);
  await page.getByLabel("用户名").fill("wang");
  await page.getByLabel("显示名").fill("王芳");
  await page.getByLabel("密码", { exact: true }).fill(PASSWORD);
  await page.getByLabel("再次输入密码").fill(PASSWORD);
  await page.keyboard.press("Enter");
  await page.locator("header .who").waitFor();
  const project = (await api("POST", "/projects", { name: "城区因果标注", guide: "先写近因，再写决策。" })).id;
  for (const [name, display, roles] of [["li", "李明", ["annotator"]], ["chen", "陈静", ["checker"]], ["zhao", "赵强", ["annotator"]]]) {
    await api("POST", "/users", { name, display, password: PASSWORD });
    await api("POST", `/projects/${project}/members`, { user: name, roles });
  }
  // Otherwise the lead could label, too, and would see no pictures.
  await api("POST", `/projects/${project}/members`, { user: "wang", roles: ["lead"] });
  const mined = (await api("GET", "/mined")).items[0].name;
  const made = await api("POST", `/projects/${project}/tasks:create`, { mined });
  let ids = made.tasks;
  for (let n = 0; n < 600 && !ids; n++) {
    await new Promise((done) => setTimeout(done, 500));
    const job = await api("GET", `/projects/${project}/jobs/${made.id}`).catch(() => null);
    if (job?.state === "done") ids = (await api("GET", `/projects/${project}/tasks?limit=200`)).items.map((t) => t.id);
  }
  const all = (await api("GET", `/projects/${project}/tasks?limit=200`)).items;
  const people = {};
  for (const name of ["li", "chen", "zhao"]) {
    people[name] = await person(browser, service.url, { faults });
    await signIn(people[name].page, name, PASSWORD);
  }
  const as = (name) => (method, path, body) => ask(people[name].page, method, path, body);
  const wanted = all.find((t) => t.scenario_id.includes("cutin.urgent")) ?? all[0];
  const begin = async (name, id) => (await as(name)("POST", `/tasks/${id}/lease`, { action: "take" })).fence;
  // One task in Stage II, one submitted, one in Stage I.
  const others = all.filter((t) => t.drive_id !== wanted.drive_id);
  const fence = await begin("li", wanted.id);
  const open = await as("li")("POST", `/tasks/${wanted.id}/actions`, { action: "lock_stage1", fence });
  const screens = [
    ["sign-in", null, "/"],
    ["projects", page, "/"],
    ["tasks", page, `/projects/${project}/tasks`],
    ["tasks-annotator", people.li.page, `/projects/${project}/tasks`],
    ["stage2", people.li.page, `/tasks/${wanted.id}`],
  ];
  const first = others[0];
  if (first) {
    await begin("zhao", first.id);
    screens.push(["stage1", people.zhao.page, `/tasks/${first.id}`]);
  }
  const shoot = async (name, page, path) => {
    if (part && !name.includes(part)) return;
    for (const [width, height] of SIZES) {
      for (const [lang, theme] of LOOKS) {
        await page.setViewportSize({ width, height });
        await page.goto(service.url + path);
        await page.evaluate(([lang, theme]) => {
          localStorage.setItem("whyroad.lang", lang);
          localStorage.setItem("whyroad.theme", theme);
        }, [lang, theme]);
        await page.reload();
        await page.waitForLoadState("networkidle");
        await page.waitForTimeout(500);
        await page.screenshot({ path: join(folder, `${name}-${width}-${lang}-${theme}.png`) });
      }
    }
  };
  for (const [name, page, path] of screens) {
    if (page) await shoot(name, page, path);
    else {
      const stranger = await person(browser, service.url, { faults });
      await shoot(name, stranger.page, path);
      await stranger.context.close();
    }
  }
  const changes = [
    { path: "/coc_trace", value: "左侧车道的车在前方 22 m 处压线切入；原有车距不足以保持安全，需要让出空间，因此自车减速让行。" },
    { path: "/driving_decision/longitudinal", value: "yield_to_agent" },
    { path: "/driving_decision/lateral", value: null },
    ...(open.spec?.records ?? []).map((r) => ({ path: `/records/${r.id}`, value: r.choices?.[0]?.id === "yes" ? true : (r.choices?.[0]?.id ?? (r.unit ? 1 : "car")) })),
  ];
  const answered = await as("li")("POST", `/tasks/${wanted.id}/safety`, { fence: open.fence, answer: "safe" });
  await shoot("stage2-answered", people.li.page, `/tasks/${wanted.id}`);
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
  await as("li")("PATCH", `/tasks/${wanted.id}/draft`, { fence: again.fence, base_version: now.version, changes: [{ path: "/coc_trace", value: changes[0].value.replace("原有车距", "原有约 18 m 的车距") }] });
  await as("li")("POST", `/tasks/${wanted.id}/actions`, { action: "submit", fence: again.fence });
  await begin("chen", wanted.id);
  await shoot("recheck", people.chen.page, `/tasks/${wanted.id}`);
  for (const [name, path] of [["dashboard", "/dashboard"], ["analytics", "/analytics"], ["episodes", "/episodes"], ["members", "/members"], ["exchange", "/exchange"], ["project", ""]]) await shoot(name, page, `/projects/${project}${path}`);
  await shoot("settings", page, "/settings");
  await shoot("users", page, "/users");
  if (faults.length > 0) console.log(faults);
} finally {
  await browser.close();
  await service.stop("SIGKILL");
  rmSync(scratch, { recursive: true, force: true });
}
