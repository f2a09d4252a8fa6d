// Undo and redo on the screen: the field that changed is scrolled into view, marked for a moment and announced to
// screen readers.
import { tick } from "svelte";
import { pointers, SECTION_OF_FIELD } from "../../label/field_pointers.ts";
import { type Json, same } from "../../label/pointer.ts";
import type { TaskEditor } from "../../label/task_editor.svelte.ts";
import { lang, t } from "../../text/text.svelte.ts";
import { fieldName } from "./field_name.ts";

export function undo(editor: TaskEditor): Promise<void> {
  return change(editor, () => editor.draft.undo(), "app.undone");
}

export function redo(editor: TaskEditor): Promise<void> {
  return change(editor, () => editor.draft.redo(), "app.redone");
}

/** The undo of the browser's menu, or by a key that only the browser knows: the page's, where the page has it. */
export function undoInstead(editor: TaskEditor, e: InputEvent): void {
  const does = e.inputType === "historyUndo" ? undo : e.inputType === "historyRedo" ? redo : null;
  if (!does || !(e.target instanceof HTMLElement) || e.target.dataset["undo"] !== "page") return;
  e.preventDefault();
  void does(editor);
}

async function change(editor: TaskEditor, step: () => string | null, what: "app.undone" | "app.redone"): Promise<void> {
  const box = document.activeElement instanceof HTMLTextAreaElement ? document.activeElement : null;
  const before = box?.value ?? "";
  const were = editor.components;
  const changed = editor.canEdit ? step() : null;
  if (changed === null) return;
  await tick();
  const path = changed === pointers.components ? componentOf(editor, were) : changed;
  // A text that is put into a field leaves the cursor at its end, which is not where the change was.
  if (box && box.value !== before) box.setSelectionRange(...at(endOfChange(before, box.value)));
  editor.announcement = t(what, { field: fieldName(path, editor, lang.now) });
  const field = fieldAt(path) ?? document.querySelector(`[data-section="${SECTION_OF_FIELD[path.split("/")[1] ?? ""] ?? ""}"]`);
  field?.scrollIntoView({ block: "nearest" });
  field?.animate([{ backgroundColor: "var(--accent-soft)" }, { backgroundColor: "transparent" }], 1200);
}

/** The component that came, went or changed: the list is one field. */
function componentOf(editor: TaskEditor, before: readonly Json[]): string {
  const n = editor.components.findIndex((one, n) => !same(one, before[n]));
  if (n < 0) return pointers.components;
  editor.currentComponent = n;
  return pointers.component(n);
}

const at = (place: number): [number, number] => [place, place];

/** Where the part of `after` ends that differs from `before`. */
export function endOfChange(before: string, after: string): number {
  let kept = 0;
  while (kept < Math.min(before.length, after.length) && before.at(-1 - kept) === after.at(-1 - kept)) kept++;
  return after.length - kept;
}

/** The field of the form at a pointer, or the nearest field around it. */
function fieldAt(pointer: string): Element | null {
  const all = [...document.querySelectorAll<HTMLElement>("[data-field]")];
  for (let at = pointer; at !== ""; at = at.slice(0, at.lastIndexOf("/"))) {
    const found = all.find((one) => one.dataset["field"] === at);
    if (found) return found;
  }
  return null;
}
