// Where the key of the direction leads: to the direction of the lateral decision, or to that decision.
import assert from "node:assert/strict";
import { test } from "vitest";
import { toDirection } from "./focus.ts";

const group = (name: string, values: string[], checked: string): string =>
  `<div data-choices="${name}">${values.map((v) => `<input type="radio" name="${name}" value="${v}" ${v === checked ? "checked" : ""}>`).join("")}</div>`;
const form = (...groups: string[]): void => {
  document.body.innerHTML = `<section data-section="decisions"><h2 tabindex="-1"></h2>${groups.join("")}</section>`;
};
const focused = (): string => (document.activeElement instanceof HTMLInputElement ? document.activeElement.value : "");

test("the direction that is chosen has the focus, else the first one", () => {
  form(group("lateral", ["turn", "lane_change"], "turn"), group("direction", ["left", "right"], "right"));
  toDirection();
  assert.equal(focused(), "right");
  form(group("lateral", ["turn", "lane_change"], "turn"), group("direction", ["left", "right"], ""));
  toDirection();
  assert.equal(focused(), "left");
});

test("a decision without a direction has the focus itself", () => {
  form(group("lateral", ["turn", "null"], "null"));
  toDirection();
  assert.equal(focused(), "null");
});
