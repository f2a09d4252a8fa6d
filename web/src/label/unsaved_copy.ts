// The copy of unsaved changes in this browser: written before anything is sent, removed when the service has them.
import type { Change } from "./changes.ts";

export interface UnsavedChanges {
  /** Version of the draft that the changes are based on. */
  base: number;
  changes: Change[];
}

const keyOf = (user: string, task: string): string => `whyroad.draft.${user}.${task}`;

export function writeUnsaved(user: string, task: string, unsaved: UnsavedChanges): void {
  try {
    if (unsaved.changes.length === 0) localStorage.removeItem(keyOf(user, task));
    else {
      // JSON has no undefined: a removed field is marked.
      const changes = unsaved.changes.map((c) => (c.value === undefined ? { path: c.path, gone: true } : c));
      localStorage.setItem(keyOf(user, task), JSON.stringify({ base: unsaved.base, changes }));
    }
  } catch {
    // Storage full or forbidden: the service still gets every change, only the copy for a crash is missing.
  }
}

export function readUnsaved(user: string, task: string): UnsavedChanges | null {
  try {
    const stored = JSON.parse(localStorage.getItem(keyOf(user, task)) ?? "null") as {
      base: number;
      changes: (Change & { gone?: boolean })[];
    } | null;
    if (!stored || !Array.isArray(stored.changes)) return null;
    const changes = stored.changes.map((c) => (c.gone ? { path: c.path, value: undefined } : c));
    return { base: stored.base, changes };
  } catch {
    return null;
  }
}
