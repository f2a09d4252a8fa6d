// Blind overlap: two people label one episode, each for themselves; a lead sees both side by side and takes one; the
// dashboard says how far they agree. Their labels are made through the API: the page's own way is walked in label.mjs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { ask, person, checkAccessibility, signIn } from "./people.mjs";
import { whyroad } from "./service.mjs";
import { shot } from "./shots.mjs";

const PASSWORD = "欲穷千里目-更上一层楼";
const NAME = "独立标注对比";
/** Annotators of each episode: more tasks than one page of the list. */
const EACH = 7;

async function prepare(day) {
  const { page } = day.people.admin;
  const project = await ask(page, "POST", "/projects", { name: NAME });
  day.blind = project.id;
  await ask(page, "POST", `/projects/${project.id}/members`, { user: "wang", roles: ["lead"] });
  for (const [name, display] of [["zhou", "周敏"], ["wu", "吴昊"]]) {
    await ask(page, "POST", "/users", { name, display, password: PASSWORD });
    await ask(page, "POST", `/projects/${project.id}/members`, { user: name, roles: ["annotator"] });
    const someone = await person(day.browser, day.service.url, { faults: day.faults });
    await signIn(someone.page, name, PASSWORD);
    day.people[name] = someone;
  }
}

/** A lead uploads one episode and wants two people for it. */
async function upload(day) {
  const mined = `${day.demo ?? join(day.data, "demo")}/mined/episodes.jsonl`;
  const line = readFileSync(mined, "utf8").split("\n").find((l) => l.includes("reactive_agent.cutin.urgent"));
  const file = join(day.scratch, "one.jsonl");
  writeFileSync(file, `${line}\n`);
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks`);
  await page.getByRole("button", { name: "从挖掘结果创建任务" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("来源").selectOption("");
  await dialog.locator("input[type=file]").setInputFiles(file);
  await dialog.getByLabel("独立（背靠背）标注人数").fill("2");
  await dialog.getByRole("button", { name: "创建任务" }).click();
  await dialog.getByText("已创建 2 个任务").waitFor({ timeout: 60_000 });
  await page.keyboard.press("Escape");
  await page.getByText("已列出 2 个任务").waitFor();
  assert.equal(await page.getByText("独立标注", { exact: true }).count(), 2);
}

async function labelAs(day, who, trace) {
  const { page } = day.people[who];
  const task = await ask(page, "POST", `/projects/${day.blind}/tasks:next`, { kind: "label" });
  const id = task.task.id;
  const act = (action, fence) => ask(page, "POST", `/tasks/${id}/actions`, { action, fence });
  await act("lock_stage1", task.fence);
  const open = await ask(page, "POST", `/tasks/${id}/safety`, { fence: task.fence, answer: "safe" });
  const changes = [
    { path: "/coc_trace", value: trace },
    { path: "/driving_decision/longitudinal", value: "yield_to_agent" },
    { path: "/driving_decision/lateral", value: null },
  ];
  const saved = await ask(page, "PATCH", `/tasks/${id}/draft`, { fence: open.fence, base_version: open.version, changes });
  assert.deepEqual(saved.findings.filter((f) => f.severity === "error"), []);
  await act("submit", open.fence);
  return id;
}

async function both(day) {
  const first = await labelAs(day, "zhou", "左侧车道的车压线切入，车速低于自车，车距不足，因此减速让行。");
  // Blind: the other is given a task of their own and cannot see this one.
  const { page } = day.people.wu;
  const seen = await page.evaluate(async (t) => (await fetch(`/api/v1/tasks/${t}`)).status, first);
  assert.ok(seen === 403 || seen === 404, `${seen}`);
  const second = await labelAs(day, "wu", "前方左侧轿车正在并入本车道，两车接近，需要留出空间，因此减速让行。");
  assert.notEqual(first, second);
  day.pair = [first, second];
}

async function sideBySide(day) {
  const { page } = day.people.wang;
  // Both labels are handed in and none was chosen: it opens side by side.
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks?overlap=to_choose`);
  await page.getByText("已列出 2 个任务").waitFor();
  await page.goto(`${day.service.url}/tasks/${day.pair[0]}`);
  const dialog = page.locator("section.adjudicate");
  await page.locator("canvas").first().waitFor();
  await dialog.getByText("周敏").waitFor();
  await dialog.getByText("前方左侧轿车正在并入本车道").waitFor();
  await checkAccessibility(page, "side by side");
  await shot(day, page, "side-by-side");
  await dialog.getByRole("button", { name: "采用这一份" }).nth(1).click();
  await dialog.waitFor({ state: "detached" });
  // The chosen label is shown; the other one says what became of it.
  await page.waitForURL(`**/tasks/${day.pair[1]}`);
  await page.goto(`${day.service.url}/tasks/${day.pair[0]}`);
  await page.getByText("裁决采用了另一份，导出不含这一份。").waitFor();
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks`);
  await page.getByText("未采用", { exact: true }).waitFor();
  await page.getByText("已采用", { exact: true }).waitFor();
}

/**
 * Both chose the same: no kappa, because agreement beyond chance cannot be message of one choice; keyframes 0 s apart.
 */
async function agreement(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.blind}/dashboard`);
  await page.getByText("1 个事件，1 对标注").waitFor();
  await page.getByText("关键帧相差：中位数 0 s，最大 0 s").waitFor();
  await checkAccessibility(page, "agreement");
}

