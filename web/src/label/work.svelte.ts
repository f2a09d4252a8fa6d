// One task on the table: what was fetched of it, who holds it, the label in the making, and the moment that is shown. Every
// part of the labelling screen reads from here. Draws nothing and listens to no key.
import { ApiError, Offline } from "../api/client.ts";
import { api } from "../api/calls.ts";
import type { ActionName, Comment, Finding, SceneView, Task, User } from "../api/types.ts";
import { Attempt } from "../attempt.svelte.ts";
import { buildRoad, type Road } from "../scene/road.ts";
import { Player } from "../scene/player.svelte.ts";
import { within } from "./changes.ts";
import { Draft } from "./draft.svelte.ts";
import { loadNames } from "../names.svelte.ts";
import type { Channel, Framework, Spec } from "./framework.ts";
import { type Json, read, same } from "./pointer.ts";
import { type Clock, clockOf, frameNear, secondOf } from "./times.ts";

/** Heartbeats come at a third of what is left of the lease, so that two may be lost; within these bounds. */
const HEARTBEAT_MS = { least: 5_000, most: 40_000 };
/** Fields of the label that Stage I fills; all others open with Stage II. */
const FIRST_FIELDS = ["/critical_components", "/keyframe"];

/** Fields that the reader must have looked at when a draft filled them in. */
const DRAFTED = ["/driving_decision/longitudinal", "/driving_decision/lateral", "/causes/longitudinal", "/causes/lateral", "/coc_trace"];

export type KeyframeName = "keyframe" | "second_keyframe";

export class Work {
  task = $state.raw<Task | null>(null);
  scene = $state.raw<SceneView | null>(null);
  road = $state.raw<Road | null>(null);
  framework = $state.raw<Framework | null>(null);
  clock = $state.raw<Clock | null>(null);
  /** The label as it was before anybody changed it; null while it cannot be told. */
  origin = $state.raw<Json | null>(null);
  comments = $state.raw<readonly Comment[]>([]);
  /** Another task of the reader's that has to be finished first. */
  blocker = $state<string | null>(null);
  /** Why the label was sent back the last time, and by whom; null when it was not. */
  returned = $state.raw<{ by: string; why: string } | null>(null);
  /** Track id of the object that is picked in the view. */
  picked = $state<string | null>(null);
  /** What was just done, for a screen reader: undo may change what is out of sight. */
  said = $state("");
  /** Component that evidence and objects go to. */
  current = $state(0);
  readonly id: string;
  readonly draft: Draft;
  readonly player = new Player();
  readonly attempt = new Attempt();

  /** World point that drawing is relative to. */
  origin2d: readonly [number, number] = [0, 0];
  #fence: number | null = null;
  #closed = false;
  #beat: ReturnType<typeof setInterval> | undefined;

  constructor(id: string, user: User) {
    this.id = id;
    this.draft = new Draft(user.id);
  }

  spec = $derived((this.task as { spec?: Spec | null } | null)?.spec ?? null);
  stage = $derived(this.task?.stage ?? "stage1");
  state = $derived(this.task?.task.state ?? "open");
  leaf = $derived(this.framework?.leaves.get(this.task?.task.scenario_id ?? "") ?? null);
  /** Nobody works on it, and somebody has to. */
  waits = $derived.by(() => ["open", "stage1_locked", "submitted", "rework", "checked"].includes(this.state));
  holds = $derived.by(() => this.task?.fence != null && this.draft.saving !== "lost");
  edits = $derived(this.holds && this.may("edit"));
  checks = $derived(this.holds && (this.may("accept") || this.may("send_back")));
  /** The rule, a model or an import filled the label in before the reader did. */
  drafted = $derived.by(() => this.origin !== null && this.state !== "rework");
  /** Drafted fields that the reader has found good as they are. */
  accepted = $state.raw<ReadonlySet<string>>(new Set());
  /** The reader has said that what is driven is legal and safe. */
  safe = $state(false);
  components = $derived.by(() => {
    const list = this.draft.at("/critical_components");
    return Array.isArray(list) ? list.map((c) => c as Record<string, Json>) : [];
  });
  linked = $derived(new Set(this.components.flatMap((c) => (Array.isArray(c["linked_objects"]) ? c["linked_objects"].map(String) : []))));
  target = $derived(this.task?.suggestion.target_id ?? null);

