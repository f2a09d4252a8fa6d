// A note that the page wrote is shown in the language of its reader.
import assert from "node:assert/strict";
import { test } from "vitest";
import { returnNote } from "./return_note.ts";
import { setLanguage, t } from "./text.svelte.ts";

test("a note that only points at comments is translated, any other stays", () => {
  setLanguage("zh");
  const written = t("check.see_comments", { n: 2 });
  setLanguage("en");
  assert.equal(returnNote(written), "See 2 comments");
  assert.equal(returnNote("见 2 条意见，尤其是第一条"), "见 2 条意见，尤其是第一条");
  const one = t("check.see_comments", { n: 1 });
  setLanguage("zh");
  assert.equal(returnNote(one), "见 1 条意见");
});
