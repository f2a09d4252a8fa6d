// Comments on one task, and why it was sent back.
import * as api from "../api/calls.generated.ts";
import type { Comment, Task } from "../api/types.ts";
import type { RequestState } from "../request_state.svelte.ts";
import { within } from "./changes.ts";
import { allHistory } from "./task_history.ts";

/** States in which a label may have been sent back. */
const AFTER_CHECK = ["rework", "submitted", "in_check"];

export class CommentList {
  items = $state.raw<readonly Comment[]>([]);
  /** Why the label was sent back the last time, and by whom; null when it was not. */
  returned = $state.raw<{ by: string; reason: string } | null>(null);
  #task: string;
  #request: RequestState;

  constructor(task: string, request: RequestState) {
    this.#task = task;
    this.#request = request;
  }

  show(task: Task): void {
    this.items = task.comments;
    this.returned = null;
    if (AFTER_CHECK.includes(task.task.state)) void this.#loadReason();
  }

  /** Comments on the field at `path` and on what is in it. */
  at(path: string): readonly Comment[] {
    return this.items.filter((c) => c.path !== "" && within(c.path, path));
  }

  async add(path: string, text: string): Promise<boolean> {
    const added = await this.#request.run(() => api.postTaskComments(this.#task, { path, text }));
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
      if (last) this.returned = { by: last.actor, reason: last.comment ?? "" };
    } catch {
      // Only those who may read the history see the reason.
    }
  }
}
