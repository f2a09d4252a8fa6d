// The history of one task, all pages of it.
import * as api from "../api/calls.generated.ts";
import type { HistoryEntry } from "../api/types.ts";

export async function allHistory(task: string): Promise<HistoryEntry[]> {
  const all: HistoryEntry[] = [];
  let cursor: string | null | undefined;
  do {
    const page = await api.getTaskHistory(task, { cursor });
    all.push(...page.items);
    cursor = page.next;
  } while (cursor != null);
  return all;
}
