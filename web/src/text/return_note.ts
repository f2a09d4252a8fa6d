// Why a label was sent back, where the page wrote the note itself because comments say why: each reader has it in their
// own language.
import { t } from "./text.svelte.ts";

const SEE_COMMENTS = /^(?:见 (\d+) 条意见|See (\d+) comments?)$/;

export function returnNote(note: string): string {
  const found = SEE_COMMENTS.exec(note);
  return found ? t("check.see_comments", { n: Number(found[1] ?? found[2]) }) : note;
}
