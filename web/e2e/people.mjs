// A person at a browser: one context each, as on a machine of their own. Counts pointer presses, listens for faults of
// the page, and looks with axe.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
/** How long a step may take: a machine that does much else is slow, and waiting costs nothing where it is not. */
export const PATIENCE_MS = 30_000;
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** Opens a browser for one person. `faults` fills with what the page says to the console; the test ends on any. */
export async function person(browser, url, { lang = "zh", theme = "light", faults, width = 1280, height = 800 }) {
  const context = await browser.newContext({
    viewport: { width, height },
    locale: lang === "zh" ? "zh-CN" : "en-GB",
    timezoneId: "Asia/Shanghai",
    colorScheme: theme,
    acceptDownloads: true,
  });
  await context.addInitScript(() => {
    window.pointerPresses = 0;
    addEventListener("pointerdown", () => window.pointerPresses++, true);
  });
  const watch = (page) => {
    page.setDefaultTimeout(PATIENCE_MS);
    page.on("pageerror", (e) => faults.push(`page error: ${e.message}`));
    page.on("console", (m) => {
      // A refusal of the server is the page's to show; the browser's own line on it says nothing new.
      const network = /Failed to load resource|net::ERR_/.test(m.text());
      if (m.type() === "error" && !network) faults.push(`console: ${m.text()}`);
    });
    return page;
  };
  const page = watch(await context.newPage());
  await page.goto(url);
  return { context, page, url, tab: async (path) => watch(await context.newPage()).goto(url + path) };
}

/** Waits until the page shows what it knows: answers are here, fonts and images too, and they are drawn. */
export async function settled(page) {
  await page.waitForLoadState("networkidle");
  await page.evaluate(async () => {
    await document.fonts.ready;
    await Promise.all([...document.images].map((image) => image.decode().catch(() => {})));
    for (let n = 0; n < 2; n++) await new Promise((drawn) => requestAnimationFrame(drawn));
  });
}

/** Waits until Stage I was on screen long enough to be locked. */
export async function readStageOne(page) {
  await page.locator('[data-action="lock"]:not([disabled])').waitFor();
}

/** The first user of a fresh service makes an account, and with it becomes the administrator. */
export async function makeFirstAccount(page, name, display, password) {
  await page.getByLabel("用户名").fill(name);
  await page.getByLabel("显示名").fill(display);
  await page.getByLabel("密码", { exact: true }).fill(password);
  await page.getByLabel("再次输入密码").fill(password);
  await page.keyboard.press("Enter");
  await page.locator("header .who").waitFor();
}

/** By how much the labeling form is higher than its room in each language that is above 0: `[language, px]`. */
export async function tooHigh(page, found) {
  for (let n = 0; n < 2; n++) {
    const [lang, px] = await page.evaluate(() => {
      const form = document.querySelector(".form");
      return [document.documentElement.lang, form.scrollHeight - form.clientHeight];
    });
    if (px > 0) await found(lang, px);
    await page.keyboard.press("Alt+l");
    await page.waitForFunction((before) => document.documentElement.lang !== before, lang);
  }
}

export async function signIn(page, name, password) {
  await page.locator("#name").fill(name);
  await page.locator("#password").fill(password);
  await page.keyboard.press("Enter");
  await page.locator("header .who").waitFor();
}

/** Serious and critical faults that axe found anywhere: the test's last step wants none. */
export const seriousFindings = [];

/** Looks with axe at what is shown now. */
export async function checkAccessibility(page, where) {
  await page.evaluate(axeSource);
  const found = await page.evaluate(async (rules) => {
    const { violations } = await window.axe.run(document, { runOnly: rules });
    return violations.map((v) => ({ impact: v.impact, id: v.id, at: v.nodes.map((n) => n.target.join(" ")).slice(0, 5), why: v.nodes.flatMap((n) => n.any.map((c) => c.message)).slice(0, 2) }));
  }, RULES);
  seriousFindings.push(...found.filter((v) => v.impact === "serious" || v.impact === "critical").map((v) => ({ where, ...v })));
  return found;
}

/** Presses Tab until `target` has the focus: as a user without a mouse does. */
export async function tabTo(page, target, key = "Tab") {
  for (let n = 0; n < 250; n++) {
    if (await target.evaluate((e) => e === document.activeElement)) return;
    await page.keyboard.press(key);
  }
  throw new Error(`${target} cannot be reached with ${key}`);
}

/**
 * Types Chinese as an input method does: letters being composed, then the text. Keys of the page must not act on it.
 */
export async function typeChinese(page, text) {
  const session = await page.context().newCDPSession(page);
  await session.send("Input.imeSetComposition", { text: "pinyin", selectionStart: 6, selectionEnd: 6 });
  await session.send("Input.insertText", { text });
  await session.detach();
}

/** Asks the API as the person whose page this is. */
export const ask = (page, method, path, body) =>
  page.evaluate(
    async ([method, path, body]) => {
      const { csrf } = await (await fetch("/api/v1/session")).json();
      const headers = { "x-csrf-token": csrf, "content-type": "application/json" };
      const reply = await fetch(`/api/v1${path}`, { method, headers, body: body === undefined ? undefined : JSON.stringify(body) });
      const text = await reply.text();
      if (!reply.ok) throw new Error(`${method} ${path}: ${reply.status} ${text}`);
      return text === "" ? null : JSON.parse(text);
    },
    [method, path, body],
  );
