// What a table shows of its rows: in which order, and which of them are in sight. Pure.

export interface Column<Row> {
  /** Heading; unique in the table. */
  title: string;
  /** The heading is for screen readers only: columns of buttons and bars. */
  titleHidden?: boolean;
  /** Tooltip of the heading. */
  hint?: string;
  /** Right-aligned, tabular digits. */
  numeric?: boolean;
  /** What the rows are sorted by; absent: the column cannot be sorted. */
  sortBy?: (row: Row) => string | number | null | undefined;
}

export interface Sorting {
  /** Title of the column. */
  column: string;
  direction: "ascending" | "descending";
}

/** The sorting after one more click on a column's heading: ascending, descending, none. */
export function nextSorting(now: Sorting | null, column: string): Sorting | null {
  if (now?.column !== column) return { column, direction: "ascending" };
  return now.direction === "ascending" ? { column, direction: "descending" } : null;
}

/** The rows in a new order; unknown values come last in both directions, equal ones keep their order. */
export function sorted<Row>(rows: readonly Row[], columns: readonly Column<Row>[], sorting: Sorting | null, locale: string): readonly Row[] {
  const by = columns.find((c) => c.title === sorting?.column)?.sortBy;
  if (!by || !sorting) return rows;
  const { compare } = new Intl.Collator(locale, { numeric: true });
  const sign = sorting.direction === "ascending" ? 1 : -1;
  return rows
    .map((row) => ({ row, value: by(row) ?? null }))
    .sort((a, b) => {
      if (a.value === null || b.value === null) return Number(a.value === null) - Number(b.value === null);
      const order = typeof a.value === "number" && typeof b.value === "number" ? a.value - b.value : compare(String(a.value), String(b.value));
      return sign * order;
    })
    .map(({ row }) => row);
}

export interface RowRange {
  /** First row that is rendered. */
  from: number;
  /** One past the last. */
  to: number;
}

/** Rows rendered above and below what is in sight, so that scrolling shows no gap. */
const OVERSCAN = 10;

/** The rows to render of `count` rows of equal height, all lengths in px. */
export function rowsInSight(count: number, rowHeight: number, scrollTop: number, viewportHeight: number): RowRange {
  const first = Math.floor(scrollTop / rowHeight) - OVERSCAN;
  const last = Math.ceil((scrollTop + viewportHeight) / rowHeight) + OVERSCAN;
  const from = Math.min(Math.max(0, first), Math.max(0, count - 1));
  return { from, to: Math.min(count, Math.max(from, last)) };
}
