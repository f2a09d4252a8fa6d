// An annotator labels one task in Chinese with the keyboard only, through both stages. The pointer is never pressed.
import assert from "node:assert/strict";
import { checkAccessibility, readStageOne, settled, tabTo, typeChinese } from "./people.mjs";
import { PROJECT } from "./begin.mjs";
import { shot } from "./shots.mjs";

const section = (page, id) => page.locator(`[data-section="${id}"]`);
const saved = (page) => page.locator('[data-saving="saved"]').waitFor();
const focused = (page) => page.evaluate(() => document.activeElement?.outerHTML.slice(0, 120) ?? "");

/** Takes the assigned task from the list: Tab to its link, Enter. */
async function open(day) {
  const { page } = day.people.li;
  await page.goto(day.service.url);
  await page.getByRole("link", { name: PROJECT }).waitFor();
  await page.evaluate(() => (window.pointerPresses = 0));
  await tabTo(page, page.getByRole("link", { name: PROJECT }));
  await page.keyboard.press("Enter");
  const task = page.getByRole("link", { name: "紧急Cutin" });
  await task.waitFor();
  await tabTo(page, task);
  // Pressed before the scene is there, the key waits for it: taking the task needs no second press.
  let arrive = () => {};
  const arrived = new Promise((done) => (arrive = done));
  await page.route("**/scene", (route) => arrived.then(() => route.continue()));
  await page.keyboard.press("Enter");
  await page.waitForURL("**/tasks/*");
  await page.keyboard.press("Control+Enter");
  await page.getByText("任务还在加载，Ctrl+Enter 尚未生效。").waitFor();
  arrive();
  await page.locator('[data-action="lock"]').waitFor();
  await page.unroute("**/scene");
  await page.locator("canvas").first().waitFor();
  assert.equal(await page.getByText("任务还在加载").count(), 0);
  // What cannot be taken back is not done by a key pressed too early.
  if (await page.locator('[data-action="lock"][disabled]').count()) {
    await page.keyboard.press("Control+Enter");
    assert.equal(await page.locator('[data-section="decisions"]').count(), 0);
  }
  day.task = new URL(page.url()).pathname.split("/")[2];
}

/** Nothing after the keyframe is shown or even here: the player ends at it. */
async function history(day) {
  const { page } = day.people.li;
  const scene = await page.evaluate(async (t) => (await fetch(`/api/v1/tasks/${t}/scene`)).json(), day.task);
  assert.equal(scene.hidden_until, "stage2");
  assert.ok(Math.max(...scene.t_s) <= 1e-6, "no moment after the keyframe is sent");
  assert.equal(await section(page, "decisions").count(), 0);
  for (const key of ["Home", "ArrowRight", "Shift+ArrowRight", "End", "ArrowLeft", "BracketRight", "BracketLeft", "Minus", "Equal", "Space", "Space", "Digit0"]) {
    await page.keyboard.press(key);
  }
  // Leaving the ego keeps the view: the same picture, and not the origin of the world.
  const picture = async () => {
    await settled(page);
    return page.locator("canvas").first().evaluate((canvas) => canvas.toDataURL());
  };
  await page.keyboard.press("z");
  const before = await picture();
  await page.keyboard.press("f");
  await page.getByRole("button", { name: "跟随自车", pressed: false }).waitFor();
  assert.equal(await picture(), before);
  await page.keyboard.press("w");
  await page.getByRole("button", { name: "速度箭头", pressed: true }).waitFor();
  assert.notEqual(await picture(), before, "arrows are drawn");
  await page.keyboard.press("w");
  await page.keyboard.press("f");
  await page.keyboard.press("?");
  const help = page.getByRole("dialog");
  await help.getByText("把选中的目标加为要素").waitFor();
  await checkAccessibility(page, "help");
  await shot(day, page, "keys");
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "detached" });
}

async function stageOne(day) {
  const { page } = day.people.li;
  const components = page.locator("[data-component]");
  const before = await components.count();
  await page.keyboard.press("t");
  await page.keyboard.press("c");
  await page.locator(`[data-component="${before}"] textarea`).waitFor();
  assert.match(await focused(page), /^<textarea/);
  await typeChinese(page, "左侧车道的车压线切入，距离 22 m");
  // Letters that are keys of the page stay text while one writes.
  await page.keyboard.type("，45 km/h (nckg)");
  await page.keyboard.press("Escape");
  assert.equal(await components.count(), before + 1);
  const value = await page.locator(`[data-component="${before}"] textarea`).inputValue();
  assert.equal(value, "左侧车道的车压线切入，距离 22 m，45 km/h (nckg)");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+Shift+z");
  await page.keyboard.press("1");
  // What the rule proposed beside it stays as it is; every component needs a category.
  for (let n = 0; n < (await components.count()); n++) {
    const category = components.nth(n).locator("select");
    if ((await category.inputValue()) !== "") continue;
    await tabTo(page, category);
    await page.keyboard.press("ArrowDown");
  }
  await saved(page);
  await checkAccessibility(page, "Stage I");
  await shot(day, page, "stage1");
  await page.keyboard.press("Escape");
  await readStageOne(page);
  await page.keyboard.press("Control+Enter");
  await section(page, "decisions").waitFor();
}

