// Undo and redo on the screen, from the keyboard. Expected values by the documentation of the page.
import { render } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import { handleKeys, onKeydown } from "../../keys/keys.svelte.ts";
import { opened } from "../../testing/opened_task.ts";
import Components from "./Components.svelte";
import { handlers } from "./key_handlers.ts";
import { endOfChange, undoInstead } from "./undo_actions.ts";

const turn = (): Promise<void> => new Promise((done) => setTimeout(done));
const of = (id: string, description: string): { id: string; description: string; uncertainty: string } => ({ id, description, uncertainty: "low" });

async function press(key: string, more: KeyboardEventInit = {}): Promise<boolean> {
  const e = new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more });
  onKeydown(e);
  await turn();
  return e.defaultPrevented;
}

function shown(): { texts: () => string[]; editor: ReturnType<typeof opened>; stop: () => void } {
  Element.prototype.scrollIntoView = () => {};
  Element.prototype.animate = () => ({}) as Animation;
  const editor = opened("stage1", { critical_components: [of("c1", "路口没有车"), of("c2", "前方的轿车较慢"), of("c3", "右侧有行人")] });
  render(Components, { editor });
  const none = (): void => {};
  const stop = handleKeys(handlers(editor, { advance: none, reject: none, answerSafe: none, sendBack: none, accept: none, skip: none, wrongClass: none }));
  return { texts: () => editor.components.map((c) => String(c["description"])), editor, stop };
}

test("a component that was removed comes back, and nothing else changes", async () => {
  const { texts, editor, stop } = shown();
  editor.draft.set("/critical_components/0/description", "路口内没有冲突车辆");
  editor.currentComponent = 2;
  await press("Delete");
  assert.deepEqual(texts(), ["路口内没有冲突车辆", "前方的轿车较慢"]);
  // Keys of the page that follow write into no text.
  assert.ok(!(document.activeElement instanceof HTMLTextAreaElement));
  assert.ok(await press("z", { ctrlKey: true }));
  assert.deepEqual(texts(), ["路口内没有冲突车辆", "前方的轿车较慢", "右侧有行人"]);
  assert.equal(editor.announcement, "Undone: Critical components c3");
  assert.equal(editor.currentComponent, 2);
  stop();
});

test("in a text of the label undo is the page's: it takes back the last change, wherever that was", async () => {
  const { texts, editor, stop } = shown();
  editor.draft.set("/critical_components/2/description", "右侧有两个行人");
  document.querySelector<HTMLTextAreaElement>('[data-component="1"] textarea')?.focus();
  assert.ok(await press("z", { ctrlKey: true }), "the browser does not get it");
  assert.deepEqual(texts()[2], "右侧有行人");
  assert.ok(await press("Z", { ctrlKey: true, shiftKey: true }));
  assert.deepEqual(texts()[2], "右侧有两个行人");
  // From the menu of the browser.
  const box = document.activeElement as HTMLTextAreaElement;
  const menu = new InputEvent("beforeinput", { inputType: "historyUndo", bubbles: true, cancelable: true });
  box.addEventListener("beforeinput", (e) => undoInstead(editor, e as InputEvent), { once: true });
  box.dispatchEvent(menu);
  await turn();
  assert.ok(menu.defaultPrevented);
  assert.deepEqual(texts()[2], "右侧有行人");
  stop();
});

test("the cursor is where the text changed", async () => {
  const { editor, stop } = shown();
  const box = document.querySelector<HTMLTextAreaElement>('[data-component="1"] textarea');
  assert.ok(box);
  editor.draft.set("/critical_components/1/description", "前方很近的轿车较慢");
  await turn();
  box.focus();
  await press("z", { ctrlKey: true });
  assert.deepEqual([box.value, box.selectionStart], ["前方的轿车较慢", 2]);
  assert.equal(endOfChange("abc", "abXc"), 3);
  assert.equal(endOfChange("", "abc"), 3);
  assert.equal(endOfChange("abc", "abc"), 0);
  stop();
});
