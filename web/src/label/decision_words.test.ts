// A chosen decision is written as a sentence, in both languages, and every decision of the framework has words.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { test } from "vitest";
import { decisionSentence } from "./decision_words.ts";

const of = (id: string): { id: string; name: string } => ({ id, name: `name of ${id}` });

test("a decision is a sentence, not a list of names", () => {
  assert.equal(decisionSentence(of("set_speed_tracking"), of("turn"), "right", "zh"), "自车保持目标车速，并向右转弯");
  assert.equal(decisionSentence(of("yield_to_agent"), of("turn"), "left", "en"), "the ego yields and turns left");
  assert.equal(decisionSentence(null, of("turn"), "uturn", "zh"), "自车掉头");
  assert.equal(decisionSentence(null, of("lane_change"), "", "zh"), "自车换道");
  assert.equal(decisionSentence(null, of("in_lane_nudge"), "left", "en"), "the ego nudges to the left within its lane");
  assert.equal(decisionSentence(of("resume"), null, "", "en"), "the ego moves off");
  assert.equal(decisionSentence(null, null, "", "zh"), "");
});

test("every decision has words", () => {
  const text = readFileSync(resolve(import.meta.dirname, "../../../schema/driving_decisions.yaml"), "utf8");
  const [along = "", across = ""] = (text.split("\nlongitudinal:")[1] ?? "").split("\nlateral:");
  const ids = (part: string): string[] => [...part.matchAll(/^ {2}- id: "(\w+)"/gm)].map((m) => m[1] ?? "");
  assert.equal(ids(along).length, 9);
  assert.equal(ids(across).length, 9);
  for (const id of ids(along)) assert.doesNotMatch(decisionSentence(of(id), null, "", "zh"), /name of/, id);
  for (const id of ids(across)) assert.doesNotMatch(decisionSentence(null, of(id), "left", "en"), /name of|\[|\{/, id);
});
