// Names of classes and values are those of the reports and the documentation.
import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { classNames, valueNames } from "./category_names.ts";

const root = "..";
const found = (file: string, pattern: RegExp): [string, [string, string]][] =>
  [...readFileSync(`${root}/${file}`, "utf8").matchAll(pattern)].map(([, id = "", zh = "", en = ""]) => [id, [zh, en]]);

test("classes of objects are called as in crates/whyroad-model/src/names.rs", () => {
  const theirs = found("crates/whyroad-model/src/names.rs", /ObjectClass::(\w+) => \("(.*?)", "(.*?)"\)/g);
  expect(theirs.length).toBe(19);
  const snake = (name: string): string => name.replace(/(?<!^)(?=[A-Z])/g, "_").toLowerCase();
  expect(classNames).toEqual(Object.fromEntries(theirs.map(([id, names]) => [snake(id), names])));
});

test("values of signals are called as in schema/signals.yaml, and all of them", () => {
  const values = found("schema/signals.yaml", /^ {2}"?(\w+)"?: \{ zh: (.*?), en: "?(.*?)"? \}$/gm);
  expect(values.length).toBeGreaterThan(100);
  const ours: Record<string, readonly [string, string]> = { ...classNames, ...valueNames };
  expect(ours).toMatchObject(Object.fromEntries(values));
});
