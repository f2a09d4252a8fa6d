// The filter of the episode list: kept in the address, and moments without a class are listed apart.
import assert from "node:assert/strict";
import { test } from "vitest";
import { type EpisodeFilter, filterOf, queryOf, requestOf, UNEXPLAINED } from "./episode_filter.ts";

test("an address keeps the whole filter", () => {
  const all: EpisodeFilter[] = [
    { mined: "", scenario: "", unjudged: false },
    { mined: "week 1/ü&", scenario: "reactive_agent.cutin", unjudged: true },
    { mined: "", scenario: UNEXPLAINED, unjudged: false },
  ];
  for (const filter of all) assert.deepEqual(filterOf(queryOf(filter)), filter);
  assert.equal(queryOf({ mined: "", scenario: "", unjudged: false }), "", "a plain address is the plain list");
});

test("all classes are without the moments that none explains, which are asked for alone", () => {
  assert.deepEqual(requestOf(filterOf("")), { explained: true });
  assert.deepEqual(requestOf(filterOf("?scenario=other")), { scenario: "other" });
  assert.deepEqual(requestOf(filterOf("?scenario=safety&unjudged=true")), { scenario: "safety", unjudged: true });
});