  may(what: string): boolean {
    return this.task?.permissions.includes(what) ?? false;
  }

  /** May the reader change the field at `path` now? Stage I fills its own fields, Stage II leaves the components alone. */
  open(path: string): boolean {
    if (!this.edits) return false;
    const first = FIRST_FIELDS.some((f) => within(path, f));
    if (this.stage === "stage1") return first;
    return this.state === "rework" || !within(path, "/critical_components");
  }

  /** Fields that a draft filled in and that the reader has neither changed nor found good. */
  unaccepted = $derived.by(() =>
    this.drafted && this.stage === "stage2"
      ? DRAFTED.filter((p) => {
          const before = this.was(p);
          const filled = before !== undefined && before !== null && before !== "";
          return filled && same(before, this.draft.at(p)) && !this.accepted.has(p) && !this.mustRewrite(p);
        })
      : [],
  );

  /** The checker wants these words written anew: a draft that cannot be taken as it is. */
  mustRewrite(path: string): boolean {
    return this.findingsAt(path).some((f) => f.code === "label.trace.draft");
  }

  /** Finds the field at `path` good as it is; also while it is not known yet what the draft filled in. */
  accept(path: string): void {
    if (this.mustRewrite(path)) return;
    this.accepted = new Set([...this.accepted, path]);
    localStorage.setItem(this.#key("accepted"), JSON.stringify([...this.accepted]));
  }

  setSafe(safe: boolean): void {
    this.safe = safe;
    if (safe) localStorage.setItem(this.#key("safe"), "yes");
    else localStorage.removeItem(this.#key("safe"));
  }

  /** What this browser remembers of the work on this task, beside the draft. */
  #key(what: string): string {
    return `whyroad.${what}.${this.id}`;
  }

  #remember(): void {
    this.safe = localStorage.getItem(this.#key("safe")) !== null;
    try {
      const paths: unknown = JSON.parse(localStorage.getItem(this.#key("accepted")) ?? "[]");
      if (Array.isArray(paths)) this.accepted = new Set(paths.map(String));
    } catch {
      // Written by an older page: nothing is accepted yet.
    }
  }

  /** Forgets what was only of use until the label was handed in. */
  #forget(): void {
    for (const what of ["safe", "accepted"]) localStorage.removeItem(this.#key(what));
  }

  findingsAt(path: string): readonly Finding[] {
    return this.draft.findings.filter((f) => within(f.pointer, path));
  }

  commentsAt(path: string): readonly Comment[] {
    return this.comments.filter((c) => c.path !== "" && within(c.path, path));
  }

  /** Fetches everything; on a second call only what a change of stage can change. */
  async load(): Promise<void> {
    await this.attempt.run(async () => {
      const [task, framework] = await Promise.all([api.task(this.id), loadNames()]);
      this.framework = framework;
      this.#remember();
      await this.show(task);
    });
  }

  async show(task: Task): Promise<void> {
    const shown = this.task;
    this.#fence = task.fence ?? null;
    this.task = task;
    this.comments = task.comments;
    this.draft.load(task);
    this.#keepLease();
    if (task.stage === "stage2" && this.origin === null) void this.#beginning();
    if (!this.scene) await this.#look();
    else if (shown?.stage !== task.stage) await this.#lookUntilThere();
    this.returned = null;
    if (["rework", "submitted", "in_check"].includes(task.task.state)) void this.#whyReturned();
  }

  async #look(): Promise<void> {
    const [scene, map] = await Promise.all([api.scene(this.id), api.map(this.id)]);
    const i = scene.keyframe_index;
    this.origin2d = [scene.ego?.x[i] ?? map.lanes[0]?.centre[0]?.[0] ?? 0, scene.ego?.y[i] ?? map.lanes[0]?.centre[0]?.[1] ?? 0];
    this.clock = clockOf(scene);
    this.scene = scene;
    this.road = buildRoad(map, this.origin2d);
    this.player.load(scene.t_s);
  }

  /** The stage is locked and cannot be locked again: what it opened is asked for until it comes. */
  async #lookUntilThere(): Promise<void> {
    for (let wait = 1_000; !this.#closed; wait = Math.min(10_000, wait * 2)) {
      try {
        return await this.#look();
      } catch (error) {
        if (!(error instanceof Offline)) throw error;
        await new Promise((done) => setTimeout(done, wait));
      }
    }
  }

  async #beginning(): Promise<void> {
    try {
      this.origin = (await api.draftAt(this.id, 1)) as Json;
    } catch {
      // Told only to those who may read the history: without it no field shows what it was.
    }
  }

  /** The reason stands in the history: remarks on fields may say more, but need not. */
  async #whyReturned(): Promise<void> {
    try {
      const last = (await api.history(this.id)).findLast((e) => e.action === "send_back");
      if (last) this.returned = { by: last.actor, why: last.comment ?? "" };
    } catch {
      // Told only to those who may read the history.
    }
  }

