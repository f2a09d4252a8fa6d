// Names of the label's fields for people: `/critical_components/0/description` is "Critical components c1,
// description".
import { fieldNames, memberNames } from "../../label/field_pointers.ts";
import { parts } from "../../label/pointer.ts";
import type { TaskEditor } from "../../label/task_editor.svelte.ts";
import { type Lang, sideOf, t } from "../../text/text.svelte.ts";

/** The field that a pointer is in. `lang` makes callers depend on the language. */
export function fieldName(path: string, editor: TaskEditor, lang: Lang): string {
  const [top = "", ...rest] = parts(path);
  if (top === "") return t("field.whole");
  const name = sideOf(fieldNames[top], lang) ?? top;
  const comma = lang === "zh" ? "，" : ", ";
  if (top === "critical_components" && rest[0] !== undefined) {
    const id = editor.components[Number(rest[0])]?.["id"];
    const member = sideOf(memberNames[rest[1] ?? ""], lang);
    return `${name} ${String(id ?? rest[0])}${member ? comma + member : ""}`;
  }
  if (rest[0] === undefined) return name;
  if (top === "records") return editor.spec?.records.find((r) => r.id === rest[0])?.name[lang] ?? rest[0];
  const member = ["driving_decision", "causes", "time_range"].includes(top) ? sideOf(memberNames[rest[0]], lang) : undefined;
  return member ? name + comma + member : name;
}
