// The label in the making: what is shown, undo and redo, and the way of each change to the server. Every change is on this
// machine before it is sent and leaves here only when the server has acknowledged it.
import { ApiError, Offline } from "../api/client.ts";
import { api } from "../api/calls.ts";
import type { Conflicts, FieldConflict, Finding, Task } from "../api/types.ts";
import { apply, type Change, join, needed, rooted, type Step, within } from "./changes.ts";
import { keep, kept } from "./local.ts";
import { type Json, read, same } from "./pointer.ts";

export type Saving = "saved" | "saving" | "waiting" | "offline" | "lost" | "refused";

/** Typing rests this long before it is sent; everything else is a pause of the same length at most. */
const REST_MS = 350;
/** Steps of one field within this time are undone together. */
const TOGETHER_MS = 900;

export class Draft {
  doc = $state.raw<Json>({});
  findings = $state.raw<readonly Finding[]>([]);
  saving = $state<Saving>("saved");
  unsaved = $state(0);
  conflicts = $state.raw<readonly FieldConflict[]>([]);
  /** What to tell: fields that others changed meanwhile, changes that were found again. */
  notice = $state.raw<{ kind: "merged"; fields: string[] } | { kind: "restored" } | null>(null);
  refused = $state.raw<ApiError | null>(null);
  canUndo = $state(false);
  canRedo = $state(false);

  #user: string;
  #task = "";
  #fence: number | null = null;
  #version = 0;
  #pending: Change[] = [];
  #sending: Change[] = [];
  #timer: ReturnType<typeof setTimeout> | undefined;
  #retryMs = 500;
  #running: Promise<void> | null = null;
  /** What one press of undo takes back: the steps of one deed, first to last. */
  #done: Step[][] = [];
  #undone: Step[][] = [];
  #deed: Step[] | null = null;
  #lastAt = 0;
  #state = "";
  #channel: BroadcastChannel | null = null;

  constructor(user: string) {
    this.#user = user;
  }

