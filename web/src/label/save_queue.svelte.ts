// Changes on their way to the service. Each is stored in this browser before it is sent and is removed from there only
// when the service has acknowledged it. Sends one request at a time; knows nothing of the label's content.
import * as api from "../api/calls.generated.ts";
import { ApiError, Offline } from "../api/client.ts";
import { sessionEnded } from "../session.svelte.ts";
import type { Conflicts, DraftSaved, Task } from "../api/types.ts";
import { type Change, join, needed, within } from "./changes.ts";
import { isHidden } from "./field_pointers.ts";
import type { Json } from "./pointer.ts";
import { readUnsaved, writeUnsaved } from "./unsaved_copy.ts";

/**
 * `waiting`: a change will be sent soon. `offline`: the service cannot be reached, sending is tried again. `lost`: the
 * lease is lost, nothing is sent any more. `refused`: the service rejected a change.
 */
export type SaveStatus = "saved" | "saving" | "waiting" | "offline" | "lost" | "refused";

/** A pause in typing of this length sends what was typed. */
const TYPING_REST_MS = 350;
const FIRST_RETRY_MS = 500;
const LONGEST_RETRY_MS = 10_000;
/** Changes per request. */
const BATCH = 100;

/** What the owner of the draft does with the answers. */
export interface SaveListener {
  saved(reply: DraftSaved): void;
  conflict(found: Conflicts): void;
  /** Conflicts wait for a decision: nothing may be sent. */
  isBlocked(): boolean;
}

export class SaveQueue {
  status = $state<SaveStatus>("saved");
  /** Number of changes that the service has not acknowledged. */
  unsaved = $state(0);
  /** Their fields. */
  unsavedPaths = $state.raw<readonly string[]>([]);
  /** Why the service rejected a change; null when it did not. */
  refused = $state.raw<ApiError | null>(null);

  #user: string;
  #listener: SaveListener;
  #task = "";
  #fence: number | null = null;
  #version = 0;
  #pending: Change[] = [];
  #sending: Change[] = [];
  #timer: ReturnType<typeof setTimeout> | undefined;
  #retryMs = FIRST_RETRY_MS;
  #running: Promise<void> | null = null;

  constructor(user: string, listener: SaveListener) {
    this.#user = user;
    this.#listener = listener;
  }

  /** The version of the draft that the changes are based on. */
  get version(): number {
    return this.#version;
  }

  /** Changes that are not being sent yet. */
  get pending(): readonly Change[] {
    return this.#pending;
  }

  /** Nothing waits and nothing is being sent. */
  get isIdle(): boolean {
    return this.#pending.length === 0 && !this.#running;
  }

  /**
   * Starts at the service's version of a task. Returns the changes that an earlier visit could not save; they are sent.
   */
  open(task: Task): readonly Change[] {
    this.#task = task.task.id;
    this.#fence = task.fence ?? null;
    this.#version = task.version;
    this.status = "saved";
    this.refused = null;
    const left = this.#fence === null ? null : readUnsaved(this.#user, this.#task);
    this.#sending = [];
    this.#pending = left ? needed(task.draft as Json, left.changes) : [];
    if (left && this.#pending.length > 0) {
      this.#version = left.base;
      this.#schedule(0);
    }
    this.#store();
    return this.#pending;
  }

  add(change: Change): void {
    this.#pending = join(this.#pending, change);
    this.#store();
    // A value that was refused may be valid now.
    if (this.status === "saved" || this.status === "refused") this.status = "waiting";
    this.#schedule(TYPING_REST_MS);
  }

  /** Removes what was changed in the field at `path`. */
  drop(path: string): void {
    this.#pending = this.#pending.filter((c) => !within(c.path, path));
  }

  /** The draft of another writer was taken over up to `version`. */
  rebase(version: number): void {
    this.#version = version;
  }

