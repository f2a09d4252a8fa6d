// The handlers of keys: the last one registered has a key, and a key that is held acts on a task once.
import assert from "node:assert/strict";
import { test } from "vitest";
import { handleKeys, onKeydown } from "./keys.svelte.ts";

const press = (key: string, more: KeyboardEventInit = {}): boolean => {
  const e = new KeyboardEvent("keydown", { key, cancelable: true, ...more });
  onKeydown(e);
  return e.defaultPrevented;
};

test("Ctrl+Enter that is held acts once, an arrow key steps on", () => {
  const done: string[] = [];
  const stop = handleKeys({ advance: () => done.push("advance"), forward: () => done.push("forward") });
  press("Enter", { ctrlKey: true });
  assert.ok(press("Enter", { ctrlKey: true, repeat: true }), "the browser does not get it either");
  press("ArrowRight");
  press("ArrowRight", { repeat: true });
  stop();
  press("ArrowRight");
  assert.deepEqual(done, ["advance", "forward", "forward"]);
});

test("what is typed in a focused list acts on nothing else, but saving and leaving do", () => {
  const done: string[] = [];
  const stop = handleKeys({ linkObject: () => done.push("link"), reject: () => done.push("reject"), findObject: () => done.push("find"), save: () => done.push("save") });
  const list = document.body.appendChild(document.createElement("select"));
  list.focus();
  for (const key of "road dig") assert.ok(!press(key), `the browser gets ${key}`);
  press("s", { ctrlKey: true });
  list.remove();
  assert.ok(press("o"), "without the list, the key is the page's");
  stop();
  assert.deepEqual(done, ["save", "link"]);
});
