// After tasks were made: how many episodes were not used, by reason.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { afterEach, test, vi } from "vitest";
import { setLanguage } from "../text/text.svelte.ts";
import CreateTasks from "./CreateTasks.svelte";

afterEach(() => vi.unstubAllGlobals());

test("each reason has its own number, and one without episodes is not mentioned", async () => {
  setLanguage("zh");
  const made = { tasks: ["t1", "t2"], known: 0, left_out: 29, over_limit: 0, secondary: 3, no_class: 25, no_history: 1, short_window: 2, lost: [], more: 0 };
  const answer = (value: unknown): Response => new Response(JSON.stringify(value), { headers: { "content-type": "application/json" } });
  vi.stubGlobal("fetch", (url: string) => Promise.resolve(answer(url.includes("/mined") ? { items: [{ name: "week1", episodes: 30 }] } : made)));
  render(CreateTasks, { project: "p", close: () => {}, made: () => {} });
  await screen.findByText(/week1/);
  await fireEvent.click(screen.getByRole("button", { name: "创建任务" }));
  await screen.findByText("已创建 2 个任务。");
  assert.ok(screen.getByText("3 个次场景的事件未采用（未勾选）。"));
  assert.ok(screen.getByText("25 个事件无场景可解释，或其场景不在本服务的分类中，不能标注。"));
  assert.ok(screen.getByText("1 个事件的关键帧是行程首帧，没有历史可看，未采用（未勾选）。"));
  assert.ok(screen.getByText(/其中 2 个事件的样本窗口/));
  assert.equal(screen.queryByText(/超出上限/), null);
});
