// The module graph of the page: no cycles, the API is called only through the generated functions, and only one module
// spells the label's pointers.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "vitest";

const files = readdirSync("src", { recursive: true })
  .map((file) => `src/${String(file).replaceAll("\\", "/")}`)
  .filter((file) => /\.(ts|svelte)$/.test(file) && !/\.test\.ts$/.test(file));
const sources = new Map(files.map((file) => [file, readFileSync(file, "utf8")]));

function importsOf(file: string): string[] {
  const found = sources.get(file)?.matchAll(/(?:from|import)\s+"(\.[^"]+)"/g) ?? [];
  return [...found].map((m) => join(dirname(file), m[1] ?? ""));
}

/** A path of imports that returns to `file`; null without one. */
function cycleFrom(file: string, path: readonly string[] = [file], seen = new Set<string>()): readonly string[] | null {
  for (const next of importsOf(path.at(-1) ?? "")) {
    if (next === file) return [...path, file];
    if (seen.has(next)) continue;
    seen.add(next);
    const found = cycleFrom(file, [...path, next], seen);
    if (found) return found;
  }
  return null;
}

test("every import names a file of the page", () => {
  assert.ok(files.length > 100, `${files.length} files`);
  const unknown = files.flatMap(importsOf).filter((file) => !sources.has(file) && !file.endsWith(".css"));
  assert.deepEqual(unknown, []);
});

test("no import cycles", () => {
  assert.deepEqual(files.map((file) => cycleFrom(file)?.join(" -> ")).filter(Boolean), []);
});

test("only the API client calls fetch", () => {
  assert.deepEqual(files.filter((file) => /\bfetch\(/.test(sources.get(file) ?? "")), ["src/api/client.ts"]);
});

test("only the generated module spells pointers of the label", () => {
  const pointer = /["'`]\/(keyframe|second_keyframe|time_range|critical_components|driving_decision|causes|coc_trace|records|secondary_scenarios)\b/;
  const code = (text: string): string => text.replace(/^\s*(\/\/|\*|\/\*\*).*$/gm, "");
  assert.deepEqual(files.filter((file) => pointer.test(code(sources.get(file) ?? ""))), ["src/label/label_fields.generated.ts"]);
});
