// Which digits choose a decision, and which lead to a field. Expected values by the documentation of the page.
import { fireEvent, render } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import type { Finding } from "../../api/types.ts";
import { inClass, opened } from "../../testing/opened_task.ts";
import Decisions from "./Decisions.svelte";
import { restAt, toSection } from "./focus.ts";

/** Presses a digit where the focus is; true when a group took it, so that it led to no field. */
const press = async (key: string): Promise<boolean> => !(await fireEvent.keyDown(document.activeElement ?? document.body, { key }));
const at = (): string | undefined => document.activeElement?.closest<HTMLElement>("[data-field]")?.dataset["field"];
const inGroup = (): boolean => document.activeElement?.closest("[data-choices]") !== null;

test("a digit chooses only in a group that its key led to, and once", async () => {
  const editor = opened("stage2", { driving_decision: {} });
  render(Decisions, { editor });
  // As after the safety filter: nobody has gone into a group yet.
  restAt("/driving_decision/longitudinal");
  assert.ok(!(await press("1")));
  assert.equal(editor.decision("longitudinal"), undefined);
  toSection("decisions", "[data-choices=longitudinal]");
  assert.ok(await press("1"));
  assert.equal(editor.decision("longitudinal"), "resume");
  await new Promise((done) => setTimeout(done));
  assert.equal(at(), "/driving_decision/longitudinal");
  // The key of the lateral decision, pressed now, chooses neither there nor here.
  assert.ok(!inGroup() && !(await press("2")));
  assert.deepEqual([editor.decision("longitudinal"), editor.decision("lateral")], ["resume", undefined]);
});

test("a direction that is still open follows its decision, one that the class gives does not", async () => {
  const editor = opened("stage2", { driving_decision: {} });
  render(Decisions, { editor });
  toSection("decisions", "[data-choices=lateral]");
  assert.ok(await press("1"));
  await new Promise((done) => setTimeout(done));
  assert.ok(inGroup() && (await press("3")));
  await new Promise((done) => setTimeout(done));
  assert.equal(editor.draft.at("/driving_decision/lateral_direction"), "uturn");
  assert.ok(!inGroup() && at() === "/driving_decision/lateral");
});

test("no change is chosen by somebody: drafted, it is to be accepted; undrafted, nothing is chosen", async () => {
  const none = { driving_decision: { longitudinal: null, lateral: null } };
  const chosen = (): string[] => [...document.querySelectorAll<HTMLInputElement>("input:checked")].map((one) => one.value);
  const drafted = opened("stage2", { ...none, coc_trace: "前方的轿车正在行驶，因此自车照常行驶。" });
  drafted.initial = { ...none, coc_trace: "前方的轿车正在行驶，因此自车照常行驶。" };
  const shown = render(Decisions, { editor: drafted });
  assert.deepEqual(chosen(), ["null", "null"]);
  assert.deepEqual(drafted.unaccepted.slice(0, 2), ["/driving_decision/longitudinal", "/driving_decision/lateral"]);
  drafted.accept("/driving_decision/lateral");
  assert.ok(!drafted.unaccepted.includes("/driving_decision/lateral"));
  shown.unmount();

  const editor = opened("stage2", { ...none, coc_trace: "" });
  editor.initial = { ...none, coc_trace: "" };
  render(Decisions, { editor });
  assert.deepEqual(chosen(), []);
  toSection("decisions", "[data-choices=lateral]");
  assert.ok(await press("0"));
  await new Promise((done) => setTimeout(done));
  assert.deepEqual([chosen(), editor.unaccepted], [["null"], ["/driving_decision/longitudinal"]]);
});

test("where nothing was drafted, no change is chosen by somebody even where the class does not allow it", async () => {
  const none = { driving_decision: { longitudinal: null, lateral: null }, coc_trace: "" };
  const editor = opened("stage2", none);
  editor.initial = none;
  const path = "/driving_decision/longitudinal";
  const finding = { code: "label.decision.impossible", severity: "error", pointer: path, message_zh: "不允许", message_en: "not allowed" };
  editor.draft.findings = [finding as Finding];
  const shown = render(Decisions, { editor });
  const checked = (): (string | undefined)[] => [...document.querySelectorAll<HTMLInputElement>("input:checked")].map((one) => one.value);
  assert.deepEqual([checked(), editor.unaccepted], [[], [path, "/driving_decision/lateral"]]);
  // Nobody has said what the error is about.
  assert.equal(shown.queryByText(/not allowed/i), null);
  toSection("decisions", "[data-choices=longitudinal]");
  assert.ok(await press("0"));
  await new Promise((done) => setTimeout(done));
  assert.deepEqual([checked(), editor.unaccepted], [["null"], ["/driving_decision/lateral"]]);
  assert.notEqual(shown.queryByText(/not allowed/i), null);
  // There was no draft to take back.
  editor.draft.set(path, "resume");
  await new Promise((done) => setTimeout(done));
  assert.equal(shown.queryByText("Draft"), null);
});

test("what was drafted is named as the choices name it", async () => {
  const drafted = { driving_decision: { longitudinal: null, lateral: null }, coc_trace: "前方的轿车正在行驶，因此自车照常行驶。" };
  const editor = opened("stage2", { ...drafted, driving_decision: { longitudinal: "resume", lateral: null } });
  editor.initial = drafted;
  const shown = render(Decisions, { editor });
  await new Promise((done) => setTimeout(done));
  // SPEC 2.3: no change is a judgment.
  assert.equal(shown.getByText("Draft").nextElementSibling?.textContent, "No change");
});

test("the only direction of the class needs no key", async () => {
  const editor = opened("stage2", { driving_decision: {} });
  inClass(editor, [{ id: "turn", direction: "left", usual: true }]);
  render(Decisions, { editor });
  toSection("decisions", "[data-choices=lateral]");
  assert.ok(await press("1"));
  await new Promise((done) => setTimeout(done));
  assert.equal(editor.draft.at("/driving_decision/lateral_direction"), "left");
  assert.ok(!inGroup() && at() === "/driving_decision/lateral");
});
