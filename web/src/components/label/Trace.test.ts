// A draft's trace is replaced part by part. Expected values by the documentation: "the reason has to be put in your own
// words", Enter moves on.
import { fireEvent, render } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import type { Finding } from "../../api/types.ts";
import { handleKeys, onKeydown } from "../../keys/keys.svelte.ts";
import { opened } from "../../testing/opened_task.ts";
import Trace from "./Trace.svelte";

const DRAFT = "路口内的轿车已停下；自车要去的方向在一侧，因此自车起步。";
const box = (slot: string): HTMLTextAreaElement => document.querySelector<HTMLTextAreaElement>(`[data-slot=${slot}]`) ?? assert.fail(slot);
const selected = (slot: string): string => box(slot).value.slice(box(slot).selectionStart, box(slot).selectionEnd);

/** Types over what is selected, as a person does. */
async function type(slot: string, text: string): Promise<void> {
  const { value, selectionStart, selectionEnd } = box(slot);
  await fireEvent.input(box(slot), { target: { value: value.slice(0, selectionStart) + text + value.slice(selectionEnd) } });
}

test("every part that is still the draft's is selected when Enter leads to it", async () => {
  const editor = opened("stage2", { coc_trace: DRAFT, driving_decision: { longitudinal: "resume", lateral: null } });
  editor.initial = { coc_trace: DRAFT };
  editor.draft.findings = [{ code: "label.trace.draft", severity: "error", pointer: "/coc_trace", message_zh: "草稿", message_en: "draft" } as Finding];
  render(Trace, { editor });
  box("state").focus();
  assert.equal(selected("state"), "路口内的轿车已停下");
  await type("state", "轿车停在路口内");
  await fireEvent.keyDown(box("state"), { key: "Enter" });
  assert.equal(selected("reason"), "自车要去的方向在一侧");
  await type("reason", "该车已让出左转的路径");
  // The reason is a person's now, and the service finds nothing more.
  editor.draft.findings = [];
  await fireEvent.keyDown(box("reason"), { key: "Enter" });
  assert.equal(selected("decision"), "自车起步");
  await type("decision", "自车平稳起步");
  assert.equal(editor.draft.at("/coc_trace"), "轿车停在路口内；该车已让出左转的路径，因此自车平稳起步。");
  // What a person wrote is never selected.
  box("state").focus();
  await fireEvent.keyDown(box("state"), { key: "Enter" });
  assert.equal(selected("reason"), "");
});

test("a key that leads to a part of the form does not replace the draft that the focus came to by itself", async () => {
  const editor = opened("stage2", { coc_trace: DRAFT, driving_decision: { longitudinal: "resume", lateral: null } });
  editor.initial = { coc_trace: DRAFT };
  editor.draft.findings = [{ code: "label.trace.draft", severity: "error", pointer: "/coc_trace", message_zh: "草稿", message_en: "draft" } as Finding];
  render(Trace, { editor });
  const pressed: string[] = [];
  const stop = handleKeys({ toTrace: () => pressed.push("trace"), toLateral: () => pressed.push("lateral") });
  const press = (key: string, more: KeyboardEventInit = {}): boolean => {
    const e = new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more });
    document.activeElement?.dispatchEvent(e);
    onKeydown(e);
    return e.defaultPrevented;
  };
  box("state").focus();
  assert.equal(selected("state"), "路口内的轿车已停下");
  // Pressed once too often.
  press("a", { altKey: true });
  assert.ok(press("5") && document.activeElement === document.body);
  // Once something was typed, or after another key, digits are text.
  box("state").focus();
  await type("state", "轿");
  assert.ok(!press("3"));
  box("reason").focus();
  assert.ok(!press("轿") && !press("3"));
  assert.deepEqual(pressed, ["trace"]);
  stop();
});
