// The box for a comment names what it sends: a comment on a field, or a question to the lead.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test } from "vitest";
import type { TaskEditor } from "../../label/task_editor.svelte.ts";
import { setLanguage } from "../../text/text.svelte.ts";
import FieldComments from "./FieldComments.svelte";

test("a question to the lead is sent as one, and its button says so", async () => {
  const sent: unknown[] = [];
  const add = (...what: unknown[]): Promise<boolean> => Promise.resolve(sent.push(what) > 0);
  const editor = { comments: { add }, request: { busy: false }, can: () => true } as unknown as TaskEditor;
  const props = { editor, path: "", name: "问负责人", comments: [], open: true, close: () => {} };
  setLanguage("zh");
  const { rerender } = render(FieldComments, { ...props, toLead: true });
  await fireEvent.input(screen.getByLabelText("给负责人的问题"), { target: { value: "空当算要素吗？" } });
  await fireEvent.click(screen.getByRole("button", { name: "发给负责人" }));
  assert.deepEqual(sent, [["", "空当算要素吗？", true]]);
  await rerender({ ...props, name: "整份标注", toLead: false });
  assert.ok(screen.getByLabelText("对“整份标注”的意见"));
  assert.ok(screen.getByRole("button", { name: "写意见" }));
});
