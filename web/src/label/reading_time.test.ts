// A label can be accepted after 3 s on screen (docs/reference/labelling-page.md), in a page that is not hidden.
import assert from "node:assert/strict";
import { afterEach, beforeEach, test, vi } from "vitest";
import { ReadingTime } from "./reading_time.svelte.ts";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

test("a label is read after three seconds on screen, and stays read", () => {
  const reading = new ReadingTime();
  vi.advanceTimersByTime(10_000);
  assert.ok(!reading.isEnough, "not shown yet");
  reading.begin();
  vi.advanceTimersByTime(2_900);
  assert.ok(!reading.isEnough);
  vi.advanceTimersByTime(200);
  assert.ok(reading.isEnough);
  reading.pause();
  assert.ok(reading.isEnough);
});

test("time without the label on screen does not count", () => {
  const reading = new ReadingTime();
  reading.begin();
  reading.begin();
  vi.advanceTimersByTime(2_000);
  reading.pause();
  vi.advanceTimersByTime(10_000);
  assert.ok(!reading.isEnough);
  const visible = vi.spyOn(document, "visibilityState", "get").mockReturnValue("hidden");
  reading.begin();
  vi.advanceTimersByTime(10_000);
  assert.ok(!reading.isEnough, "the page is hidden");
  visible.mockReturnValue("visible");
  vi.advanceTimersByTime(1_100);
  assert.ok(reading.isEnough);
});
