// Texts: both languages, the same places to fill in, and none that nobody shows.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "vitest";
import { texts } from "./texts.ts";

const places = (text: string): string => [...text.matchAll(/\{(\w+)\}/g)].map((m) => m[1]).sort().join();

test("every text is there in both languages and fills the same places", () => {
  for (const [key, [zh, en]] of Object.entries(texts)) {
    assert.ok(zh.trim() && en.trim(), key);
    assert.equal(places(zh), places(en), key);
  }
});

test("every text is used", () => {
  const sources = readdirSync("src", { recursive: true })
    .map(String)
    .filter((f) => /\.(svelte|ts)$/.test(f) && !/_words\.ts$|\.test\.ts$/.test(f))
    .map((f) => readFileSync(`src/${f}`, "utf8"))
    .join("\n");
  // Some keys are put together: `state.${state}`.
  const built = [...sources.matchAll(/`([a-z0-9_.]+)\$\{/g)].map((m) => m[1] ?? "");
  const unused = Object.keys(texts).filter(
    (key) => !sources.includes(`"${key}"`) && !sources.includes(`'${key}'`) && !built.some((b) => b.includes(".") || b.endsWith("_") ? key.startsWith(b) : false),
  );
  assert.deepEqual(unused, []);
});
