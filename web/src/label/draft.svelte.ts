// The label being edited: its content, its findings, and every change on its way to undo, to the service and to other
// tabs.
import * as api from "../api/calls.generated.ts";
import type { Conflicts, DraftSaved, Finding, Task } from "../api/types.ts";
import { apply, type Change, rooted, within } from "./changes.ts";
import { ConflictList, type Side } from "./conflicts.svelte.ts";
import { SERVICE_FIELDS } from "./field_pointers.ts";
import { type Json, read, same } from "./pointer.ts";
import { SaveQueue } from "./save_queue.svelte.ts";
import { TabChannel } from "./tab_channel.svelte.ts";
import { UndoHistory } from "./undo_history.svelte.ts";

/** What the annotator should know: changes by others came in, or unsaved changes of an earlier visit were found. */
export type DraftNotice = { kind: "merged"; fields: string[] } | { kind: "restored" };

export class Draft {
  doc = $state.raw<Json>({});
  findings = $state.raw<readonly Finding[]>([]);
  notice = $state.raw<DraftNotice | null>(null);
  readonly queue: SaveQueue;
  readonly undoHistory = new UndoHistory();
  readonly conflicts = new ConflictList();
  readonly tabs = new TabChannel();

  #task = "";
  #state = "";

  constructor(user: string) {
    this.queue = new SaveQueue(user, {
      saved: (reply) => this.#saved(reply),
      conflict: (found) => this.#conflict(found),
      isBlocked: () => this.conflicts.isOpen,
    });
  }

  /** Shows `task`. Changes that an earlier visit could not save are applied and sent. */
  load(task: Task): void {
    const isOther = task.task.id !== this.#task;
    // A new stage freezes fields: earlier edits can no longer be undone.
    if (isOther || task.task.state !== this.#state) this.undoHistory.clear();
    this.#task = task.task.id;
    this.#state = task.task.state;
    this.findings = task.findings;
    this.conflicts.clear();
    if (isOther) this.tabs.open(this.#task, (version) => void this.#follow(version));
    const restored = this.queue.open(task);
    this.doc = apply(task.draft as Json, restored);
    if (restored.length > 0) this.notice = { kind: "restored" };
  }

  at(path: string): Json | undefined {
    return read(this.doc, path);
  }

  text(path: string): string {
    const value = this.at(path);
    return typeof value === "string" ? value : "";
  }

  /** Sets the field at `path`; `undefined` removes it. */
  set(path: string, value: Json | undefined): void {
    const change = rooted(this.doc, { path, value });
    const before = this.at(change.path);
    if (same(before, change.value)) return;
    this.undoHistory.record({ ...change, before });
    this.#write(change);
  }

  /** Everything that `edit` sets is undone together. */
  group(edit: () => void): void {
    this.undoHistory.group(edit);
  }

  /** The service replaced `before` as a whole by what is shown now: one step to undo. */
  replaced(before: Json): void {
    const [then, now] = [before, this.doc] as [Record<string, Json>, Record<string, Json>];
    this.undoHistory.group(() => {
      for (const key of new Set([...Object.keys(then), ...Object.keys(now)])) {
        const path = `/${key}`;
        if (SERVICE_FIELDS.has(path) || same(then[key], now[key])) continue;
        this.undoHistory.record({ path, value: now[key], before: then[key] });
      }
    });
  }

  /** Takes the last edit back. Returns the field that changed, null when there was nothing to undo. */
  undo(): string | null {
    const changes = this.undoHistory.undo();
    changes?.forEach((change) => this.#write(change));
    return changes?.at(-1)?.path ?? null;
  }

  /** Repeats the edit undone last. Returns the field that changed, null when there was nothing to redo. */
  redo(): string | null {
    const changes = this.undoHistory.redo();
    changes?.forEach((change) => this.#write(change));
    return changes?.[0]?.path ?? null;
  }

  /** What is shown in the field at `path` cannot be saved now, so that the findings are about an earlier value. */
  isUnchecked(path = ""): boolean {
    const isStuck = ["offline", "lost", "refused"].includes(this.queue.status) || this.conflicts.isOpen;
    return isStuck && this.queue.unsavedPaths.some((p) => within(p, path) || within(path, p));
  }

  flush(): Promise<boolean> {
    return this.queue.flush();
  }

  /** Settles a conflict: `mine` is sent again on top of theirs, `theirs` is taken over. */
  settle(path: string, side: Side): void {
    const conflict = this.conflicts.take(path);
    if (!conflict) return;
    if (side === "theirs") {
      this.queue.drop(path);
      this.doc = apply(this.doc, [{ path, value: (conflict.theirs ?? null) as Json }]);
    }
    this.queue.resume();
  }

  /** Discards all unsaved changes. */
  discard(): void {
    this.conflicts.clear();
    this.queue.discard();
  }

  close(): void {
    this.queue.close();
    this.tabs.close();
  }

  #write(change: Change): void {
    this.doc = apply(this.doc, [change]);
    this.queue.add(change);
  }

  #saved(reply: DraftSaved): void {
    this.findings = reply.findings;
    if (reply.merged !== undefined && reply.merged !== null) {
      const fields = this.#merge(reply.merged as Json);
      if (fields.length > 0) this.notice = { kind: "merged", fields };
    }
    this.tabs.announceSaved(reply.version);
  }

  #conflict(found: Conflicts): void {
    this.conflicts.show(found.conflicts);
    this.doc = apply(found.draft as Json, this.queue.pending);
  }

  /** Puts another writer's draft under what is not sent yet. Returns the top-level fields that changed here. */
  #merge(draft: Json): string[] {
    const before = this.doc as Record<string, Json>;
    const after = apply(draft, this.queue.pending) as Record<string, Json>;
    this.doc = after;
    return [...new Set([...Object.keys(before), ...Object.keys(after)])].filter((key) => !same(before[key], after[key]));
  }

  /** Another tab saved `version`: it is fetched, so that both show one draft. */
  async #follow(version: number): Promise<void> {
    if (version <= this.queue.version || !this.queue.isIdle) return;
    try {
      const task = await api.getTask(this.#task);
      if (task.version <= this.queue.version || this.queue.pending.length > 0) return;
      this.queue.rebase(task.version);
      this.findings = task.findings;
      this.#merge(task.draft as Json);
    } catch {
      // The next save merges it.
    }
  }
}
