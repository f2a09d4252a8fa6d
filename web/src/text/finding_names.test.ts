// Every code has a page in docs/diagnostics that says Warning or Note: an error cannot be submitted.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "vitest";
import { FINDING_CODES, findingName } from "./finding_names.ts";

test("the named findings are documented and can be on a submitted label", () => {
  for (const code of FINDING_CODES) {
    const page = readFileSync(`../docs/diagnostics/${code}.md`, "utf8");
    assert.match(page, /^# .*\n\n(Warning|Note)\./, code);
  }
  assert.equal(findingName("label.trace.too_long", "zh"), "因果描述过长");
  assert.equal(findingName("label.of.tomorrow", "en"), "another warning");
});
