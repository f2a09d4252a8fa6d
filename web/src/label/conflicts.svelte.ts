// Fields that were changed here and elsewhere, until a person has chosen a side for each.
import type { FieldConflict } from "../api/types.ts";
import { type Json, same } from "./pointer.ts";

export type Side = "mine" | "theirs";

export class ConflictList {
  items = $state.raw<readonly FieldConflict[]>([]);

  get isOpen(): boolean {
    return this.items.length > 0;
  }

  /** Equal values on both sides are no conflict: the change arrived although its answer did not. */
  show(found: readonly FieldConflict[]): void {
    this.items = found.filter((c) => !same(c.mine as Json, c.theirs as Json));
  }

  /** Removes the conflict at `path` and returns it; null without one. */
  take(path: string): FieldConflict | null {
    const conflict = this.items.find((c) => c.path === path);
    if (!conflict) return null;
    this.items = this.items.filter((c) => c !== conflict);
    return conflict;
  }

  clear(): void {
    this.items = [];
  }
}
