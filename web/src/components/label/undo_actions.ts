// Undo and redo on the screen: the field that changed is scrolled into view and announced to screen readers.
import type { TaskEditor } from "../../label/task_editor.svelte.ts";
import { lang, t } from "../../text/text.svelte.ts";
import { fieldName } from "./field_name.ts";

export function undo(editor: TaskEditor): void {
  tell(editor, editor.canEdit ? editor.draft.undo() : null, "app.undone");
}

export function redo(editor: TaskEditor): void {
  tell(editor, editor.canEdit ? editor.draft.redo() : null, "app.redone");
}

function tell(editor: TaskEditor, path: string | null, what: "app.undone" | "app.redone"): void {
  if (path === null) return;
  editor.announcement = t(what, { field: fieldName(path, editor, lang.now) });
  const field = fieldAt(path);
  field?.scrollIntoView({ block: "nearest" });
  field?.animate([{ backgroundColor: "var(--accent-soft)" }, { backgroundColor: "transparent" }], 1200);
}

/** The field of the form at a pointer, or the nearest field around it. */
function fieldAt(pointer: string): Element | null {
  for (let at = pointer; at !== ""; at = at.slice(0, at.lastIndexOf("/"))) {
    const found = document.querySelector(`[data-field="${CSS.escape(at)}"]`);
    if (found) return found;
  }
  return null;
}
