// Where keys lead: to what is written or chosen there.
import assert from "node:assert/strict";
import { test } from "vitest";
import { intoField, toComment, toComponent, toDirection, toField } from "./focus.ts";

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

test("the key of the components leads to the description of the current one, not to a choice beside it", () => {
  const part = (n: number): string => `<div data-component="${n}"><textarea id="t${n}"></textarea><input type="radio" id="r${n}" checked></div>`;
  document.body.innerHTML = `<section data-section="components"><h2 tabindex="-1"></h2>${part(0)}${part(1)}</section>`;
  toComponent(1);
  assert.equal(document.activeElement?.id, "t1");
  document.body.innerHTML = `<section data-section="components"><h2 tabindex="-1" id="h"></h2></section>`;
  toComponent(0);
  assert.equal(document.activeElement?.id, "h");
});

test("a finding about an input leads to the input, not to what stands before it", () => {
  document.body.innerHTML = `<div data-field="/causes/lateral"><input type="checkbox" id="c1"><input type="text" id="why" data-input="/causes/lateral/unobserved"></div>`;
  toField("/causes/lateral/unobserved");
  assert.equal(document.activeElement?.id, "why");
  intoField("/causes/lateral");
  assert.equal(document.activeElement?.id, "c1");
});

test("a field with choices that the focus comes to by itself has it as a whole: no digit chooses there", () => {
  document.body.innerHTML = `<div data-field="/driving_decision/lateral" id="f"><div data-choices="lateral"><input type="radio" checked id="r"></div></div>`;
  toField("/driving_decision/lateral");
  assert.equal(document.activeElement?.id, "f");
  // Out of the order of Tab again once it is left.
  document.querySelector<HTMLElement>("#r")?.focus();
  assert.equal(document.querySelector("#f")?.hasAttribute("tabindex"), false);
  document.body.innerHTML = `<div data-field="/coc_trace"><textarea id="t"></textarea></div>`;
  toField("/coc_trace");
  assert.equal(document.activeElement?.id, "t");
});

test("where a label is only read, the key of a part opens its comment", () => {
  document.body.innerHTML = `<div data-field="/critical_components/0"><button class="bubble" id="b0" aria-expanded="false"></button></div><div data-field="/coc_trace"><button class="bubble" id="b1" aria-expanded="true"></button><form><textarea id="t1"></textarea></form></div>`;
  const pressed: string[] = [];
  for (const button of document.querySelectorAll("button")) button.onclick = () => void pressed.push(button.id);
  assert.ok(toComment(["/critical_components"]));
  assert.deepEqual(pressed, ["b0"]);
  // One that is open is not closed: it gets the focus.
  assert.ok(toComment(["/coc_trace"]));
  assert.deepEqual(pressed, ["b0"]);
  assert.equal(document.activeElement?.id, "t1");
  assert.ok(!toComment(["/records"]));
});