  /** Continues after a decision on a conflict. */
  resume(): void {
    this.#store();
    if (!this.#listener.isBlocked()) this.#schedule(0);
  }

  /** The lease is lost: nothing is sent any more; unsaved changes stay in this browser. */
  stop(): void {
    clearTimeout(this.#timer);
    this.status = "lost";
  }

  /** Discards all unsaved changes. */
  discard(): void {
    clearTimeout(this.#timer);
    this.#pending = [];
    this.#sending = [];
    this.refused = null;
    this.#store();
  }

  close(): void {
    clearTimeout(this.#timer);
  }

  /** Sends everything now. True when all of it is acknowledged, false when some of it cannot be sent. */
  async flush(): Promise<boolean> {
    clearTimeout(this.#timer);
    while (!this.isIdle) {
      if (this.#fence === null || this.status === "lost" || this.status === "refused") return false;
      const before = this.status;
      await (this.#running ?? this.#send());
      if (this.status !== "saved" && this.status !== "saving" && this.status !== "waiting") return false;
      if (this.#listener.isBlocked() || (before === "offline" && this.status === "waiting")) return false;
    }
    return true;
  }

  /** Writes the copy in this browser. */
  #store(): void {
    const changes = [...this.#sending, ...this.#pending];
    // A time and its frame are one change for people.
    this.unsavedPaths = changes.map((c) => c.path);
    this.unsaved = changes.filter((c) => !isHidden(c.path)).length;
    if (this.#fence !== null) writeUnsaved(this.#user, this.#task, { base: this.#version, changes });
  }

  #schedule(ms: number): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#send(), ms);
  }

  #send(): Promise<void> {
    if (this.#running) return this.#running;
    this.#running = this.#sendBatch().finally(() => {
      this.#running = null;
      const stopped = this.status === "lost" || this.status === "refused" || this.#listener.isBlocked();
      if (this.#pending.length > 0 && !stopped) this.#schedule(this.status === "offline" ? this.#retryMs : 0);
    });
    return this.#running;
  }

  async #sendBatch(): Promise<void> {
    if (this.#pending.length === 0 || this.#fence === null || this.#listener.isBlocked() || this.status === "lost") return;
    this.#sending = this.#pending.slice(0, BATCH);
    this.#pending = this.#pending.slice(BATCH);
    if (this.status !== "offline") this.status = "saving";
    const task = this.#task;
    const changes = this.#sending.map((c) =>
      c.value === undefined ? { path: c.path, value: null, remove: true } : { path: c.path, value: c.value },
    );
    try {
      const reply = await api.patchTaskDraft(task, { fence: this.#fence, base_version: this.#version, changes });
      if (task !== this.#task) return;
      this.#sending = [];
      this.#version = reply.version;
      this.#retryMs = FIRST_RETRY_MS;
      this.status = this.#pending.length > 0 ? "waiting" : "saved";
      this.#listener.saved(reply);
      this.#store();
    } catch (error) {
      if (task !== this.#task) return;
      this.#pending = this.#sending.concat(this.#pending).reduce<Change[]>(join, []);
      this.#sending = [];
      this.#fail(error);
      this.#store();
    }
  }

  #fail(error: unknown): void {
    if (error instanceof Offline || (error instanceof ApiError && (error.status >= 500 || error.status === 429))) {
      this.status = "offline";
      this.#retryMs = Math.min(LONGEST_RETRY_MS, this.#retryMs * 1.6);
    } else if (!(error instanceof ApiError)) {
      throw error;
    } else if (error.code === "draft.conflict") {
      const found = error.body["more"] as Conflicts;
      this.#version = found.version;
      this.#pending = needed(found.draft as Json, this.#pending);
      this.#listener.conflict(found);
      this.status = "waiting";
    } else if (error.code === "lease.lost" || error.code === "lease.not_yours" || error.status === 404) {
      // A Stage I task that was given to another annotator is not found by the one who had it.
      this.status = "lost";
    } else if (sessionEnded(error)) {
      this.status = "offline";
    } else {
      this.status = "refused";
      this.refused = error;
    }
  }
}
