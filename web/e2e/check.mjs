// Check, rework, audit, export: what turns a submitted label into an accepted one.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { PROJECT } from "./begin.mjs";
import { checkAccessibility } from "./people.mjs";
import { whyroad } from "./service.mjs";
import { shot } from "./shots.mjs";

const COMMENT = "推理里没有写出对方为何迫使自车减速，请写明车距。";
const home = async (day, who) => {
  const { page } = day.people[who];
  await page.goto(day.service.url);
  await page.getByRole("link", { name: PROJECT }).click();
  return page;
};

async function sendBack(day) {
  const page = await home(day, "chen");
  await page.getByRole("button", { name: "领取下一个质检任务" }).click();
  await page.waitForURL(`**/tasks/${day.task}`);
  const trace = page.locator('[data-field="/coc_trace"]');
  await trace.locator("button[aria-expanded]").click();
  await trace.locator("form textarea").fill(COMMENT);
  await trace.getByRole("button", { name: "写意见" }).click();
  await trace.getByText(COMMENT).waitFor();
  await checkAccessibility(page, "check");
  await page.locator('[data-action="accept"]:not(:disabled)').waitFor();
  await shot(day, page, "check");
  // One card, the range in a loop.
  await page.getByRole("button", { name: "循环", pressed: true }).waitFor();
  // A label with what the checker asks for is not accepted by one press.
  await page.keyboard.press("a");
  await page.getByText("您有 1 条未解决的意见").waitFor();
  // By one key, from where the comment left the focus: the comment says why.
  await page.keyboard.press("b");
  await page.locator('[data-action="next"]').waitFor();
  await page.getByText("已退回：等待标注员修改。").waitFor();
}

async function rework(day) {
  const { page } = day.people.li;
  await page.goto(`${day.service.url}/tasks/${day.task}`);
  await page.getByText(COMMENT).first().waitFor();
  if (await page.locator('[data-action="take"]').count()) await page.locator('[data-action="take"]').click();
  await page.locator('[data-action="submit"]').waitFor();
  const trace = page.locator('[data-field="/coc_trace"]');
  await trace.getByRole("textbox", { name: "原因" }).fill(day.slots.reason.replace("原有车距", "原有约 18 m 的车距"));
  await trace.getByRole("button", { name: "标为已解决" }).click();
  // The answer of the safety filter stands.
  await page.getByRole("button", { name: "合法且安全", pressed: true }).waitFor();
  await page.locator('[data-saving="saved"]').waitFor();
  await shot(day, page, "rework");
  await page.locator('[data-action="submit"]').click();
  await page.locator('[data-action="next"]').waitFor();
}

async function accept(day) {
  // Still on the label that went back: it is the next one, and is shown as it is now.
  const { page } = day.people.chen;
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-action="accept"]').waitFor();
  assert.ok(page.url().endsWith(`/tasks/${day.task}`));
  // What was changed since it was returned is marked, and nothing else.
  const added = page.locator('[data-field="/coc_trace"] ins');
  await added.getByText("约 18 m 的").waitFor();
  assert.equal(await added.count(), 1);
  assert.equal(await page.locator('[data-field="/coc_trace"] del').count(), 0);
  await checkAccessibility(page, "second check");
  await shot(day, page, "recheck");
  // The key that led here does not accept, and no label is accepted before it was on screen for a while.
  await page.reload();
  const accept = page.locator('[data-action="accept"]');
  await accept.waitFor();
  assert.ok(await accept.isDisabled());
  await page.keyboard.press("a");
  await page.getByText("请先看标注：显示 3 秒后才能接受。").waitFor();
  await page.keyboard.press("Control+Enter");
  await page.getByText("Ctrl+Enter 不接受标注：看过之后按 A。").waitFor();
  await page.locator('[data-action="accept"]:not(:disabled)').waitFor();
  assert.equal(await page.locator('[data-action="next"]').count(), 0, "nothing was accepted");
  await page.keyboard.press("a");
  await page.locator('[data-action="next"]').waitFor();
}

async function audit(day) {
  const page = await home(day, "sun");
  await page.getByRole("button", { name: "领取下一个抽检任务" }).click();
  await page.waitForURL(`**/tasks/${day.task}`);
  await page.locator('[data-action="accept"]').click();
  await page.locator('[data-action="next"]').waitFor();
  await page.locator('[data-action="history"]').click();
  const history = page.getByRole("dialog");
  await history.getByText("李明").first().waitFor();
  await history.locator("ins", { hasText: "约 18 m 的" }).first().waitFor();
  await checkAccessibility(page, "history");
  await shot(day, page, "history");
  await page.keyboard.press("Escape");
}

async function take(day) {
  const page = await home(day, "wang");
  await page.getByRole("link", { name: "导入与导出" }).click();
  const coming = page.waitForEvent("download");
  await page.getByRole("link", { name: "导出标注 (JSONL)" }).click();
  const download = await coming;
  assert.equal(download.suggestedFilename(), `${PROJECT}-labels-accepted-2.1.jsonl`);
  const file = join(day.scratch, "labels.jsonl");
  await download.saveAs(file);
  const labels = readFileSync(file, "utf8").trim().split("\n").map((line) => JSON.parse(line));
  assert.equal(labels.length, 1);
  const [label] = labels;
  assert.equal(label.driving_decision.longitudinal, "yield_to_agent");
  assert.equal(label.driving_decision.lateral, null);
  assert.match(label.coc_trace, /约 18 m 的车距/);
  assert.ok(label.critical_components.some((c) => c.description.startsWith("左侧车道的车压线切入")));
  assert.ok(label.causes.longitudinal.components.length > 0);
  day.labels = file;
}

async function validate(day) {
  whyroad("--lang", "zh", "validate", day.labels);
  // The test can fail: a label whose evidence comes after its keyframe does not pass.
  const broken = readFileSync(day.labels, "utf8").replace(/"evidence_times":\["[^"]+"/, '"evidence_times":["2099-01-01T00:00:00.000Z"');
  const file = join(day.scratch, "broken.jsonl");
  writeFileSync(file, broken);
  assert.throws(() => whyroad("--lang", "zh", "validate", file));
}

export const check = [
  ["a checker sends the label back with a remark on its trace", sendBack],
  ["the annotator corrects it and submits again", rework],
  ["the checker accepts it", accept],
  ["an auditor audits it and reads its history", audit],
  ["the lead exports the accepted label", take],
  ["whyroad validate passes the export, and not a broken one", validate],
];
