// Tasks of another class: an annotator says that the class is wrong, a lead makes the task of the class that fits; an
// episode that no class explains becomes a task.
import assert from "node:assert/strict";
import { ask, checkAccessibility } from "./people.mjs";
import { shot } from "./shots.mjs";

const RIGHT = "稳态跟车";

/** An open task that `person` may begin, assigned to them. */
async function anOpenTask(day, name) {
  const { page } = day.people.wang;
  const open = (await ask(page, "GET", `/projects/${day.project}/tasks?state=open&limit=200`)).items;
  for (const task of open) {
    const given = await ask(page, "POST", `/tasks/${task.id}/assign`, { user: name }).then(() => true, () => false);
    if (given && !task.scenario_id.endsWith(".steady")) return task;
  }
  throw new Error("no open task");
}

async function sayWrong(day) {
  const task = await anOpenTask(day, "zhao");
  const { page } = day.people.zhao;
  await page.goto(`${day.service.url}/tasks/${task.id}`);
  await page.locator('[data-action="take"]').click();
  await page.locator('[data-action="skip"]').waitFor();
  // By keys alone.
  await page.keyboard.press("Shift+C");
  const dialog = page.getByRole("dialog");
  await page.keyboard.type("稳态");
  // One class has it in its name.
  await dialog.getByText("按 Enter 选择“稳态跟车”。").waitFor();
  await dialog.getByLabel("应为哪个场景").fill(RIGHT);
  await dialog.getByRole("paragraph").filter({ hasText: "跟车响应" }).waitFor();
  await checkAccessibility(page, "wrong class");
  await page.keyboard.press("Enter");
  await page.locator('[data-action="next"]').waitFor();
  day.wrong = task.id;
}

async function remake(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.project}/tasks`);
  await page.getByLabel("场景不对").check();
  await page.getByText("已列出 1 个任务").waitFor();
  await page.getByText(`应为：${RIGHT}`).waitFor();
  // The keyframe is told by its time in the drive.
  await page.getByRole("cell", { name: /^\d+\.\d s$/ }).waitFor();
  await shot(day, page, "wrong-class");
  await page.locator("tbody a").first().click();
  await page.getByRole("button", { name: "改为另一场景的任务…" }).first().click();
  const dialog = page.getByRole("dialog");
  assert.equal(await dialog.getByLabel("应为哪个场景").inputValue(), RIGHT);
  await checkAccessibility(page, "another class");
  await dialog.getByRole("button", { name: "创建该场景的任务" }).click();
  await page.getByText("此任务已由另一场景的任务取代。").waitFor();
  await page.getByRole("link", { name: "打开新任务" }).click();
  await page.getByRole("heading", { name: RIGHT }).waitFor();
  await page.getByText("此任务取代了另一场景的任务。").waitFor();
  const id = new URL(page.url()).pathname.split("/").at(-1);
  assert.notEqual(id, day.wrong);
  const { task } = await ask(page, "GET", `/tasks/${id}`);
  assert.deepEqual([task.state, task.replaces], ["open", day.wrong]);
}

async function fromEpisode(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.project}/episodes?scenario=other`);
  await page.getByRole("button", { name: /创建任务/ }).and(page.locator(":enabled")).waitFor();
  await page.keyboard.press("c");
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("任务的场景").fill(RIGHT);
  await checkAccessibility(page, "a task from an episode");
  await page.keyboard.press("Enter");
  await page.getByText("已创建任务。").waitFor();
  await page.getByRole("link", { name: "打开任务" }).click();
  await page.getByRole("heading", { name: RIGHT }).waitFor();
}

async function days(day) {
  const { page } = day.people.wang;
  // The project was made by an administrator whose clock is 8 h ahead of UTC.
  await page.goto(`${day.service.url}/projects/${day.project}/dashboard`);
  await page.getByRole("heading", { name: "每日产出（UTC+8 日期）" }).waitFor();
  await page.goto(`${day.service.url}/projects/${day.project}/tasks`);
  assert.match(await page.locator("tbody time").first().getAttribute("title"), /GMT\+8/);
}

export const otherClass = [
  ["an annotator says that the class is wrong", sayWrong],
  ["a lead makes the task of the class that fits", remake],
  ["an episode that no class explains becomes a task", fromEpisode],
  ["days and times are of the project's and the reader's clock", days],
];
