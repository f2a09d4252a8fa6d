// What goes wrong in a day: no network, a page that dies, two tabs, a service that is killed, a task taken away. After
// each of them everything that was typed is there, and the users were informed.
import assert from "node:assert/strict";
import { PROJECT } from "./begin.mjs";
import { checkAccessibility, PATIENCE_MS, readStageOne } from "./people.mjs";
import { shot } from "./shots.mjs";

const description = (page, n) => page.locator(`[data-component="${n}"] textarea`);
const saving = (page, how) => page.locator(`[data-saving="${how}"]`);

/** The draft as the server has it. */
async function stored(page, task) {
  const reply = await page.evaluate(async (t) => (await fetch(`/api/v1/tasks/${t}`)).json(), task);
  return reply.draft.critical_components.map((c) => c.description);
}

async function until(read, wanted, what) {
  let last;
  for (let n = 0; n < PATIENCE_MS / 150; n++) {
    last = await read();
    if (wanted(last)) return last;
    await new Promise((done) => setTimeout(done, 150));
  }
  throw new Error(`${what}: ${JSON.stringify(last)}`);
}

async function takeOne(day) {
  const { page } = day.people.zhao;
  await page.goto(day.service.url);
  await page.getByRole("link", { name: PROJECT }).click();
  await page.getByRole("button", { name: "领取下一个标注任务" }).click();
  await page.locator('[data-action="lock"]').waitFor();
  day.second = new URL(page.url()).pathname.split("/")[2];
  await page.locator("canvas").waitFor();
  day.row = await page.locator("[data-component]").count();
  await page.keyboard.press("c");
  await description(page, day.row).fill("在线写下的一句");
  await saving(page, "saved").waitFor();
}

async function offline(day) {
  const { page, context } = day.people.zhao;
  await context.setOffline(true);
  await description(page, day.row).fill("断网时写下的一句");
  await saving(page, "offline").waitFor();
  assert.match(await saving(page, "offline").innerText(), /离线：1 处修改只在本机/);
  // Nothing is locked unsaved, and the page says so; what it has not checked is not free of findings.
  await readStageOne(page);
  await page.keyboard.press("Control+Enter");
  await page.getByText("离线，未执行：修改保存在本机").waitFor();
  assert.match(await saving(page, "offline").innerText(), /离线：1 处修改只在本机/);
  await page.locator('[data-section="findings"]').getByText("尚未校验").waitFor();
  await shot(day, page, "offline");
  await context.setOffline(false);
  await saving(page, "saved").waitFor();
  assert.equal((await stored(page, day.second))[day.row], "断网时写下的一句");
}

async function crash(day) {
  const { page, context } = day.people.zhao;
  await page.route("**/draft", (route) => route.abort());
  await description(page, day.row).fill("页面崩溃前写下的一句");
  await saving(page, "offline").waitFor();
  const address = page.url();
  // Not closed, which would let it save: its process is killed.
  const died = page.waitForEvent("crash");
  void (await context.newCDPSession(page)).send("Page.crash").catch(() => {});
  await died;
  await page.close();
  const next = await context.newPage();
  next.setDefaultTimeout(PATIENCE_MS);
  await next.goto(address);
  await next.getByText("已恢复上次未保存的修改").waitFor();
  assert.equal(await description(next, day.row).inputValue(), "页面崩溃前写下的一句");
  await saving(next, "saved").waitFor();
  assert.equal((await stored(next, day.second))[day.row], "页面崩溃前写下的一句");
  day.people.zhao.page = next;
}

/** A component that was removed is back with one stroke, also from within a text. */
async function removed(day) {
  const { page } = day.people.zhao;
  const before = await stored(page, day.second);
  await description(page, day.row).click();
  await page.keyboard.press("Escape");
  await page.keyboard.press("Delete");
  await until(() => stored(page, day.second), (all) => all.length === before.length - 1, "it is removed");
  const others = page.locator("[data-component] textarea");
  if ((await others.count()) > 0) await others.first().click();
  await page.keyboard.press("Control+z");
  await description(page, day.row).waitFor();
  await page.keyboard.press("Escape");
  assert.deepEqual(await until(() => stored(page, day.second), (all) => all.length === before.length, "it is back"), before);
}

