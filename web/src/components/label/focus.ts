// Leads the keyboard to a place of the form.
import { SECTION_OF_FIELD } from "../../label/field_pointers.ts";

/** What takes a value; a button beside it, such as the one that accepts a draft, only where there is none. */
const FIELD = "textarea:not([readonly]), input:not(:disabled, [readonly]), select:not(:disabled)";
const BUTTON = "button:not(:disabled)";

function enter(place: Element | null | undefined): boolean {
  if (!place) return false;
  place.scrollIntoView({ block: "nearest" });
  // Of radios the chosen one; else the first thing that takes something.
  const chosen = place.querySelector<HTMLElement>("input[type=radio]:checked:not(:disabled)");
  const first = (what: string): HTMLElement | null => place.querySelector<HTMLElement>(what);
  const target = chosen ?? first(FIELD) ?? first(BUTTON) ?? first("h2");
  target?.focus();
  return target !== null;
}

/** To the section with this id; `within` names a part of it by selector. */
export function toSection(id: string, within?: string): void {
  const section = document.querySelector(`[data-section="${id}"]`);
  const header = section?.querySelector("h2");
  header?.scrollIntoView({ block: "nearest" });
  if (!enter(within ? section?.querySelector(within) : section)) header?.focus();
}

/** To the field that a JSON pointer means: its own, else the nearest one around it. */
export function toField(pointer: string): void {
  for (let at = pointer; at !== ""; at = at.slice(0, at.lastIndexOf("/"))) {
    if (enter(document.querySelector(`[data-field="${CSS.escape(at)}"]`))) return;
  }
  const id = SECTION_OF_FIELD[pointer.split("/")[1] ?? ""];
  if (id) toSection(id);
}
