// What a reader of a table sees: order, unknown values last, and with thousands of rows only those in sight.
import { fireEvent, render, screen } from "@testing-library/svelte";
import assert from "node:assert/strict";
import { beforeEach, describe, test } from "vitest";
import PeopleTable, { type Person } from "../testing/PeopleTable.svelte";
import { setLanguage } from "../text/text.svelte.ts";
import { type Column, nextSorting, rowsInSight, sorted } from "./table_rows.ts";

const people: readonly Person[] = [
  { id: "1", name: "王芳", age: 40 },
  { id: "2", name: "李明", age: null },
  { id: "3", name: "陈静", age: 9 },
];
const names = (): string[] => [...document.querySelectorAll("tbody tr[data-row] td:first-child")].map((td) => td.textContent);
const heading = (name: string): HTMLElement => screen.getByRole("columnheader", { name: new RegExp(`^${name}`) });

beforeEach(() => setLanguage("zh"));

describe("DataTable", () => {
  test("shows rows as given, and sorts by a heading: ascending, descending, as given", async () => {
    render(PeopleTable, { people });
    assert.deepEqual(names(), ["王芳", "李明", "陈静"]);
    const age = screen.getByRole("button", { name: /^Age/ });
    await fireEvent.click(age);
    assert.deepEqual(names(), ["陈静", "王芳", "李明"], "9 before 40, unknown last");
    assert.equal(heading("Age").getAttribute("aria-sort"), "ascending");
    await fireEvent.click(age);
    assert.deepEqual(names(), ["王芳", "陈静", "李明"], "unknown stays last");
    await fireEvent.click(age);
    assert.deepEqual(names(), ["王芳", "李明", "陈静"]);
    assert.equal(heading("Age").getAttribute("aria-sort"), null);
  });

  test("sorts Chinese names by pinyin in Chinese", async () => {
    render(PeopleTable, { people });
    await fireEvent.click(screen.getByRole("button", { name: /^Name/ }));
    assert.deepEqual(names(), ["陈静", "李明", "王芳"], "chén, lǐ, wáng");
  });

  test("a column of buttons has a heading for screen readers only, and cannot be sorted", () => {
    render(PeopleTable, { people });
    assert.ok(heading("Actions").querySelector(".unseen"));
    assert.equal(screen.queryByRole("button", { name: "Actions" }), null);
    assert.equal(screen.getAllByRole("button", { name: /^Remove/ }).length, 3);
  });

  test("the heading of a column that ticks rows ticks all of them", async () => {
    const asked: boolean[] = [];
    const ticks = { label: "All", all: false, some: true, set: (all: boolean) => void asked.push(all) };
    const { rerender } = render(PeopleTable, { people, ticks });
    const box = (): HTMLInputElement => screen.getByRole("checkbox", { name: "All" });
    assert.ok(box().indeterminate && !box().checked, "some are ticked");
    await fireEvent.click(box());
    assert.deepEqual(asked, [true]);
    await rerender({ people, ticks: { ...ticks, all: true } });
    assert.ok(!box().indeterminate && box().checked);
    await fireEvent.click(box());
    assert.deepEqual(asked, [true, false]);
  });

  test("renders a window of many rows and shows how many there are", () => {
    const many = Array.from({ length: 5000 }, (_, i) => ({ id: String(i), name: `n${i}`, age: i }));
    render(PeopleTable, { people: many });
    assert.ok(names().length < 100, `${names().length} rows are rendered`);
    assert.equal(names()[0], "n0");
    assert.equal(screen.getByRole("table").getAttribute("aria-rowcount"), "5001");
  });

  test("without rows: the text for it, or nothing", () => {
    const { unmount } = render(PeopleTable, { people: [], empty: "Nobody" });
    assert.ok(screen.getByText("Nobody"));
    unmount();
    render(PeopleTable, { people: [] });
    assert.equal(screen.queryByRole("table"), null);
  });
});

describe("table_rows", () => {
  const columns: readonly Column<number>[] = [{ title: "n", sortBy: (n) => n }, { title: "x" }];

  test("equal rows keep their order, an unsortable column changes nothing", () => {
    const rows = [3, 1, 2];
    assert.deepEqual(sorted(rows, columns, { column: "n", direction: "descending" }, "en"), [3, 2, 1]);
    assert.equal(sorted(rows, columns, { column: "x", direction: "ascending" }, "en"), rows);
    const same: Column<string> = { title: "s", sortBy: () => 0 };
    assert.deepEqual(sorted(["b", "a"], [same], { column: "s", direction: "descending" }, "en"), ["b", "a"]);
  });

  test("another column begins ascending", () => {
    assert.deepEqual(nextSorting({ column: "n", direction: "descending" }, "x"), { column: "x", direction: "ascending" });
    assert.equal(nextSorting({ column: "n", direction: "descending" }, "n"), null);
  });

  test("rows in sight, ten more above and below, never outside the table", () => {
    // 40 px rows in a viewport of 400 px, scrolled by 2000 px: rows 50 to 60 are in sight.
    assert.deepEqual(rowsInSight(1000, 40, 2000, 400), { from: 40, to: 70 });
    assert.deepEqual(rowsInSight(1000, 40, 0, 400), { from: 0, to: 20 });
    assert.deepEqual(rowsInSight(1000, 40, 39_600, 400), { from: 980, to: 1000 });
    assert.deepEqual(rowsInSight(5, 40, 9000, 400), { from: 4, to: 5 });
  });
});
