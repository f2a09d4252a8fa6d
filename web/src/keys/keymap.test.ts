// Shortcuts: no two actions share a key, and keys that type stay with text fields.
import assert from "node:assert/strict";
import { test } from "vitest";
import { actionIds, actionOf, actions, fieldKeeps, keyOf, bindingProblem, repeats, strokeName } from "./keymap.ts";

const stroke = (key: string, mods: Partial<Record<"ctrlKey" | "altKey" | "shiftKey" | "metaKey", boolean>> = {}) =>
  strokeName({ key, ctrlKey: false, altKey: false, shiftKey: false, metaKey: false, ...mods });

test("default keys are all different, and each is a name that a stroke can have", () => {
  const names = actionIds.map((a) => actions[a].key);
  assert.equal(new Set(names).size, names.length);
  assert.equal(stroke(" "), "Space");
  assert.equal(stroke("z", { ctrlKey: true }), "Ctrl+Z");
  assert.equal(stroke("Z", { metaKey: true, shiftKey: true }), "Ctrl+Shift+Z");
  assert.equal(stroke("?", { shiftKey: true }), "?");
  assert.equal(stroke("Shift", { shiftKey: true }), null);
});

test("whatever types a character into a field stays with the field", () => {
  for (const action of actionIds) {
    const key = actions[action].key;
    const types = key.length === 1 || key === "Space" || key.startsWith("Shift+") || key.startsWith("Arrow");
    if (types) assert.ok(fieldKeeps("text", key, action), `${action} takes ${key} from a text field`);
  }
  assert.ok(!fieldKeeps("text", "Ctrl+Enter", "advance"));
  assert.ok(fieldKeeps("text", "Ctrl+Z", "undo"), "a field of another form has its own undo");
});

test("text of the label is undone by the page, and keeps every other stroke", () => {
  assert.ok(!fieldKeeps("undone", "Ctrl+Z", "undo") && !fieldKeeps("undone", "Ctrl+Shift+Z", "redo"));
  assert.ok(fieldKeeps("undone", "J", "undo"), "a key of one's own that types");
  for (const action of actionIds) {
    if (action === "undo" || action === "redo") continue;
    assert.equal(fieldKeeps("undone", actions[action].key, action), fieldKeeps("text", actions[action].key, action), action);
  }
});

test("a list takes the letters and digits that name an entry, as every list of a browser does", () => {
  for (const action of actionIds) {
    const key = actions[action].key;
    const keeps = !key.startsWith("Ctrl+") && !key.startsWith("Alt+") && key !== "Escape";
    assert.equal(fieldKeeps("list", key, action), keeps, `${action} with ${key}`);
  }
});

test("choices keep their arrows, buttons their space, the page gives both to the player", () => {
  assert.ok(fieldKeeps("choice", "ArrowLeft", "back"));
  for (const [key, action] of [["ArrowLeft", "back"], ["ArrowRight", "forward"], ["Home", "first"], ["Space", "play"]] as const) {
    assert.ok(!fieldKeeps("radio", key, action), `${key} changes a decision while frames are looked at`);
  }
  assert.ok(fieldKeeps("radio", "ArrowDown", "forward"));
  assert.ok(fieldKeeps("button", "Space", "play"));
  assert.ok(!fieldKeeps("page", "Space", "play"));
  assert.ok(!fieldKeeps("choice", "C", "addComponent"));
});

test("a key that is held steps through frames, but does nothing to a task again", () => {
  for (const action of ["forward", "back", "zoomIn"] as const) assert.ok(repeats(action), action);
  for (const action of ["advance", "accept", "acceptField", "safe", "sendBack", "removeComponent"] as const) assert.ok(!repeats(action), action);
});

test("a key can be moved, but not onto another action's, and a key for everywhere must not type", () => {
  assert.deepEqual(bindingProblem("play", "N", {}), { clash: "nextObject" });
  assert.deepEqual(bindingProblem("advance", "J", {}), { types: true });
  assert.equal(bindingProblem("play", "J", {}), null);
  assert.equal(keyOf("play", { play: "G" }), "G");
  assert.equal(actionOf("G", { play: "G" }), "play");
  assert.equal(actionOf("Space", { play: "G" }), null);
  assert.equal(bindingProblem("loop", "Space", { play: "G" }), null, "a key that was given up is free");
});
