// Times keep every nanosecond. Expected values: ISO 8601 and calendar arithmetic (315964800 s is 1980-01-06, the GPS
// epoch; 1465 s are 24 min 25 s).
import assert from "node:assert/strict";
import { test } from "vitest";
import { nearestIndex, secondsBetween, toIso, toNs } from "./ns.ts";

test("ISO and nanoseconds are the same moment, to the last digit", () => {
  assert.equal(toNs("1970-01-01T00:00:01.5Z"), 1_500_000_000n);
  assert.equal(toNs("2026-01-01T00:00:03.700Z"), 1_767_225_603_700_000_000n);
  assert.equal(toNs("2026-01-01T08:00:03.700+08:00"), 1_767_225_603_700_000_000n);
  for (const iso of ["2026-01-01T00:00:03.700Z", "1980-01-06T00:00:00.123456Z", "2020-03-04T05:06:07.123456789Z"]) {
    assert.equal(toIso(toNs(iso)), iso);
  }
  assert.equal(toIso(315966265259836001n), "1980-01-06T00:24:25.259836001Z");
  assert.throws(() => toNs("yesterday"), RangeError);
});

test("the nearest frame", () => {
  const times = [0n, 100n, 200n, 300n];
  assert.equal(nearestIndex(times, -5n), 0);
  assert.equal(nearestIndex(times, 149n), 1);
  assert.equal(nearestIndex(times, 151n), 2);
  assert.equal(nearestIndex(times, 900n), 3);
  assert.equal(secondsBetween(toNs("2026-01-01T00:00:03.7Z"), toNs("2026-01-01T00:00:03.2Z")), -0.5);
});
