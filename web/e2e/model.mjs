// Drafts and judgments by a language model, end to end: a lead has tasks drafted, an annotator sees the model's
// components in Stage I and its decision and trace only in Stage II, a lead has the label judged, a checker answers the
// same questions and then sees the model's. The model is a script that is also busy, broken and unwilling.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { endpoint } from "./endpoint.mjs";
import { ask, checkAccessibility, makeFirstAccount, person, readStageOne, settled, signIn, tabTo } from "./people.mjs";
import { serve } from "./service.mjs";
import { shot } from "./shots.mjs";

const PASSWORD = "会当凌绝顶-一览众山小";
const KEY = "sk-e2e-never-shown-4711";
const MODEL = "vlm-e2e";
const SEEN = "左前方的车正在切入本车道";
const REASON = "切入后的车距对当前车速而言过小，继续保持原速很快就会追近";
const TRACE = `左前方的车正在切入本车道，${REASON}，因此自车减速让行，与前车拉开安全距离。`;
const DOUBT = "右侧车道的车更近";
const WANTED = ["reactive_agent.cutin.urgent", "reactive_agent.cutin.large_vehicle", "reactive_agent.vru_crossing.crosswalk"];

function answer(form, text) {
  if (form === "draft_history") {
    return { components: [{ description: SEEN, category: "critical_objects", uncertainty: "low", objects: [] }] };
  }
  if (form === "draft_future") {
    // It declines where the class is about people on foot.
    if (text.includes("类别：VRU")) return { refusal: "not about pedestrians" };
    const none = { components: [], unobserved: "" };
    return {
      longitudinal: "yield_to_agent", lateral: null, lateral_direction: null,
      causes: { longitudinal: { components: ["c1"], unobserved: "" }, lateral: none },
      trace: TRACE, safe: true, safety_reason: "",
    };
  }
  const statements = JSON.parse(text.slice(text.lastIndexOf("\n[")).trim());
  const doubts = (s) => s.statement.includes("最近的原因");
  const omitted = (s) => s.statement.includes("没有提到的目标");
  return { answers: statements.map((s) => ({ id: s.id, answer: !doubts(s) && !omitted(s), reason: doubts(s) ? DOUBT : "与记录一致" })) };
}

async function prepare(day) {
  day.model = await endpoint(answer, [
    { status: 429, headers: { "retry-after": "1" }, body: '{"error":{"message":"busy"}}' },
    { status: 200, body: '{"choices": [{"mess' },
  ]);
  day.modelData = join(day.scratch, "model-data");
  day.modelArguments = ["--model", day.model.url, "--model-name", MODEL, "--key-env", "VLM_KEY", "--people-share", "1", "--model-jobs", "2", "--price-input", "2", "--price-output", "8"];
  day.own?.stop("SIGKILL");
  day.own = await serve({ data: day.modelData, demo: day.demo, more: day.modelArguments, environment: { VLM_KEY: KEY } });
  const enter = async (name) => {
    const one = await person(day.browser, day.own.url, { faults: day.faults });
    await signIn(one.page, name, PASSWORD);
    return (day.people[`m-${name}`] = one).page;
  };
  const first = await person(day.browser, day.own.url, { faults: day.faults });
  day.people["m-lead"] = first;
  const { page } = first;
  await makeFirstAccount(page, "lead", "周负责", PASSWORD);
  const project = (await ask(page, "POST", "/projects", { name: "模型起草" })).id;
  for (const [name, display, role] of [["ann", "李标注", "annotator"], ["check", "陈质检", "checker"]]) {
    await ask(page, "POST", "/users", { name, display, password: PASSWORD });
    await ask(page, "POST", `/projects/${project}/members`, { user: name, roles: [role] });
    await enter(name);
  }
  // Who labels is not told why a draft failed: it may be the future.
  await ask(page, "POST", `/projects/${project}/members`, { user: "lead", roles: ["lead"] });
  const mined = `${day.demo ?? join(day.modelData, "demo")}/mined/episodes.jsonl`;
  const all = readFileSync(mined, "utf8").trim().split("\n").map((line) => JSON.parse(line));
  const episodes = WANTED.map((leaf) => all.find((e) => e.scenario_id === leaf && e.is_primary));
  const made = await ask(page, "POST", `/projects/${project}/tasks:create`, { episodes });
  assert.equal(made.tasks.length, WANTED.length);
  day.modelProject = project;
}

const dashboard = (day) => `${day.own.url}/projects/${day.modelProject}/dashboard`;
const run = (page, state) => page.locator(`#model ~ * [data-run-state="${state}"], [aria-labelledby="model"] [data-run-state="${state}"]`).first();

