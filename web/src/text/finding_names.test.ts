// Every code of a label that its page in docs/diagnostics calls a warning or a note, always or in some cases, has a
// name: an error cannot be submitted.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "vitest";
import { FINDING_CODES, findingName } from "./finding_names.ts";

const PAGES = "../docs/diagnostics";
/** Of files and their format, and of reports on other texts: never on a label that the service stores. */
const ELSEWHERE = /^label\.(input|json|migrate|quality|unknown_field|version)(\.|$)/;

test("exactly the codes that a submitted label can have are named", () => {
  const documented = readdirSync(PAGES)
    .map((file) => file.replace(/\.md$/, ""))
    .filter((code) => code.startsWith("label.") && !ELSEWHERE.test(code))
    .filter((code) => {
      const english = readFileSync(`${PAGES}/${code}.md`, "utf8").split("\n## 中文")[0] ?? "";
      return /^# .*\n\n(Warning|Note)\./.test(english) || /\ba warning\b/i.test(english);
    });
  assert.deepEqual([...FINDING_CODES].sort(), documented.sort());
});

test("a name for each language, and one for all other codes", () => {
  assert.equal(findingName("label.trace.too_long", "zh"), "因果描述过长");
  assert.equal(findingName("label.of.tomorrow", "en"), "another warning");
});
