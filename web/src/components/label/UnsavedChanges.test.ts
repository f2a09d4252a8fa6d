// What was written offline is not lost where the task is no longer the writer's.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import type { User } from "../../api/types.ts";
import { TaskEditor } from "../../label/task_editor.svelte.ts";
import { readUnsaved, writeUnsaved } from "../../label/unsaved_copy.ts";
import { setLanguage } from "../../text/text.svelte.ts";
import UnsavedChanges from "./UnsavedChanges.svelte";

test("unsaved text can be read after the task is gone, and given up", async () => {
  setLanguage("zh");
  const text = "前方的轿车正在减速";
  writeUnsaved("anna", "t7", { base: 3, changes: [{ path: "/critical_components/0/description", value: text }] });
  const editor = new TaskEditor("t7", { id: "anna" } as User);
  render(UnsavedChanges, { editor, user: "bert" });
  assert.equal(screen.queryByText(text), null, "another person's copy stays theirs");
  render(UnsavedChanges, { editor, user: "anna" });
  assert.ok(screen.getByText(text) && screen.getByText("关键要素 0，描述"));
  await fireEvent.click(screen.getByRole("button", { name: "放弃未保存的修改" }));
  assert.equal(readUnsaved("anna", "t7"), null);
  assert.equal(screen.queryByText(text), null);
});
