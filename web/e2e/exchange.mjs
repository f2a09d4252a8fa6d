// Files in and out in the page, and webhooks: a receiver of ours refuses the first delivery, is tried again, and checks
// the signature as docs/how-to/run-the-service.md describes it.
import assert from "node:assert/strict";
import { createHmac } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { ask, checkAccessibility } from "./people.mjs";
import { shot } from "./shots.mjs";

const NAME = "导入的任务";

/** Says 503 to what comes first, then takes everything. */
async function receiver() {
  const got = [];
  const server = createServer((request, reply) => {
    const parts = [];
    request.on("data", (part) => parts.push(part));
    request.on("end", () => {
      const status = got.length === 0 ? 503 : 204;
      got.push({ status, headers: request.headers, body: Buffer.concat(parts).toString("utf8") });
      reply.writeHead(status).end();
    });
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { got, url: `http://127.0.0.1:${server.address().port}/hook`, close: () => server.close() };
}

async function hook(day) {
  const { page } = day.people.wang;
  day.receiver = await receiver();
  await page.goto(`${day.service.url}/projects/${day.project}/exchange`);
  await page.getByLabel("地址").fill("ftp://example.com/");
  await page.getByRole("button", { name: "添加 Webhook" }).click();
  await page.getByText(/网址无效/).waitFor();
  await page.getByLabel("地址").fill(day.receiver.url);
  await page.getByLabel("跳过").check();
  await page.getByLabel("重新打开").check();
  await page.getByRole("button", { name: "添加 Webhook" }).click();
  day.secret = await page.getByLabel("签名密钥").inputValue();
  await page.getByRole("cell", { name: day.receiver.url, exact: true }).waitFor();
  await page.getByText("尚未发送", { exact: true }).waitFor();
  await checkAccessibility(page, "webhooks");
}

async function deliveries(day) {
  const { page } = day.people.wang;
  const { items } = await ask(page, "GET", `/projects/${day.project}/tasks?state=open&limit=1`);
  const act = (action) => ask(page, "POST", `/tasks/${items[0].id}/actions`, { action, reason: "试一下 Webhook" });
  await act("skip");
  // A task that was skipped is in neither stage.
  const other = await page.context().newPage();
  await other.goto(`${day.service.url}/tasks/${items[0].id}`);
  await other.getByText("只读：此任务已跳过。").waitFor();
  assert.equal(await other.getByText("阶段一：只看历史，列出关键要素").count(), 0);
  await other.close();
  // The page says so by itself: what went wrong, how often, and when it is tried again.
  const row = page.locator("tr", { hasText: day.receiver.url });
  await row.getByText(/503/).waitFor();
  await row.getByText(/已失败 1 次，\d+:\d+:\d+ 再试/).waitFor();
  await shot(day, page, "webhook-failed");
  await act("reopen");
  await row.getByText(/正常/).waitFor({ timeout: 40_000 });
  const [refused, ...taken] = day.receiver.got;
  assert.equal(refused.status, 503);
  assert.deepEqual(taken.map((d) => JSON.parse(d.body).event).sort(), ["reopen", "skip"]);
  const again = taken.find((d) => JSON.parse(d.body).event === "skip");
  assert.equal(again.body, refused.body, "the same message is sent again");
  assert.equal(again.headers["x-whyroad-delivery"], refused.headers["x-whyroad-delivery"]);
  for (const { headers, body } of day.receiver.got) {
    const [, at, hex] = /^t=(\d+),v1=([0-9a-f]{64})$/.exec(headers["x-whyroad-signature"]);
    assert.equal(hex, createHmac("sha256", day.secret).update(`${at}.${body}`).digest("hex"));
    assert.notEqual(hex, createHmac("sha256", `${day.secret}x`).update(`${at}.${body}`).digest("hex"));
    assert.equal(JSON.parse(body).task, items[0].id);
    assert.ok(!body.includes("coc_trace"), "no label leaves with it");
  }
  await row.getByRole("button", { name: "删除" }).click();
  await row.waitFor({ state: "detached" });
  day.receiver.close();
}

async function download(day, name, file) {
  const { page } = day.people.wang;
  const coming = page.waitForEvent("download");
  await page.getByRole("link", { name, exact: true }).click();
  const path = join(day.scratch, file);
  await (await coming).saveAs(path);
  return readFileSync(path, "utf8").trim().split("\n");
}

async function upload(day, file, lines) {
  const { page } = day.people.wang;
  const path = join(day.scratch, file);
  writeFileSync(path, `${lines.join("\n")}\n`);
  await page.getByLabel("JSONL 文件").setInputFiles(path);
  await page.getByRole("button", { name: "导入", exact: true }).click();
}

/** Labels come in as drafts; a broken line is named with its place and does not stop the rest. */
async function labelsIn(day) {
  const { page } = day.people.wang;
  await page.goto(`${day.service.url}/projects/${day.project}/exchange`);
  const labels = await download(day, "导出标注 (JSONL)", "out-labels.jsonl");
  const tasks = await download(day, "导出任务 (JSONL)", "out-tasks.jsonl");
  assert.equal(tasks.length, day.made);
  const project = await ask(day.people.admin.page, "POST", "/projects", { name: NAME });
  await ask(day.people.admin.page, "POST", `/projects/${project.id}/members`, { user: "wang", roles: ["lead"] });
  day.imported = { project: project.id, tasks };
  await page.goto(`${day.service.url}/projects/${project.id}/exchange`);
  const elsewhere = JSON.stringify({ ...JSON.parse(labels[0]), clip_id: "no_such_drive_000" });
  await upload(day, "in-labels.jsonl", ['{"clip_id": "半行', labels[0], elsewhere, '{"anything": 1}']);
  await page.getByText("已导入 1 个任务，0 个原已存在。").waitFor();
  await page.getByText("3 行无法读取").waitFor();
  const lost = await page.locator(".lost li").allInnerTexts();
  assert.equal(lost.length, 3);
  assert.match(lost[0], /^第 1 行 不是 JSON/);
  assert.match(lost[1], /^第 3 行/);
  assert.match(lost[2], /^第 4 行 既不是任务/);
  await checkAccessibility(page, "import");
  await shot(day, page, "import");
  await page.getByRole("button", { name: "English" }).click();
  assert.match(await page.locator(".lost li").first().innerText(), /^Line 1 not JSON/);
  await page.getByRole("button", { name: "中文" }).click();
  const { items } = await ask(page, "GET", `/projects/${project.id}/tasks`);
  assert.deepEqual(items.map((t) => [t.state, t.scenario_id]), [["open", "reactive_agent.cutin.urgent"]]);
  const task = await ask(page, "GET", `/tasks/${items[0].id}`);
  assert.deepEqual(task.draft.critical_components ?? [], [], "what others said of the components is hidden in Stage I");
}

/**
 * Tasks of another service: all but the broken line, once. The label that came in before is about the episode of one of
 * them: there is no second task for it.
 */
async function tasksIn(day) {
  const { page } = day.people.wang;
  const { project, tasks } = day.imported;
  await page.goto(`${day.service.url}/projects/${project}/exchange`);
  const lines = [tasks[0], `${tasks[1].slice(0, 40)}`, ...tasks.slice(1)];
  await upload(day, "in-tasks.jsonl", lines);
  await page.getByText(`已导入 ${tasks.length - 1} 个任务，1 个原已存在。`).waitFor({ timeout: 120_000 });
  assert.match(await page.locator(".lost li").innerText(), /^第 2 行/);
  // Changed on disk after it was chosen: the page reports it, and it is chosen again.
  writeFileSync(join(day.scratch, "in-tasks.jsonl"), "{}");
  await page.getByRole("button", { name: "导入", exact: true }).click();
  await page.getByText("文件在选择之后有改动").waitFor();
  await upload(day, "again.jsonl", tasks);
  await page.getByText(`已导入 0 个任务，${tasks.length} 个原已存在。`).waitFor({ timeout: 120_000 });
  assert.equal(await page.locator(".lost li").count(), 0);
}

export const exchange = [
  ["a lead registers a webhook", hook],
  ["a delivery that fails is shown, tried again, and signed", deliveries],
  ["labels come in from a file; broken lines are named, the rest is taken", labelsIn],
  ["tasks come in from a file, each once", tasksIn],
];
