// Both texts can be read back from their difference, and what they share is marked as shared.
import assert from "node:assert/strict";
import { test } from "vitest";
import { difference, type Piece } from "./text_diff.ts";

const side = (pieces: Piece[], without: Piece["kind"]): string => pieces.filter((p) => p.kind !== without).map((p) => p.text).join("");

test("a character or a word that was put in is the only one marked", () => {
  assert.deepEqual(difference("原有车距不足", "原有约 18 m 的车距不足"), [
    { kind: "same", text: "原有" },
    { kind: "added", text: "约 18 m 的" },
    { kind: "same", text: "车距不足" },
  ]);
  assert.deepEqual(difference("the ego yields", "the ego stops"), [
    { kind: "same", text: "the ego " },
    { kind: "removed", text: "yields" },
    { kind: "added", text: "stops" },
  ]);
});

test("a text that was written again is shown whole, not character by character", () => {
  const [before, after] = ["自车沿本车道行驶，左前方的轿车正越过车道线", "左侧车道的车在前方 22 m 处压线切入"];
  assert.deepEqual(difference(before, after), [
    { kind: "removed", text: before },
    { kind: "added", text: after },
  ]);
});

test("both texts can be read back", () => {
  for (const [a, b] of [["", "新"], ["旧", ""], ["a b c d", "c d a b"], ["前车减速", "前车 3 s 后减速并停下"], ["x ".repeat(700), "y ".repeat(700)]] as const) {
    const pieces = difference(a, b);
    assert.equal(side(pieces, "added"), a);
    assert.equal(side(pieces, "removed"), b);
  }
});
