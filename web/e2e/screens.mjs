// Every screen in both languages, dark and light: axe finds nothing serious, nothing is wider than the window (also at
// 200 %), and the language changes without a reload. Screenshots are taken on the way.
import assert from "node:assert/strict";
import { ask, checkAccessibility, person, readStageOne, settled } from "./people.mjs";
import { shot } from "./shots.mjs";

const APPEARANCES = [
  ["zh", "light"],
  ["en", "dark"],
  ["zh", "dark"],
  ["en", "light"],
];

/** Screens by user: address and name of the screenshot. */
const SEEN = (day) => ({
  wang: [
    ["/", "projects"],
    [`/projects/${day.project}/tasks`, "tasks"],
    [`/projects/${day.project}/dashboard`, "dashboard"],
    [`/projects/${day.project}/analytics`, "analytics"],
    [`/projects/${day.project}/members`, "members"],
    [`/projects/${day.project}`, "project"],
    [`/projects/${day.project}/exchange`, "exchange"],
    ["/settings", "settings"],
    [`/tasks/${day.task}`, "label"],
    ["/nowhere", "not-found"],
  ],
  admin: [["/users", "users"]],
});

const languageOf = (page) => page.evaluate(() => document.documentElement.lang.slice(0, 2));

async function setAppearance(page, lang, theme) {
  if ((await languageOf(page)) !== lang) await page.getByRole("button", { name: /^(English|中文)$/ }).click();
  const now = await page.evaluate(() => document.documentElement.dataset.theme);
  if (now !== theme) await page.getByRole("button", { name: /切换为|Switch to/ }).click();
}

/** Nothing may stick out sideways. */
async function fits(page, where) {
  const [wide, window] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(wide <= window, `${where}: ${wide} px in a window of ${window}`);
}

async function all(day) {
  for (const [who, screens] of Object.entries(SEEN(day))) {
    const { page } = day.people[who];
    for (const [path, name] of screens) {
      await page.goto(day.service.url + path);
      await page.locator("h1").first().waitFor();
      await settled(page);
      await page.evaluate(() => (window.sameDocument = true));
      for (const [lang, theme] of APPEARANCES) {
        await setAppearance(page, lang, theme);
        assert.equal(await languageOf(page), lang);
        await checkAccessibility(page, `${name}, ${lang}, ${theme}`);
        await fits(page, `${name}, ${lang}, ${theme}`);
        if (lang === "zh" && theme === "light") await shot(day, page, name);
        if (lang === "en" && theme === "dark") await shot(day, page, `${name}-en-dark`);
      }
      assert.ok(await page.evaluate(() => window.sameDocument), `${name} was reloaded`);
      await setAppearance(page, "zh", "light");
    }
  }
}

/** Moments without a class are a list of their own, and the filter outlives a reload and the way back. */
async function episodes(day) {
  const { page } = day.people.wang;
  const mined = (await ask(page, "GET", "/mined")).items[0].name;
  const count = async (query) => (await ask(page, "GET", `/projects/${day.project}/mined/${mined}/episodes?limit=1&${query}`)).total;
  const [everything, unexplained] = [await count(""), await count("scenario=other")];
  assert.ok(unexplained > 0 && unexplained < everything, `${unexplained} of ${everything} episodes have no class`);
  await page.goto(`${day.service.url}/projects/${day.project}/episodes`);
  await page.getByText(`${everything - unexplained} 个事件`, { exact: true }).waitFor();
  const list = page.getByRole("list", { name: "事件" });
  assert.equal(await list.getByText("无场景可解释").count(), 0);
  await checkAccessibility(page, "episodes");
  await shot(day, page, "episodes");
  await page.getByLabel("场景").first().selectOption("other");
  const apart = page.getByText(`${unexplained} 个事件`, { exact: true });
  await apart.waitFor();
  await page.getByLabel("只看未判定的").check();
  await shot(day, page, "episodes-other");
  const address = page.url();
  assert.match(address, /\/episodes\?scenario=other&unjudged=true$/);
  const kept = async () => {
    await apart.waitFor();
    assert.equal(page.url(), address);
    assert.equal(await page.getByLabel("场景").first().inputValue(), "other");
    assert.ok(await page.getByLabel("只看未判定的").isChecked());
  };
  await page.reload();
  await kept();
  await page.getByRole("link", { name: "看板" }).click();
  await page.getByRole("heading", { name: "看板" }).waitFor();
  await page.goBack();
  await kept();
}

/** 200 % of a window of 1280 x 800 leaves 640 x 400. */
async function enlarged(day) {
  const { context } = day.people.wang;
  const page = await context.newPage();
  await page.setViewportSize({ width: 640, height: 400 });
  for (const [path, name] of SEEN(day).wang) {
    await page.goto(day.service.url + path);
    await page.locator("h1").first().waitFor();
    await settled(page);
    await fits(page, `${name} at 200 %`);
  }
  await page.close();
}

