// A key typed before the answer comes reaches what has the focus after it, and is not lost.
import assert from "node:assert/strict";
import { afterEach, test } from "vitest";
import { HeldKeys } from "./held_keys.ts";

afterEach(() => document.body.replaceChildren());

const press = (key: string, more: KeyboardEventInit = {}): boolean =>
  (document.activeElement ?? document.body).dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));

/** Two boxes that note their keys; a key in the first moves the focus to the second. */
function boxes(): { first: HTMLElement; heard: string[] } {
  const heard: string[] = [];
  const [first, second] = ["first", "second"].map((name) => {
    const box = document.createElement("button");
    box.addEventListener("keydown", (e) => {
      heard.push(`${name} ${e.key}`);
      e.preventDefault();
      second?.focus();
    });
    document.body.append(box);
    return box;
  });
  return { first: first as HTMLElement, heard };
}

test("keys wait for the focus, in their order", async () => {
  const { first, heard } = boxes();
  const keys = new HeldKeys();
  keys.hold();
  press("1");
  press("4");
  press("Enter");
  press("s", { ctrlKey: true });
  assert.deepEqual(heard, []);
  first.focus();
  await keys.release();
  assert.deepEqual(heard, ["first 1", "second 4"]);
  press("2");
  assert.deepEqual(heard.at(-1), "second 2", "nothing is held afterwards");
});

test("what was typed is forgotten when the answer is a refusal, and a text field or a list keeps its keys", async () => {
  const keys = new HeldKeys();
  keys.hold();
  press("1");
  assert.deepEqual(keys.drop(), ["1"]);
  await keys.release();
  for (const kind of ["textarea", "select"]) {
    const field = document.body.appendChild(document.createElement(kind));
    field.focus();
    keys.hold();
    assert.ok(press("a"), `the ${kind} gets it`);
    assert.deepEqual(keys.drop(), []);
  }
});
