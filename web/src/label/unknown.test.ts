// The words that the hint of `label.record.missing` offers, and their like, are the one value "unknown".
import assert from "node:assert/strict";
import { test } from "vitest";
import { isUnknown } from "./unknown.ts";

test("what people write for a value that cannot be seen is understood", () => {
  for (const text of ["看不出", "未知", " 看不清。", "Unknown", "cannot be seen"]) assert.ok(isUnknown(text), text);
  for (const text of ["", "3.5", "未知道路", "see c1"]) assert.ok(!isUnknown(text), text);
});
