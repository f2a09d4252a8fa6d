// Names of the label's fields for people: `/critical_components/0/description` is "Components c1, description".
import { parts } from "../../label/pointer.ts";
import type { Work } from "../../label/work.svelte.ts";
import { type Lang, t, type WordKey } from "../../text/text.svelte.ts";
import { words } from "../../text/words.ts";

/** The field that a pointer lies in; `lang` only makes callers follow the language. */
export function fieldName(path: string, work: Work, lang: Lang): string {
  const [top = "", ...rest] = parts(path);
  const key = top === "" ? "field.whole" : `field.${top}`;
  const name = key in words ? t(key as WordKey) : top;
  if (top === "critical_components" && rest[0] !== undefined) {
    const id = work.components[Number(rest[0])]?.["id"];
    const part = rest[1] ? `comp.${rest[1] === "linked_objects" ? "objects" : rest[1] === "evidence_times" ? "evidence" : rest[1]}` : "";
    return `${name} ${String(id ?? rest[0])}${part in words ? `${lang === "zh" ? "，" : ", "}${t(part as WordKey)}` : ""}`;
  }
  if ((top === "driving_decision" || top === "causes") && (rest[0] === "longitudinal" || rest[0] === "lateral")) {
    return `${name}${lang === "zh" ? "，" : ", "}${t(`dec.${rest[0]}`)}`;
  }
  if (top === "records" && rest[0]) {
    return work.spec?.records.find((r) => r.id === rest[0])?.name[lang] ?? rest[0];
  }
  return name;
}
