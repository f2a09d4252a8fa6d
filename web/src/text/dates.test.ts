// Expected values: 0.5 h are 30 min, 72 h are 3 days; units as CLDR abbreviates them.
import assert from "node:assert/strict";
import { test } from "vitest";
import { clockName, exactDateTime, formatDateTime, formatDuration, OFFSETS } from "./dates.ts";

test("a task that waits for less than an hour waits for minutes, not for 0 hours", () => {
  assert.equal(formatDuration(0.0005, "en"), "1 min");
  assert.equal(formatDuration(0.5, "zh"), "30分钟");
  assert.equal(formatDuration(1.5, "en"), "1.5 hrs");
  assert.equal(formatDuration(47, "en"), "47 hrs");
  assert.equal(formatDuration(72, "en"), "3 days");
});

// 2026-09-21T16:30Z is 00:30 of the 22nd at UTC+8 (`TZ=Asia/Shanghai date -d 2026-09-21T16:30Z`).
test("a moment has the day and the time of the reader's zone, and names the zone", () => {
  const at = Date.UTC(2026, 8, 21, 16, 30, 5);
  assert.equal(formatDateTime(at, "zh", "Asia/Shanghai"), "2026年9月22日 00:30");
  assert.equal(formatDateTime(at, "en", "UTC"), "21 Sept 2026, 16:30");
  const exact = exactDateTime(at, "zh", "Asia/Shanghai");
  for (const part of ["2026年9月22日", "00:30:05", "GMT+8"]) assert.ok(exact.includes(part), exact);
});

test("clocks are named by their offset", () => {
  assert.deepEqual([0, 480, -210, 345, -300].map(clockName), ["UTC", "UTC+8", "UTC−3:30", "UTC+5:45", "UTC−5"]);
  assert.deepEqual([...OFFSETS].sort((a, b) => a - b), OFFSETS);
});
