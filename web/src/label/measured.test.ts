// Values as they are written into a trace.
import assert from "node:assert/strict";
import { test } from "vitest";
import { named } from "./measured.ts";

test("a value is named by what the target is", () => {
  assert.equal(named("与目标的车头时距 THW", "轿车", "zh"), "与轿车的车头时距 THW");
  assert.equal(named("Time headway to the target", "bus", "en"), "Time headway to the bus");
  assert.equal(named("Targets ahead", "bus", "en"), "Targets ahead");
});
