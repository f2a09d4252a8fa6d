// Comments on one task, and why it was sent back.
import * as api from "../api/calls.generated.ts";
import type { Comment, Task } from "../api/types.ts";
import type { RequestState } from "../request_state.svelte.ts";
import { within } from "./changes.ts";
import type { Json } from "./pointer.ts";
import { allHistory } from "./task_history.ts";

/** States in which a label may have been sent back. */
const AFTER_CHECK = ["rework", "submitted", "in_check", "checked", "in_audit"];

export class CommentList {
  items = $state.raw<readonly Comment[]>([]);
  /** Why the label was sent back the last time, and by whom; null when it was not. */
  returned = $state.raw<{ by: string; reason: string } | null>(null);
  /** When that was, ms since 1970; null when it was not. */
  returnedAt = $state<number | null>(null);
  /** The label as it was sent back; null when it was not. */
  returnedDraft = $state.raw<Json | null>(null);
  #task: string;
  #request: RequestState;

  constructor(task: string, request: RequestState) {
    this.#task = task;
    this.#request = request;
  }

  show(task: Task): void {
    this.items = task.comments;
    this.returned = null;
    this.returnedDraft = null;
    this.returnedAt = null;
    if (AFTER_CHECK.includes(task.task.state)) void this.#loadReason();
  }

  /** Comments on the field at `path` and on what is in it. */
  at(path: string): readonly Comment[] {
    return this.items.filter((c) => c.path !== "" && within(c.path, path));
  }

  /** Open questions to the lead. */
  get asked(): readonly Comment[] {
    return this.items.filter((c) => c.to_lead && !c.resolved);
  }

  async add(path: string, text: string, toLead = false): Promise<boolean> {
    const added = await this.#request.run(() => api.postTaskComments(this.#task, { path, text, to_lead: toLead }));
    if (added) this.items = [...this.items, added];
    return added !== undefined;
  }

  async resolve(id: string): Promise<void> {
    const resolved = await this.#request.run(() => api.postCommentResolve(id));
    if (resolved) this.items = this.items.map((c) => (c.id === id ? resolved : c));
  }

  /** The reason is in the history: comments on fields may add to it. */
  async #loadReason(): Promise<void> {
    try {
      const last = (await allHistory(this.#task)).findLast((e) => e.action === "send_back");
      if (!last) return;
      this.returnedAt = Number(last.at);
      this.returned = { by: last.actor, reason: last.comment ?? "" };
      this.returnedDraft = (await api.getTaskHistoryBySeq(this.#task, Number(last.seq))).draft as Json;
    } catch {
      // Only those who may read the history see the reason.
    }
  }
}