  async take(): Promise<void> {
    await this.attempt.run(async () => {
      await api.lease(this.id, "take");
      await this.load();
    });
  }

  async release(): Promise<boolean> {
    if (this.#fence === null || !(await this.draft.flush())) return false;
    const fence = this.#fence;
    return (await this.attempt.run(() => api.lease(this.id, "release", fence))) !== undefined;
  }

  /** Saves what is open, then acts. False when something stood in the way; then `attempt` or the draft says what. */
  async act(action: ActionName, reason?: string): Promise<boolean> {
    if (this.holds && !(await this.draft.flush())) return false;
    const done = await this.attempt.run(async () => {
      try {
        const task = await api.act(this.id, { fence: this.#fence, action, reason: reason ?? null });
        if (action === "submit") this.#forget();
        await this.show(task);
        return true;
      } catch (error) {
        const found = error instanceof ApiError ? error.more["findings"] : undefined;
        const blocker = error instanceof ApiError ? error.more["task"] : undefined;
        this.blocker = typeof blocker === "string" ? blocker : null;
        if (Array.isArray(found)) this.draft.findings = found as Finding[];
        throw error;
      }
    });
    return done === true;
  }

  /** Puts an earlier draft back, for those who may. */
  async restore(seq: number): Promise<boolean> {
    const done = await this.attempt.run(async () => {
      await this.show(await api.act(this.id, { fence: this.#fence, action: "restore", seq }));
      return true;
    });
    return done === true;
  }

  async comment(path: string, text: string): Promise<boolean> {
    const made = await this.attempt.run(() => api.comment(this.id, { path, text }));
    if (made) this.comments = [...this.comments, made];
    return made !== undefined;
  }

  async resolve(id: string): Promise<void> {
    const now = await this.attempt.run(() => api.resolve(id));
    if (now) this.comments = this.comments.map((c) => (c.id === id ? now : c));
  }

  #keepLease(): void {
    clearInterval(this.#beat);
    if (this.#fence === null) return;
    const left = Number(this.task?.lease_until ?? 0) - Date.now();
    const every = Math.min(HEARTBEAT_MS.most, Math.max(HEARTBEAT_MS.least, left / 3));
    this.#beat = setInterval(() => void this.#heartbeat(), every);
  }

  async #heartbeat(): Promise<void> {
    if (this.#fence === null) return;
    try {
      await api.lease(this.id, "heartbeat", this.#fence);
    } catch (error) {
      // Offline is no loss yet: the next heartbeat or save tells.
      if (error instanceof ApiError && error.code.startsWith("lease.")) {
        clearInterval(this.#beat);
        this.draft.lose();
      }
    }
  }

  close(): void {
    this.#closed = true;
    clearInterval(this.#beat);
    this.player.pause();
    // What was typed just before one goes elsewhere is sent without its pause.
    void this.draft.flush().finally(() => this.draft.close());
  }

  // What the keyboard and the pointer both do.

  second(iso: unknown): number | null {
    return this.clock ? secondOf(this.clock, iso) : null;
  }

  /** The frame shown now. */
  get frame(): number {
    return this.clock ? frameNear(this.clock, this.player.now) : 0;
  }

  /** `undefined` is not chosen, null is no change. */
  decision(channel: Channel): string | null | undefined {
    const v = this.draft.at(`/driving_decision/${channel}`);
    return typeof v === "string" || v === null ? v : undefined;
  }

  /** What the field at `path` was at first, where that differs from what it is. */
  was(path: string): Json | undefined {
    return this.origin === null ? undefined : read(this.origin, path);
  }
}