async function twoTabs(day) {
  const { page, context } = day.people.zhao;
  const other = await context.newPage();
  other.setDefaultTimeout(PATIENCE_MS);
  await other.goto(page.url());
  await other.locator('[data-action="lock"]').waitFor();
  for (const tab of [page, other]) await tab.getByText("此任务也在您的另一个标签页中打开").waitFor();
  await description(other, day.row).fill("在另一个标签页写下的一句");
  await saving(other, "saved").waitFor();
  await until(() => description(page, day.row).inputValue(), (v) => v === "在另一个标签页写下的一句", "the first tab follows");
  day.other = other;
}

async function conflict(day) {
  const { page } = day.people.zhao;
  await page.route("**/draft", (route) => route.abort());
  await description(page, day.row).fill("这一页的说法");
  await saving(page, "offline").waitFor();
  await description(day.other, day.row).fill("另一页的说法");
  await saving(day.other, "saved").waitFor();
  await page.unroute("**/draft");
  const asked = page.getByRole("alertdialog");
  await asked.waitFor();
  const text = await asked.innerText();
  for (const word of ["这一页的说法", "另一页的说法", "我的", "别处的", "描述"]) assert.ok(text.includes(word), `${word} in ${text}`);
  assert.ok(!/[{}"]|critical_components/.test(text), `no JSON for people: ${text}`);
  await page.keyboard.press("Control+Enter");
  await page.getByText("未执行：同一处有两种修改").waitFor();
  await shot(day, page, "conflict");
  await checkAccessibility(page, "conflict");
  await asked.getByRole("button", { name: "用这个" }).first().click();
  await saving(page, "saved").waitFor();
  assert.equal((await stored(page, day.second))[day.row], "这一页的说法");
  await until(() => description(day.other, day.row).inputValue(), (v) => v === "这一页的说法", "the other tab follows");
  await day.other.close();
  await page.getByText("此任务也在您的另一个标签页中打开").waitFor({ state: "detached" });
}

async function killed(day) {
  const { page } = day.people.zhao;
  const { port } = day.service;
  await description(page, day.row).fill("服务被杀死时写下的一句");
  await day.service.stop("SIGKILL");
  await page.locator("[data-component]").first().click();
  await description(page, day.row).fill("服务不在时写下的一句");
  await saving(page, "offline").waitFor();
  day.service = await day.restart(port);
  await saving(page, "saved").waitFor({ timeout: 30_000 });
  assert.equal((await stored(page, day.second))[day.row], "服务不在时写下的一句");
}

async function takenAway(day) {
  const { page } = day.people.zhao;
  const lead = day.people.wang.page;
  // A lead needs no lease to leave a task out.
  const gone = await lead.evaluate(async (t) => {
    const { csrf } = await (await fetch("/api/v1/session")).json();
    const headers = { "x-csrf-token": csrf, "content-type": "application/json" };
    const body = JSON.stringify({ action: "skip", reason: "重复的片段" });
    return (await fetch(`/api/v1/tasks/${t}/actions`, { method: "POST", headers, body })).status;
  }, day.second);
  assert.equal(gone, 200);
  await description(page, day.row).fill("任务被转走时写下的一句");
  await page.getByText("此任务已被他人领取").waitFor();
  const kept = await page.evaluate(() => JSON.stringify({ ...localStorage }));
  assert.ok(kept.includes("任务被转走时写下的一句"), "what was typed is still on this machine");
  assert.equal(await description(page, day.row).count(), 0, "nothing more can be typed into another's task");
  await shot(day, page, "lost-lease");
  // After a reload, too: to read and to copy.
  await page.reload();
  await page.getByText("本机保留的未保存修改").waitFor();
  await page.getByText("任务被转走时写下的一句").waitFor();
}

export const troubles = [
  ["an annotator takes the next task of the queue", takeOne],
  ["without network what is typed stays here, and is saved on return", offline],
  ["a component that was removed comes back, and nothing else changes", removed],
  ["a page that dies loses nothing", crash],
  ["two tabs of one person show one draft", twoTabs],
  ["one field changed in two places: both sides in words, one is chosen", conflict],
  ["a killed service: what is typed meanwhile arrives after its restart", killed],
  ["a task taken away: reported, nothing overwritten, nothing lost", takenAway],
];
