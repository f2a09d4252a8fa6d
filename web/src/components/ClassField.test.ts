// A class is chosen by its whole name; a part of one chooses nothing and says so.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { test, vi } from "vitest";
import { setLanguage } from "../text/text.svelte.ts";
import ClassField from "./ClassField.svelte";

vi.mock("../class_names.svelte.ts", () => {
  const leaves = [{ id: "a.b.c", name: { zh: "紧急切入", en: "Urgent cut-in" } }];
  const groups = [{ id: "a.b", name: { zh: "切入", en: "Cut-in" }, leaves }];
  return {
    groupName: (id: string) => (id === "a.b.c" ? "其他交通参与者 › 切入" : "其他交通参与者"),
    leafName: (id: string) => (({ "a.b.c": "紧急切入", "a.b": "切入" }) as Record<string, string>)[id] ?? id,
    loadFramework: () => Promise.resolve(),
    tree: () => [{ id: "a", name: { zh: "其他交通参与者", en: "" }, groups }],
  };
});

test("a class is chosen by its name, and an unknown name is said to be one", async () => {
  setLanguage("zh");
  render(ClassField, { label: "应为哪个场景", chosen: null });
  const field = screen.getByLabelText<HTMLInputElement>("应为哪个场景");
  await fireEvent.input(field, { target: { value: "让行" } });
  assert.ok(screen.getByText("没有这个场景：从列表中选择。"));
  await fireEvent.input(field, { target: { value: "紧急" } });
  assert.ok(screen.getByText("按 Enter 选择“紧急切入”。"));
  await fireEvent.keyDown(field, { key: "Enter" });
  assert.equal(field.value, "紧急切入");
  await fireEvent.input(field, { target: { value: "" } });
  await fireEvent.input(field, { target: { value: "紧急切入" } });
  assert.ok(screen.getByText("其他交通参与者 › 切入", { selector: "p" }));
});

test("an L2 can be chosen where the variant cannot be told, after the L3 classes", async () => {
  setLanguage("zh");
  const { container } = render(ClassField, { label: "应为哪个场景", chosen: null });
  const names = [...container.querySelectorAll("option")].map((o) => o.value);
  assert.deepEqual(names, ["紧急切入", "切入（变体未知）"]);
  const field = screen.getByLabelText<HTMLInputElement>("应为哪个场景");
  await fireEvent.input(field, { target: { value: "变体" } });
  await fireEvent.keyDown(field, { key: "Enter" });
  assert.equal(field.value, "切入（变体未知）");
  assert.ok(screen.getByText("其他交通参与者", { selector: "p" }));
});

test("a proposed class is there by name", () => {
  setLanguage("zh");
  render(ClassField, { label: "应为哪个场景", chosen: "a.b.c" });
  assert.equal(screen.getByLabelText<HTMLInputElement>("应为哪个场景").value, "紧急切入");
});
