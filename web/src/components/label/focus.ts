// Moves the keyboard focus to a section or field of the form.
import { SECTION_OF_FIELD } from "../../label/field_pointers.ts";

/** Inputs; a button, such as the one that accepts a draft, only where there is no input. */
const FIELD = "textarea:not([readonly]), input:not(:disabled, [readonly]), select:not(:disabled)";
const BUTTON = "button:not(:disabled)";

const all = (name: "field" | "input"): HTMLElement[] => [...document.querySelectorAll<HTMLElement>(`[data-${name}]`)];

function enter(place: Element | null | undefined): boolean {
  if (!place) return false;
  place.scrollIntoView({ block: "nearest" });
  const first = (what: string): HTMLElement | null => place.querySelector<HTMLElement>(what);
  // What is written comes before what is chosen beside it; of radio buttons the checked one; else the first input.
  const target = first("textarea:not([readonly])") ?? first("input[type=radio]:checked:not(:disabled)") ?? first(FIELD) ?? first(BUTTON) ?? first("h2");
  target?.focus();
  return target !== null;
}

/**
 * Focuses a field as a whole, not what is chosen in it: a digit then leads to a field. A group of choices takes digits
 * only from somebody who went into it, never because the focus came by itself.
 */
export function rest(field: HTMLElement): void {
  field.scrollIntoView({ block: "nearest" });
  field.tabIndex = -1;
  field.addEventListener("blur", () => field.removeAttribute("tabindex"), { once: true });
  field.focus();
}

/** [`rest`] on the field at this JSON pointer. */
export function restAt(pointer: string): void {
  const field = all("field").find((one) => one.dataset["field"] === pointer);
  if (field) rest(field);
}

/** Is something chosen in `field` by a key, and nothing written? */
const isChosenIn = (field: Element): boolean =>
  field.querySelector("textarea:not([readonly])") === null && field.querySelector("input:is([type=radio], [type=checkbox]):not(:disabled)") !== null;

function reach(place: HTMLElement | null | undefined): boolean {
  if (!place || !isChosenIn(place)) return enter(place);
  rest(place);
  return true;
}

/** Focuses the section with this id, or the part of it that the selector `within` matches. */
export function toSection(id: string, within?: string): void {
  const section = document.querySelector(`[data-section="${id}"]`);
  const header = section?.querySelector("h2");
  header?.scrollIntoView({ block: "nearest" });
  if (!enter(within ? section?.querySelector(within) : section)) header?.focus();
}

/** Focuses the direction of the lateral decision; where that decision has none, the decision. */
export function toDirection(): void {
  const has = document.querySelector("[data-choices=direction]") !== null;
  toSection("decisions", has ? "[data-choices=direction]" : "[data-choices=lateral]");
}

/** Focuses the description of component `n`; without one to be written, the section. */
export function toComponent(n: number): void {
  const at = `[data-component="${n}"]`;
  const written = document.querySelector(`[data-section=components] ${at} textarea:not([readonly])`);
  toSection("components", written ? at : undefined);
}

/**
 * Opens the comment on the first field of a card that is at one of these pointers, so that what is typed next is the
 * comment and no key of the page; an open one gets the focus.
 */
export function toComment(pointers: readonly string[]): boolean {
  const field = all("field").find((f) => pointers.some((p) => f.dataset["field"] === p || f.dataset["field"]?.startsWith(`${p}/`)));
  const button = field?.querySelector<HTMLElement>(".bubble");
  button?.scrollIntoView({ block: "nearest" });
  if (button?.getAttribute("aria-expanded") === "true") field?.querySelector<HTMLElement>("form textarea")?.focus();
  else button?.click();
  return button != null;
}

/** Focuses the field at a JSON pointer, or the nearest field around it; where something is chosen, its first choice. */
export function intoField(pointer: string): void {
  toField(pointer, enter);
}

/** Focuses the field at a JSON pointer, or the nearest field around it: of choices the field, see [`rest`]. */
export function toField(pointer: string, go: (place: HTMLElement | undefined) => boolean = reach): void {
  const input = all("input").find((one) => one.dataset["input"] === pointer);
  if (input) {
    input.scrollIntoView({ block: "nearest" });
    input.focus();
    return;
  }
  for (let at = pointer; at !== ""; at = at.slice(0, at.lastIndexOf("/"))) {
    if (go(all("field").find((one) => one.dataset["field"] === at))) return;
  }
  const id = SECTION_OF_FIELD[pointer.split("/")[1] ?? ""];
  if (id) toSection(id);
}
