// The copy of unsaved changes on this machine: written before anything is sent, taken away when the server has it.
import type { Change } from "./changes.ts";

export interface Kept {
  base: number;
  changes: Change[];
}

const name = (user: string, task: string): string => `whyroad.draft.${user}.${task}`;

export function keep(user: string, task: string, kept: Kept): void {
  try {
    if (kept.changes.length === 0) localStorage.removeItem(name(user, task));
    else {
      // JSON has no undefined: a removed field is marked.
      const changes = kept.changes.map((c) => (c.value === undefined ? { path: c.path, gone: true } : c));
      localStorage.setItem(name(user, task), JSON.stringify({ base: kept.base, changes }));
    }
  } catch {
    // Storage full or forbidden: the server still gets every change, only the copy for a crash is missing.
  }
}

export function kept(user: string, task: string): Kept | null {
  try {
    const read = JSON.parse(localStorage.getItem(name(user, task)) ?? "null") as {
      base: number;
      changes: (Change & { gone?: boolean })[];
    } | null;
    if (!read || !Array.isArray(read.changes)) return null;
    return { base: read.base, changes: read.changes.map((c) => (c.gone ? { path: c.path, value: undefined } : c)) };
  } catch {
    return null;
  }
}
