// Which decisions are offered for a scenario: those of its decision table. Expected values by hand.
import assert from "node:assert/strict";
import { test } from "vitest";
import type { ClassChoices } from "../api/types.ts";
import { directionsOf, fitOf } from "./framework.ts";

const turning: ClassChoices = {
  longitudinal: [
    { id: "yield_to_agent", direction: null, usual: true },
    { id: null, direction: null, usual: false },
  ],
  lateral: [
    { id: "turn", direction: "left", usual: true },
    { id: "lane_keeping", direction: null, usual: false },
  ],
  decides: false,
  reveals: false,
};

test("a decision is usual, possible or contradicts the scenario", () => {
  assert.equal(fitOf(turning, "longitudinal", "yield_to_agent"), "usual");
  assert.equal(fitOf(turning, "longitudinal", "null"), "possible", "null is no change");
  assert.equal(fitOf(turning, "longitudinal", "resume"), "impossible");
  assert.equal(fitOf(turning, "lateral", "null"), "impossible");
  assert.equal(fitOf(null, "lateral", "anything"), "possible", "an unknown scenario rules nothing out");
});

test("directions are those of the table, all where it names none", () => {
  assert.deepEqual(directionsOf(turning, "turn", ["left", "right", "uturn"]), ["left"]);
  assert.deepEqual(directionsOf(turning, "lane_change", ["left", "right"]), ["left", "right"]);
  assert.deepEqual(directionsOf(null, "turn", ["left", "right"]), ["left", "right"]);
});
