// Coverage: classes without a known L3 are listed, named as L2 and counted apart from the L3 scenarios.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import { setLanguage } from "../../text/text.svelte.ts";
import Coverage from "./Coverage.svelte";

const row = (leaf: string, quota: number) => ({ leaf, have: 0, quota, mined: 0, shortfall: quota });
// The taxonomy has 122 L3 (docs/reference/TAXONOMY.md); here 20 stand for them.
const leaves = Array.from({ length: 20 }, (_, n) => row(`a.b.l${n}`, 2));

test("the number of rows is that of the L3 scenarios and of the L2 beside them", async () => {
  setLanguage("zh");
  render(Coverage, { rows: [...leaves, row("proactive.turn", 0), row("proactive.lane_change", 0)], project: "p" });
  assert.ok(screen.getByText("20 个场景中 20 个有缺口，共缺 40 条。"));
  assert.ok(screen.getByText("20 个 L3 场景，另有 2 个 L2：任务的 L3 未知，或阶段一不显示其变体"));
  await fireEvent.click(screen.getByRole("button", { name: "显示全部 22 行" }));
  assert.equal(screen.getAllByText("L2", { exact: true }).length, 2);
});

test("an L2 with hidden variants counts with its target", () => {
  setLanguage("en");
  render(Coverage, { rows: [row("a.b", 5), row("a.c", 0), row("a.d.e", 2)], project: "p" });
  assert.ok(screen.getByText("2 of 2 scenarios fall short, 7 labels missing in total."));
});

test("without such tasks nothing is said about them", () => {
  setLanguage("en");
  render(Coverage, { rows: leaves, project: "p" });
  assert.ok(screen.getByRole("button", { name: "Show all 20 rows" }));
  assert.equal(screen.queryByText(/whose variant is unknown/), null);
});
