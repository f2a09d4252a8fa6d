// Undo and redo as the reader sees them: the field that changed comes into sight and is named for those who do not see it.
import type { Work } from "../../label/work.svelte.ts";
import { lang, t } from "../../text/text.svelte.ts";
import { fieldName } from "./names.ts";

export function undo(work: Work): void {
  tell(work, work.edits ? work.draft.undo() : null, "app.undone");
}

export function redo(work: Work): void {
  tell(work, work.edits ? work.draft.redo() : null, "app.redone");
}

function tell(work: Work, path: string | null, what: "app.undone" | "app.redone"): void {
  if (path === null) return;
  work.said = t(what, { field: fieldName(path, work, lang.now) });
  const field = fieldAt(path);
  field?.scrollIntoView({ block: "nearest" });
  field?.animate([{ backgroundColor: "var(--accent-soft)" }, { backgroundColor: "transparent" }], 1200);
}

/** The field of the form that the pointer means: its own, else the nearest one around it. */
function fieldAt(pointer: string): Element | null {
  for (let at = pointer; at !== ""; at = at.slice(0, at.lastIndexOf("/"))) {
    const found = document.querySelector(`[data-field="${CSS.escape(at)}"]`);
    if (found) return found;
  }
  return null;
}
