// Texts: both languages, the same placeholders, no unused text, no replaced term.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "vitest";
import { actions } from "../keys/keymap.ts";
import { fieldNames, memberNames } from "../label/field_pointers.ts";
import { filled, setLanguage, t } from "./text.svelte.ts";
import { texts } from "./texts.ts";

const placeholders = (text: string): string =>
  [...new Set([...text.matchAll(/\{(\w+)[^}]*\}/g)].map((m) => m[1]))].sort().join();

test("every text is there in both languages and fills the same places", () => {
  for (const [key, [zh, en]] of Object.entries(texts)) {
    assert.ok(zh.trim() && en.trim(), key);
    assert.equal(placeholders(zh), placeholders(en), key);
  }
});

test("English has singular and plural, the value 1 is singular", () => {
  const text = "{n} {n:task|tasks} of {who}";
  assert.equal(filled(text, { n: 1, who: "Anna" }), "1 task of Anna");
  assert.equal(filled(text, { n: 0, who: "Anna" }), "0 tasks of Anna");
  assert.equal(filled("{n:is|are} {missing}", { n: 2 }), "are {missing}");
  setLanguage("en");
  assert.equal(t("tasks.count", { n: 1 }), "1 task listed");
  setLanguage("zh");
  assert.equal(t("tasks.count", { n: 1 }), "已列出 1 个任务");
});

/** Terms that the style guide replaced. */
const REPLACED_ZH = /经过|放回|鸟瞰图|叶子类|主叶|盲标|租约|审计|必记项|剪辑|检查员|因果推理|挖掘片段|现密码/;
const REPLACED_EN = /\b(mend|anew|told|stands|so many|unless said|what came of|one's own|held against|labell|remark)/i;

test("no text uses a word that was replaced", () => {
  const own = [...Object.values(texts), ...Object.values(fieldNames), ...Object.values(memberNames), ...Object.values(actions).map((a) => a.name)];
  assert.deepEqual(own.filter(([zh, en]) => REPLACED_ZH.test(zh) || REPLACED_EN.test(en)), []);
});

test("every text is used", () => {
  const sources = readdirSync("src", { recursive: true })
    .map(String)
    .filter((f) => /\.(svelte|ts)$/.test(f) && !/_texts\.ts$|\.test\.ts$/.test(f))
    .map((f) => readFileSync(`src/${f}`, "utf8"))
    .join("\n");
  // Some keys are composed: `state.${state}`.
  const built = [...sources.matchAll(/`([a-z0-9_.]+)\$\{/g)].map((m) => m[1] ?? "");
  const unused = Object.keys(texts).filter(
    (key) => !sources.includes(`"${key}"`) && !sources.includes(`'${key}'`) && !built.some((b) => b.includes(".") || b.endsWith("_") ? key.startsWith(b) : false),
  );
  assert.deepEqual(unused, []);
});