async function drafts(day) {
  const { page } = day.people["m-lead"];
  await page.goto(dashboard(day));
  await page.getByText(`模型：${MODEL}`).waitFor();
  const release = day.model.hold();
  await page.locator('[data-run="draft"]').click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("可能产生费用").waitFor();
  await checkAccessibility(page, "starting a run");
  await shot(day, page, "model-start");
  await dialog.getByRole("button", { name: "开始" }).click();
  await run(page, "running").waitFor();
  await page.getByText("完成 0 / 3").waitFor();
  // One run of a kind at a time.
  assert.ok(await page.locator('[data-run="draft"]').isDisabled());
  await shot(day, page, "model-running");
  // The service is killed while the model is asked: the run goes on.
  await day.own.stop("SIGKILL");
  release();
  day.own = await serve({ data: day.modelData, demo: day.demo, port: day.own.port, more: day.modelArguments, environment: { VLM_KEY: KEY } });
  await page.goto(dashboard(day));
  await run(page, "done").waitFor({ timeout: 120_000 });
  await page.getByText("完成 2 / 3，失败 1").waitFor();
  await page.getByText(/失败的 1 个/).click();
  await page.getByText(/模型拒绝回答/).waitFor();
  const row = page.getByRole("row").filter({ hasText: MODEL });
  assert.match(await row.innerText(), /0\.0\d+/, "the cost is shown");
  await checkAccessibility(page, "runs of the model");
  await shot(day, page, "model-runs");
  const work = await ask(page, "GET", `/projects/${day.modelProject}/model-runs`);
  assert.equal(work.to_draft, 1, "what failed can be asked for again");
  assert.ok(day.model.seen.every((s) => s.authorization === `Bearer ${KEY}`));
  const tasks = (await ask(page, "GET", `/projects/${day.modelProject}/tasks`)).items;
  day.modelTask = tasks.find((t) => t.scenario_id === WANTED[0]).id;
  await ask(page, "POST", `/tasks/${day.modelTask}/assign`, { user: "ann" });
}

async function stageOne(day) {
  const { page } = day.people["m-ann"];
  await page.goto(`${day.own.url}/tasks/${day.modelTask}`);
  await page.locator('[data-action="take"], [data-action="lock"]').first().waitFor();
  if (await page.locator('[data-action="take"]').count()) await page.locator('[data-action="take"]').click();
  await page.locator('[data-action="lock"]').waitFor();
  await page.locator(`[data-drafted-by="${MODEL}"]`).waitFor();
  assert.equal(await page.locator('[data-component="0"] textarea').inputValue(), SEEN);
  assert.equal(await page.locator('[data-section="decisions"]').count(), 0);
  // Neither on the page nor in anything that the service sends.
  for (const path of ["", "/history", "/scene"]) {
    const sent = JSON.stringify(await ask(page, "GET", `/tasks/${day.modelTask}${path}`));
    assert.ok(!sent.includes(REASON) && !sent.includes("yield_to_agent"), `${path} holds the future`);
  }
  await checkAccessibility(page, "a model's draft, Stage I");
  await shot(day, page, "model-stage1");
  await page.keyboard.press("Escape");
  await readStageOne(page);
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-section="decisions"]').waitFor();
}

async function stageTwo(day) {
  const { page } = day.people["m-ann"];
  await page.waitForFunction(() => document.activeElement?.closest("[data-section=safety]"));
  await page.keyboard.press("y");
  await page.waitForFunction(() => document.activeElement?.closest("[data-section=decisions]"));
  assert.ok(await page.locator('[data-choices=longitudinal] input[value="yield_to_agent"]').isChecked(), "the model's decision");
  const trace = await page.locator('[data-section="trace"]').evaluate((s) => [...s.querySelectorAll("textarea, input")].map((e) => e.value).join(" ") + s.innerText);
  assert.ok(trace.includes(REASON), trace);
  await shot(day, page, "model-stage2");
  // What a model wrote is accepted by who has read it, or changed; what the log did not measure is filled in.
  const task = await ask(page, "GET", `/tasks/${day.modelTask}`);
  for (const record of task.spec?.records ?? []) {
    const field = page.locator(`[data-field="/records/${record.id}"]`);
    const input = field.locator("input").first();
    if ((await field.locator("input:checked").count()) > 0 || (!record.choices && (await input.inputValue()) !== "")) continue;
    await tabTo(page, input);
    await page.keyboard.press("1");
  }
  await page.keyboard.press("Escape");
  for (let n = 0; n < 8 && (await page.locator(".field-of button", { hasText: "采纳草稿" }).count()) > 0; n++) await page.keyboard.press("Alt+a");
  await page.locator('[data-saving="saved"]').waitFor();
  await page.keyboard.press("Control+Enter");
  await page.locator('[data-action="next"]').waitFor();
  const draft = (await ask(page, "GET", `/tasks/${day.modelTask}`)).draft;
  assert.equal(draft.provenance.source, "person");
}

