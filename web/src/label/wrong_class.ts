// What an annotator tells the lead of a task whose class does not fit. Pure.
import type { Lang } from "../text/text.svelte.ts";

/** The reason of a skip: the class that fits, by the names of its levels, if one was chosen, and what was seen. */
export function wrongClassText(right: readonly string[] | null, note: string, lang: Lang): string {
  const zh = lang === "zh";
  const parts = [zh ? "场景不对" : "The class is wrong"];
  if (right) parts.push(zh ? `应为“${right.join(" › ")}”` : `it should be "${right.join(" › ")}"`);
  const said = note.trim();
  const head = parts.join(zh ? "，" : ", ");
  return said === "" ? `${head}${zh ? "。" : "."}` : `${head}${zh ? "：" : ": "}${said}`;
}
