// One key for a choice: digits by number, letters by name.
import assert from "node:assert/strict";
import { test } from "vitest";
import { choiceKey, choiceKeys, typed } from "./choice_keys.ts";

const choices = [
  { id: "yield_to_agent", names: ["让行", "Yield to agent"] },
  { id: "follow_lead", names: ["跟车", "Follow lead"] },
  { id: "stop_for_obstacle", names: ["障碍停车", "Stop for obstacle"] },
  { id: "null", names: ["无", "No change"] },
];

test("the last choice is 0, the others count from 1", () => {
  assert.deepEqual(choices.map((_, n) => choiceKey(n, choices.length)), ["1", "2", "3", "0"]);
  assert.equal(choiceKey(9, 12), undefined);
});

test("letters find no id and no name of another language", () => {
  const zh = choices.map(({ id, names }) => ({ id, names: names.slice(0, 1) }));
  for (const letter of "ryfsno") assert.equal(typed(zh, letter), null, letter);
  assert.equal(typed(zh, "让")?.id, "yield_to_agent");
});

test("letters find a name by its beginning, then by the beginning of a word", () => {
  assert.equal(typed(choices, "f")?.id, "follow_lead");
  assert.equal(typed(choices, "ob")?.id, "stop_for_obstacle");
  assert.equal(typed(choices, "跟")?.id, "follow_lead");
  assert.equal(typed(choices, "q"), null);
});

test("a digit says all, letters narrow, keys of others stay theirs", () => {
  const chosen: [string, boolean][] = [];
  const press = choiceKeys(() => choices, (id, done) => chosen.push([id, done]));
  const key = (key: string, more: Partial<KeyboardEvent> = {}): boolean => {
    const e = new KeyboardEvent("keydown", { key, cancelable: true, ...more });
    press(e);
    return e.defaultPrevented;
  };
  assert.ok(key("2"));
  assert.ok(key("s"));
  assert.ok(key("t"));
  assert.ok(key("0"));
  assert.ok(!key("7"), "no seventh choice: the page keeps the key");
  assert.ok(!key("2", { altKey: true }));
  assert.ok(!key(" "));
  assert.deepEqual(chosen, [["follow_lead", true], ["stop_for_obstacle", false], ["stop_for_obstacle", false], ["null", true]]);
});