/** Chooses a radio of the focused group with the arrow keys. */
async function choose(page, group, value) {
  const wanted = page.locator(`[data-choices=${group}] input[value="${value}"]`);
  for (let n = 0; n < 30; n++) {
    if (await wanted.isChecked()) return;
    await page.keyboard.press("ArrowDown");
  }
  throw new Error(`${value} cannot be chosen with the arrows`);
}

async function stageTwo(day) {
  const { page } = day.people.li;
  // The safety filter comes first: until it is answered no decision can be chosen.
  await page.waitForFunction(() => document.activeElement?.closest("[data-section=safety]"));
  assert.ok(await page.locator("[data-choices=longitudinal] input").first().isDisabled());
  await page.keyboard.press("y");
  // The focus goes to the decisions by itself, and to no choice: a digit leads to a field.
  await page.waitForFunction(() => document.activeElement?.matches("[data-field='/driving_decision/longitudinal']"));
  const chosen = () => page.locator("[data-choices] input:checked").evaluateAll((all) => all.map((one) => one.value));
  const drafted = await chosen();
  await page.keyboard.press("2");
  const at = (group) => page.waitForFunction((g) => document.activeElement?.closest(`[data-choices=${g}]`), group);
  await at("longitudinal");
  assert.deepEqual(await chosen(), drafted);
  await choose(page, "longitudinal", "yield_to_agent");
  await page.keyboard.press("Alt+a");
  await page.keyboard.press("Escape");
  // The direction of a lateral decision has a key of its own; without a direction it leads to the decision.
  await page.keyboard.press("9");
  await at("lateral");
  await choose(page, "lateral", "lane_change");
  await page.keyboard.press("Escape");
  await page.keyboard.press("9");
  await at("direction");
  await page.keyboard.press("2");
  assert.ok(await page.locator('[data-choices=direction] input[value="right"]').isChecked());
  // After a choice by a digit the next one leads to a field; the decision is corrected, and so its direction is gone.
  await page.keyboard.press("3");
  await at("lateral");
  await choose(page, "lateral", "null");
  assert.equal(await page.locator("[data-choices=direction]").count(), 0);
  await page.keyboard.press("Alt+a");
  await page.keyboard.press("Escape");
  await page.keyboard.press("4");
  const cause = section(page, "causes").locator("input[type=checkbox]").first();
  await tabTo(page, cause);
  if (!(await cause.isChecked())) await page.keyboard.press("Space");
  assert.ok(await cause.isChecked());
  await page.keyboard.press("Alt+a");
  await page.keyboard.press("Escape");
  // The draft has state and decision; what is inserted at the caret and typed makes the rest.
  await page.keyboard.press("5");
  assert.match(await focused(page), /slot-state/);
  await page.keyboard.press("Control+a");
  await typeChinese(page, day.slots.state);
  await page.keyboard.press("Enter");
  assert.match(await focused(page), /slot-reason/);
  await page.keyboard.press("Alt+i");
  const menu = page.getByRole("listbox", { name: "插入" });
  await menu.getByText(/自车速度 \d+ km\/h/).waitFor();
  await checkAccessibility(page, "insert");
  await shot(day, page, "insert");
  await page.keyboard.press("1");
  await menu.waitFor({ state: "detached" });
  assert.notEqual(await page.locator('[data-slot="reason"]').inputValue(), "", "the first component was inserted");
  await page.keyboard.press("Control+a");
  await typeChinese(page, day.slots.reason);
  await page.keyboard.press("Enter");
  await page.keyboard.press("Control+a");
  await typeChinese(page, day.slots.decision);
  await page.keyboard.press("Escape");
  // A question to the lead is sent by its own button.
  await page.keyboard.press("q");
  await page.getByLabel("给负责人的问题").waitFor();
  await page.getByRole("button", { name: "发给负责人" }).waitFor();
  await page.keyboard.press("Escape");
  await page.keyboard.press("6");
  const records = section(page, "records").locator("[data-field^='/records/'] input:not([type=radio])");
  for (let n = 0; n < (await records.count()); n++) {
    await tabTo(page, records.nth(n));
    if ((await records.nth(n).inputValue()) === "") await page.keyboard.type("1");
  }
  await page.keyboard.press("Escape");
  await saved(page);
  await checkAccessibility(page, "Stage II");
  await shot(day, page, "stage2");
  assert.match(await section(page, "findings").innerText(), /没有发现问题/);
}

async function submit(day) {
  const { page } = day.people.li;
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-action="next"]').waitFor();
  assert.equal(await page.evaluate(() => window.pointerPresses), 0, "no pointer was pressed");
}

export const label = [
  ["an annotator opens the assigned task by keyboard", open],
  ["Stage I shows history only; `?` shows the keys", history],
  ["Stage I: components in Chinese by keyboard, then locked", stageOne],
  ["Stage II: decision, causes, trace, records by keyboard", stageTwo],
  ["the label is submitted without a pointer", submit],
];