/** More tasks than one page of the list: each once, also after a filter. */
async function pages(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks`);
  await page.getByRole("button", { name: "从挖掘结果创建任务" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("最大任务数", { exact: true }).fill("200");
  await dialog.getByLabel("独立（背靠背）标注人数").fill(String(EACH));
  await dialog.getByRole("button", { name: "创建任务" }).click();
  const message = await dialog.getByText(/已创建 \d+ 个任务/).textContent({ timeout: 120_000 });
  const all = Number(message.match(/\d+/)[0]) + day.pair.length;
  assert.ok(all > 100, `${all} tasks`);
  await page.keyboard.press("Escape");
  await page.getByText(`共 ${all} 个任务，已列出 100 个`).waitFor();
  await page.getByRole("button", { name: "加载更多" }).click();
  await page.getByText(`已列出 ${all} 个任务`).waitFor();
  // Only rows in view are drawn.
  const links = await page.locator(".scroll:has(tbody)").evaluate(async (box) => {
    const found = [];
    for (let top = 0; top < box.scrollHeight; top += box.clientHeight / 2) {
      box.scrollTop = top;
      await new Promise((drawn) => setTimeout(drawn, 100));
      found.push(...[...box.querySelectorAll("tbody a[href*='/tasks/']")].map((a) => a.getAttribute("href")));
    }
    return found;
  });
  assert.equal(new Set(links).size, all);
  assert.equal(await page.getByRole("button", { name: "加载更多" }).count(), 0);
  await page.getByLabel("状态").selectOption({ label: "待质检" });
  // The copy that was not chosen is never checked: no state finds it.
  await page.getByText("已列出 1 个任务").waitFor();
  // The heading ticks all that are listed.
  await page.getByRole("checkbox", { name: "全选已列出的任务" }).check();
  await page.getByRole("button", { name: "更改 1 个任务…" }).waitFor();
  await page.getByRole("checkbox", { name: "全选已列出的任务" }).uncheck();
  await page.getByRole("button", { name: /更改 \d+ 个任务…/ }).waitFor({ state: "detached" });
  // A part of a class's name finds the class.
  await page.getByRole("button", { name: "清除筛选" }).click();
  await page.getByLabel("搜索").fill("蠕行");
  await page.getByRole("button", { name: "蠕行跟车" }).click();
  await page.waitForURL(/scenario=reactive_agent\.following\.creeping/);
}

/** The same on the command line: what the page shows is in the store that the commands read. */
async function listed(day) {
  const out = whyroad("--lang", "zh", "tasks", "list", "--data", day.data, "--project", NAME);
  for (const id of day.pair) assert.ok(out.includes(id), out);
}

/** Of the labels of one episode all but two are left out; these set the keyframe 1 s apart, and the lead finds them. */
async function disagreeing(day) {
  const { page } = day.people.wang;
  const copies = (await ask(page, "GET", `/projects/${day.blind}/tasks?scenario=reactive_agent.vru_crossing.crosswalk&sort=clip&limit=${EACH}`)).items;
  for (const task of copies.slice(2)) await ask(page, "POST", `/tasks/${task.id}/actions`, { action: "skip", reason: "两人足够" });
  for (const [n, who] of ["zhou", "wu"].entries()) {
    const { page } = day.people[who];
    const path = `/tasks/${copies[n].id}`;
    await ask(day.people.wang.page, "POST", `${path}/assign`, { user: who });
    const { fence } = await ask(page, "POST", `${path}/lease`, { action: "take" });
    const { draft, version } = await ask(page, "GET", path);
    const moment = new Date(Date.parse(draft.keyframe.timestamp) - 1000 * n).toISOString();
    const stage1 = [
      { path: "/keyframe/timestamp", value: moment },
      { path: "/keyframe/frame_idx", value: draft.keyframe.frame_idx - 10 * n },
      ...draft.critical_components.map((_, c) => ({ path: `/critical_components/${c}/evidence_times`, value: [moment] })),
    ];
    if (n > 0) await ask(page, "PATCH", `${path}/draft`, { fence, base_version: version, changes: stage1 });
    await ask(page, "POST", `${path}/actions`, { action: "lock_stage1", fence });
    const open = await ask(page, "POST", `${path}/safety`, { fence, answer: "safe" });
    const range = [
      { path: "/time_range/start_timestamp", value: moment },
      { path: "/time_range/start_frame_idx", value: draft.keyframe.frame_idx - 10 * n },
    ];
    // The drafted state and decision, with a custom reason.
    const [state] = open.draft.coc_trace.replace("【草稿】", "").split(/[；。]/);
    // One of them also names what no component has: a finding.
    const trace = `${state}${n > 0 ? "，旁边还有一辆公交车" : ""}；对方的路线与自车相交，两者的距离不足以先过，因此${open.draft.coc_trace.split(/因此|所以/).at(-1)}`;
    await ask(page, "PATCH", `${path}/draft`, { fence, base_version: open.version, changes: [...range, { path: "/coc_trace", value: trace }] });
    await ask(page, "POST", `${path}/actions`, { action: "submit", fence });
  }
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks`);
  const box = page.getByLabel("分歧");
  await box.check();
  await page.getByText("已列出 2 个任务").waitFor();
  assert.match(page.url(), /overlap=disagreeing/);
  assert.equal(await page.locator("tbody .chip.warn", { hasText: "分歧" }).count(), 2);
  await checkAccessibility(page, "disagreeing");
  await shot(day, page, "disagreeing");
  // It opens side by side.
  await page.locator("tbody a").first().click();
  const both = page.locator("section.adjudicate");
  await both.getByText("周敏").waitFor();
  // What the validator says of each label can be read there.
  const findings = both.locator("td details");
  await findings.locator("summary").click();
  await findings.getByText("公交车").waitFor();
  await shot(day, page, "compared-findings");
  await both.getByRole("button", { name: "采用这一份" }).first().click();
  await both.waitFor({ state: "detached" });
  await page.goto(`${day.service.url}/projects/${day.blind}/tasks?overlap=disagreeing`);
  await page.getByText("没有符合条件的任务").waitFor();
}

export const overlap = [
  ["a project for blind overlap", prepare],
  ["a lead uploads an episode for two people", upload],
  ["each labels it without seeing the other", both],
  ["the lead sees both side by side and takes one", sideBySide],
  ["the dashboard says how far they agree", agreement],
  ["the list comes in pages, each task once", pages],
  ["the command line lists the same tasks", listed],
  ["a lead finds labels that disagree, and chooses one", disagreeing],
];