  /** Shows `task`. Changes that an earlier visit could not save go on top and are sent. */
  load(task: Task): void {
    // A new stage freezes fields: what was done before it cannot be taken back.
    const fresh = task.task.id !== this.#task || task.task.state !== this.#state;
    this.#state = task.task.state;
    this.#task = task.task.id;
    this.#fence = task.fence ?? null;
    this.#version = task.version;
    this.findings = task.findings;
    this.saving = "saved";
    this.refused = null;
    this.conflicts = [];
    if (fresh) {
      this.#done = [];
      this.#undone = [];
      this.#steps();
      this.#listen();
    }
    const left = this.#fence === null ? null : kept(this.#user, this.#task);
    const changes = left ? needed(task.draft as Json, left.changes) : [];
    this.#sending = [];
    this.#pending = changes;
    this.doc = apply(task.draft as Json, changes);
    if (left && changes.length > 0) {
      this.#version = left.base;
      this.notice = { kind: "restored" };
      this.#keep();
      this.#soon(0);
    } else {
      if (this.#fence !== null) keep(this.#user, this.#task, { base: 0, changes: [] });
      this.#keep();
    }
  }

  at(path: string): Json | undefined {
    return read(this.doc, path);
  }

  text(path: string): string {
    const v = this.at(path);
    return typeof v === "string" ? v : "";
  }

  /** Sets the field at `path`; `undefined` takes it away. */
  set(path: string, value: Json | undefined): void {
    const change = rooted(this.doc, { path, value });
    const before = this.at(change.path);
    if (same(before, change.value)) return;
    const step: Step = { ...change, before };
    const now = performance.now();
    const top = this.#done.at(-1);
    const last = top?.at(-1);
    if (this.#deed) this.#deed.push(step);
    else if (top?.length === 1 && last && last.path === change.path && typeof change.value === "string" && now - this.#lastAt < TOGETHER_MS) {
      last.value = change.value;
    } else this.#done.push([step]);
    this.#lastAt = now;
    this.#undone = [];
    this.#write(change);
  }

  /** Everything that `deed` sets is undone together. */
  together(deed: () => void): void {
    if (this.#deed) return deed();
    const steps: Step[] = [];
    this.#deed = steps;
    try {
      deed();
    } finally {
      this.#deed = null;
    }
    if (steps.length > 0) this.#done.push(steps);
    this.#lastAt = 0;
    this.#steps();
  }

  /** Takes the last deed back; the field that changed, null when there is nothing to take back. */
  undo(): string | null {
    const steps = this.#done.pop();
    if (!steps) return null;
    this.#undone.push(steps);
    this.#lastAt = 0;
    for (const step of [...steps].reverse()) this.#write({ path: step.path, value: step.before });
    return steps[0]?.path ?? null;
  }

  redo(): string | null {
    const steps = this.#undone.pop();
    if (!steps) return null;
    this.#done.push(steps);
    for (const step of steps) this.#write({ path: step.path, value: step.value });
    return steps[0]?.path ?? null;
  }

  /** The lease is gone: nothing is sent any more, what was not sent stays on this machine. */
  lose(): void {
    clearTimeout(this.#timer);
    this.saving = "lost";
  }

  /** Sends what is there, and ends when all of it is acknowledged or cannot be sent. */
  async flush(): Promise<boolean> {
    clearTimeout(this.#timer);
    while (this.#pending.length > 0 || this.#running) {
      if (this.#fence === null || this.saving === "lost" || this.saving === "refused") return false;
      const before = this.saving;
      await (this.#running ?? this.#send());
      if (this.saving !== "saved" && this.saving !== "saving" && this.saving !== "waiting") return false;
      if (this.conflicts.length > 0 || (before === "offline" && this.saving === "waiting")) return false;
    }
    return true;
  }

  /** Settles a conflict: mine is sent again on top of theirs, theirs is taken over. */
  settle(path: string, side: "mine" | "theirs"): void {
    const conflict = this.conflicts.find((c) => c.path === path);
    if (!conflict) return;
    this.conflicts = this.conflicts.filter((c) => c !== conflict);
    if (side === "theirs") {
      this.#pending = this.#pending.filter((c) => !within(c.path, path));
      this.doc = apply(this.doc, [{ path, value: (conflict.theirs ?? null) as Json }]);
    }
    this.#keep();
    if (this.conflicts.length === 0) this.#soon(0);
  }

  /** Throws away what was not saved: the reader says so. */
  drop(): void {
    clearTimeout(this.#timer);
    this.#pending = [];
    this.#sending = [];
    this.conflicts = [];
    this.refused = null;
    this.#keep();
  }

  close(): void {
    clearTimeout(this.#timer);
    this.leave();
    this.#channel?.close();
    this.#channel = null;
  }

  #write(change: Change): void {
    this.doc = apply(this.doc, [change]);
    this.#pending = join(this.#pending, change);
    this.#steps();
    this.#keep();
    // What was refused may be right now.
    if (this.saving === "saved" || this.saving === "refused") this.saving = "waiting";
    this.#soon(REST_MS);
  }

  #steps(): void {
    this.canUndo = this.#done.length > 0;
    this.canRedo = this.#undone.length > 0;
  }

  #keep(): void {
    const all = [...this.#sending, ...this.#pending];
    this.unsaved = all.length;
    if (this.#fence !== null) keep(this.#user, this.#task, { base: this.#version, changes: all });
  }

  #soon(ms: number): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#send(), ms);
  }

  #send(): Promise<void> {
    if (this.#running) return this.#running;
    this.#running = this.#sendOnce().finally(() => {
      this.#running = null;
      if (this.#pending.length > 0 && this.conflicts.length === 0 && this.saving !== "lost" && this.saving !== "refused") {
        this.#soon(this.saving === "offline" ? this.#retryMs : 0);
      }
    });
    return this.#running;
  }

  async #sendOnce(): Promise<void> {
    if (this.#pending.length === 0 || this.#fence === null || this.conflicts.length > 0 || this.saving === "lost") return;
    this.#sending = this.#pending.slice(0, 100);
    this.#pending = this.#pending.slice(100);
    if (this.saving !== "offline") this.saving = "saving";
    const task = this.#task;
    const wire = this.#sending.map((c) =>
      c.value === undefined ? { path: c.path, value: null, remove: true } : { path: c.path, value: c.value },
    );
    try {
      const reply = await api.save(task, this.#fence, this.#version, wire);
      if (task !== this.#task) return;
      this.#sending = [];
      this.#version = reply.version;
      this.#retryMs = 500;
      this.saving = this.#pending.length > 0 ? "waiting" : "saved";
      this.findings = reply.findings;
      if (reply.merged !== undefined && reply.merged !== null) {
        const fields = this.#take(reply.merged as Json);
        if (fields.length > 0) this.notice = { kind: "merged", fields };
      }
      this.#keep();
      this.#channel?.postMessage({ saved: reply.version });
    } catch (e) {
      if (task !== this.#task) return;
      this.#pending = this.#sending.concat(this.#pending).reduce<Change[]>(join, []);
      this.#sending = [];
      this.#failed(e);
      this.#keep();
    }
  }

  #failed(e: unknown): void {
    if (e instanceof Offline || (e instanceof ApiError && (e.status >= 500 || e.status === 429))) {
      this.saving = "offline";
      this.#retryMs = Math.min(10_000, this.#retryMs * 1.6);
    } else if (e instanceof ApiError && e.code === "draft.conflict") {
      const found = e.body["more"] as Conflicts;
      this.#version = found.version;
      // What both sides changed to the same is none: such is the answer to a change that arrived although its reply did not.
      this.conflicts = found.conflicts.filter((c) => !same(c.mine as Json, c.theirs as Json));
      this.#pending = needed(found.draft as Json, this.#pending);
      this.doc = apply(found.draft as Json, this.#pending);
      this.saving = "waiting";
    } else if (e instanceof ApiError && (e.code === "lease.lost" || e.code === "lease.not_yours" || e.status === 404)) {
      // A task in Stage I that somebody else took is no longer there for who had it.
      this.saving = "lost";
    } else if (e instanceof ApiError) {
      this.saving = "refused";
      this.refused = e;
    } else throw e;
  }

  /** Another's draft comes in under what is not sent yet; the fields that it changed here. */
  #take(draft: Json): string[] {
    const next = apply(draft, this.#pending);
    const fields = new Set<string>();
    const old = this.doc as Record<string, Json>;
    const now = next as Record<string, Json>;
    for (const key of new Set([...Object.keys(old), ...Object.keys(now)])) if (!same(old[key], now[key])) fields.add(key);
    this.doc = next;
    return [...fields];
  }

  /** The same task in another tab of this browser: what it saves is fetched here, so that both show one draft. */
  #listen(): void {
    this.#channel?.close();
    this.#channel = new BroadcastChannel(`whyroad.task.${this.#task}`);
    this.#channel.onmessage = (e: MessageEvent<{ saved?: number; hello?: boolean; bye?: boolean }>) => {
      this.otherTab = !e.data.bye;
      if (e.data.hello) this.#channel?.postMessage({});
      if (e.data.saved && e.data.saved > this.#version && this.#pending.length === 0 && !this.#running) void this.#refetch();
    };
    this.otherTab = false;
    this.#channel.postMessage({ hello: true });
  }

  /** Tells other tabs that this one no longer shows the task. */
  leave(): void {
    this.#channel?.postMessage({ bye: true });
  }

  otherTab = $state(false);

  async #refetch(): Promise<void> {
    try {
      const task = await api.task(this.#task);
      if (task.version <= this.#version || this.#pending.length > 0) return;
      this.#version = task.version;
      this.findings = task.findings;
      this.#take(task.draft as Json);
    } catch {
      // The next save merges it.
    }
  }
}