async function judges(day) {
  const { page } = day.people["m-lead"];
  await page.goto(dashboard(day));
  await page.getByText("还没有判定。").waitFor();
  await page.getByRole("button", { name: "判定 1 条已提交的标注" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "开始" }).click();
  const row = page.getByRole("row").filter({ hasText: "判定" }).filter({ hasText: MODEL });
  await row.locator('[data-run-state="done"]').waitFor({ timeout: 60_000 });
  await row.getByText("完成 1 / 1").waitFor();
  // What it judged is there without a reload.
  await page.getByText("已判定 1 条标注").waitFor();
}

async function checks(day) {
  const { page } = day.people["m-check"];
  await page.goto(`${day.own.url}/projects/${day.modelProject}/tasks`);
  await page.getByRole("button", { name: "领取下一个质检任务" }).click();
  await page.waitForURL(`**/tasks/${day.modelTask}`);
  const card = page.locator('[data-section="judge"]');
  await card.getByText("请独立回答下列问题").waitFor();
  assert.ok(!(await card.innerText()).includes(DOUBT), "the model's answers come after the checker's own");
  await checkAccessibility(page, "questions to a checker");
  await shot(day, page, "judge-questions");
  // What was not named is shown in the scene by its name.
  await card.getByRole("button", { name: "cutter" }).first().click();
  for (const question of await card.locator("fieldset").all()) {
    const omission = (await question.locator("legend").innerText()).includes("没有提到");
    await question.getByLabel(omission ? "不对" : "对", { exact: true }).check();
  }
  await card.locator('[data-judge="answer"]').click();
  await card.getByText(DOUBT).waitFor();
  await card.getByText("1 处异议").waitFor();
  await card.getByText("您：对").first().waitFor();
  await card.locator("summary").click();
  await checkAccessibility(page, "a model's answers");
  await shot(day, page, "judge-answers");
  await page.getByRole("button", { name: /^English$/ }).click();
  await card.getByText("1 fault").waitFor();
  await shot(day, page, "judge-answers-en");
  await page.getByRole("button", { name: /^中文$/ }).click();
  // An opinion blocks nothing.
  await page.locator('[data-action="accept"]').click();
  await page.locator('[data-action="next"]').waitFor();
}

async function agreement(day) {
  const { page } = day.people["m-lead"];
  await page.goto(dashboard(day));
  await page.getByText("已判定 1 条标注，0 条无异议；1 条抽给人工，其中 1 条已回答。").waitFor();
  const table = page.getByRole("region", { name: "按问题类别的一致性" });
  assert.match(await table.getByRole("row").filter({ hasText: "近因" }).innerText(), /0%/);
  await settled(page);
  await checkAccessibility(page, "dashboard with a model");
  await page.locator("#judged").evaluate((e) => e.scrollIntoView({ block: "center" }));
  await shot(day, page, "model-dashboard");
  await page.getByRole("button", { name: /^English$/ }).click();
  await page.getByText("1 label judged, 0 without a fault; 1 drawn for people, who have answered 1.").waitFor();
  await page.locator("#judged").evaluate((e) => e.scrollIntoView({ block: "center" }));
  await shot(day, page, "model-dashboard-en");
  await page.getByRole("button", { name: /^中文$/ }).click();
  // The key is in no file of the service's.
  for (const file of readdirSync(day.modelData, { recursive: true, withFileTypes: true }).filter((f) => f.isFile())) {
    assert.ok(!readFileSync(join(file.parentPath ?? file.path, file.name)).includes(KEY), file.name);
  }
  assert.equal(await day.own.stop(), "0");
  day.own = null;
  await day.model.close();
}

export const model = [
  ["a service with a language model starts", prepare],
  ["a lead has tasks drafted; the run survives a killed service", drafts],
  ["Stage I has the model's components and nothing of the future", stageOne],
  ["Stage II has its decision and trace; the label is submitted", stageTwo],
  ["a lead has the label judged", judges],
  ["a checker answers the questions, then sees the model's answers", checks],
  ["the dashboard compares the judge with people", agreement],
];