async function door(day) {
  for (const [lang, theme] of APPEARANCES) {
    const { page, context } = await person(day.browser, day.service.url, { lang, theme, faults: day.faults });
    await page.locator("#name").waitFor();
    assert.equal(await languageOf(page), lang, "the browser's language is the first one");
    await checkAccessibility(page, `sign-in, ${lang}, ${theme}`);
    await context.close();
  }
}

/** A task held in Stage I, in all languages and appearances. */
async function held(day) {
  const { page } = day.people.zhao;
  await page.goto(day.service.url);
  await page.locator("main a").first().click();
  await page.getByRole("button", { name: "领取下一个标注任务" }).click();
  await page.locator('[data-action="lock"]').waitFor();
  for (const [lang, theme] of APPEARANCES) {
    await setAppearance(page, lang, theme);
    await checkAccessibility(page, `Stage I, ${lang}, ${theme}`);
    await fits(page, `Stage I, ${lang}, ${theme}`);
  }
  // A maneuver of the ego's own has no object that the rule could propose.
  if ((await page.locator("[data-component]").count()) === 0) {
    await page.keyboard.press("n");
    await page.keyboard.press("c");
    await page.waitForFunction(() => document.activeElement?.matches("[data-component] textarea"));
    await page.keyboard.type("An oncoming car is in the junction");
    await page.keyboard.press("Escape");
  }
  await page.locator('[data-saving="saved"]').waitFor();
  await readStageOne(page);
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-section="decisions"]').waitFor();
  for (const [lang, theme] of APPEARANCES) {
    await setAppearance(page, lang, theme);
    await checkAccessibility(page, `Stage II, ${lang}, ${theme}`);
    const below = await page.locator(".form").evaluate((form) => form.scrollHeight - form.clientHeight);
    assert.ok(below <= 0, `Stage II, ${lang}, ${theme}: ${below} px are below the screen`);
    if (lang === "en" && theme === "dark") await shot(day, page, "stage2-en-dark");
  }
  // The language also changes by key, and while a field has the focus.
  await setAppearance(page, "zh", "light");
  await page.keyboard.press("5");
  await page.keyboard.press("Alt+l");
  assert.equal(await languageOf(page), "en");
  await page.keyboard.press("Alt+l");
}

/** What people write is text, never markup: shown as it was typed, wherever it is shown. */
async function markup(day) {
  const nasty = '<img src=x onerror="window.broken=1"><b>粗体</b>';
  const lead = day.people.wang.page;
  await lead.goto(`${day.service.url}/projects/${day.project}`);
  await lead.getByLabel("标注指南").fill(nasty);
  await lead.getByRole("button", { name: "保存" }).click();
  await lead.getByText("已保存。").waitFor();
  const { page } = day.people.zhao;
  await page.locator('[data-action="guide"]').click();
  await page.getByRole("dialog").getByText(nasty).waitFor();
  assert.equal(await page.locator("dialog img, dialog b").count(), 0);
  assert.equal(await page.evaluate(() => window.broken), undefined);
  await page.keyboard.press("Escape");
}

async function keys(day) {
  const { page } = day.people.zhao;
  await page.goto(`${day.service.url}/settings`);
  const row = page.locator("li", { hasText: "播放 / 暂停" });
  await row.getByRole("button").click();
  await page.keyboard.press("n");
  await page.getByText("N 已用于“选下一个目标”。").waitFor();
  await row.getByRole("button").click();
  await page.keyboard.press("j");
  await row.getByText("J", { exact: true }).waitFor();
  await page.getByRole("button", { name: "恢复默认" }).click();
  await row.getByText("Space", { exact: true }).waitFor();
}

async function tokens(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/settings`);
  await page.locator("#token-name").fill("夜间导出");
  await page.getByRole("button", { name: "创建令牌" }).click();
  const token = await page.locator("input[readonly]").inputValue();
  const ask = () =>
    fetch(`${day.service.url}/api/v1/projects/${day.project}/export?format=labels`, { headers: { authorization: `Bearer ${token}` } });
  const answer = await ask();
  assert.equal(answer.status, 200);
  assert.equal((await answer.text()).trim().split("\n").length, 1);
  await page.getByRole("button", { name: "吊销" }).click();
  await page.getByRole("button", { name: "吊销" }).waitFor({ state: "detached" });
  assert.equal((await ask()).status, 401);
}

async function leaving(day) {
  const { page } = day.people.zhao;
  await page.getByRole("button", { name: "退出登录" }).click();
  await page.getByRole("heading", { name: "登录" }).waitFor();
  const status = await page.evaluate(async () => (await fetch("/api/v1/projects")).status);
  assert.equal(status, 401);
}

export const screens = [
  ["every screen, both languages, dark and light: axe, width, no reload", all],
  ["the sign-in follows the browser's language and appearance", door],
  ["the labelling screen while one works: both languages, dark and light", held],
  ["what people write is shown as text, never run as markup", markup],
  ["the list of episodes keeps its filter; moments without a class are apart", episodes],
  ["every screen fits at 200 %", enlarged],
  ["a key is given to another action, a clash is refused", keys],
  ["an API token exports, and not after it was revoked", tokens],
  ["signing out ends the session", leaving],
];
