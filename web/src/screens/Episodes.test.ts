// The list of mined episodes: times are those within the drive; a drive without a date has no time of day.
import { render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { afterEach, test, vi } from "vitest";
import type { User } from "../api/types.ts";
import { setLanguage } from "../text/text.svelte.ts";
import Episodes from "./Episodes.svelte";

vi.mock("../class_names.svelte.ts", () => ({ groupName: () => "", leafName: (id: string) => id, loadFramework: () => Promise.resolve(), tree: () => [] }));
afterEach(() => vi.unstubAllGlobals());

test("an episode is shown with its time within the drive", async () => {
  setLanguage("zh");
  const card = { scenario_id: "other", score: 0.982, calibrated: false, is_primary: true, verdict: null, drive_id: "d", keyframe: "2026-01-01T00:00:07.400Z" };
  const items = [
    { ...card, episode_id: "e1", clip_id: "d_000", keyframe_s: 7.4 },
    { ...card, episode_id: "e2", clip_id: "gone_000", drive_id: "gone" },
    { ...card, episode_id: "e3", clip_id: "fit_000", scenario_id: "a.cutin.urgent" },
    { ...card, episode_id: "e4", clip_id: "cal_000", scenario_id: "a.cutin.urgent", calibrated: true },
  ];
  const answers: [string, unknown][] = [
    ["/episodes", { items, total: 2 }],
    ["/mined", { items: [{ name: "week1", episodes: 2 }] }],
    ["", { items: [] }],
  ];
  const answer = (value: unknown): Response => new Response(JSON.stringify(value), { headers: { "content-type": "application/json" } });
  // Only the list is of interest: an episode of its own never arrives.
  const reply = (url: string): Promise<Response> => (url.includes("/episode?") ? new Promise(() => {}) : Promise.resolve(answer(answers.find(([part]) => url.includes(part))?.[1])));
  vi.stubGlobal("fetch", reply);
  const user = { id: "u", name: "lea" } as unknown as User;
  render(Episodes, { project: "p", user });
  const shown = (await screen.findByText("d_000")).parentElement?.textContent ?? "";
  assert.match(shown, /d_000 · 行程 7\.4 s/);
  const line = (clip: string): string => screen.getByText(clip).parentElement?.textContent ?? "";
  assert.match(line("fit_000"), /得分 0\.98/);
  assert.doesNotMatch(line("fit_000"), /%/, "98 % would read as 98 of 100 that are right");
  assert.match(line("cal_000"), /98%/);
  assert.doesNotMatch(document.body.textContent ?? "", /00:00:07/);
  assert.doesNotMatch(screen.getByText("gone_000").parentElement?.textContent ?? "", / s\b/);
});
