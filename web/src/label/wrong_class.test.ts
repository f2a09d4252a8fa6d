import assert from "node:assert/strict";
import { test } from "vitest";
import { wrongClassText } from "./wrong_class.ts";

test("the lead reads which class fits, and why", () => {
  assert.equal(wrongClassText(["路口", "右转"], "  ", "zh"), "场景不对，应为“路口 › 右转”。");
  assert.equal(wrongClassText(["Junctions", "Right turn"], "turns by 44°", "en"), 'The class is wrong, it should be "Junctions › Right turn": turns by 44°');
  assert.equal(wrongClassText(null, "自车没有动", "zh"), "场景不对：自车没有动");
});
