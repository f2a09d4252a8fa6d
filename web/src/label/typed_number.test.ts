// Numbers as annotators type them.
import assert from "node:assert/strict";
import { test } from "vitest";
import { typedNumber } from "./typed_number.ts";

test("a number is read in full width, with its unit, and with a comma", () => {
  for (const text of ["3.5", "３．５", "3.5 s", "3.5s", "３.５ｓ", "3,5", " 3.5 ", "3。5", "35e-1"]) assert.equal(typedNumber(text, "s"), 3.5, text);
  assert.equal(typedNumber("−2", "m"), -2);
  assert.equal(typedNumber("１０００", "m"), 1000);
});

test("what is no number of this unit stays as it was typed", () => {
  for (const text of ["", "三点五", "3.5 m", "3 5", "1,000,5", "s", "Infinity", "0x10", "3.5 s left"]) assert.equal(typedNumber(text, "s"), null, text);
});
