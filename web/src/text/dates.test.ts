// Expected values: 0.5 h are 30 min, 72 h are 3 days; units as CLDR abbreviates them.
import assert from "node:assert/strict";
import { test } from "vitest";
import { formatDuration } from "./dates.ts";

test("a task that waits for less than an hour waits for minutes, not for 0 hours", () => {
  assert.equal(formatDuration(0.0005, "en"), "1 min");
  assert.equal(formatDuration(0.5, "zh"), "30分钟");
  assert.equal(formatDuration(1.5, "en"), "1.5 hrs");
  assert.equal(formatDuration(47, "en"), "47 hrs");
  assert.equal(formatDuration(72, "en"), "3 days");
});
