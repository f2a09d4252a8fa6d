// One task on the labeling screen: the task, its label, its clip and the moment shown. Every part of the screen reads
// from here. Draws nothing and handles no key.
import * as api from "../api/calls.generated.ts";
import { ApiError } from "../api/client.ts";
import type { ActionName, Finding, MinedEpisode, SafetyReason, Task, User } from "../api/types.ts";
import { loadFramework } from "../class_names.svelte.ts";
import { RequestState } from "../request_state.svelte.ts";
import { egoPose } from "../scene/motion.ts";
import type { Player } from "../scene/player.svelte.ts";
import { Ruler } from "../scene/ruler.svelte.ts";
import { SceneCamera } from "../scene/scene_camera.svelte.ts";
import { within } from "./changes.ts";
import { ClipData } from "./clip_data.svelte.ts";
import { CommentList } from "./comment_list.svelte.ts";
import { Draft } from "./draft.svelte.ts";
import { AFTER_SAFETY, DRAFTED_FIELDS, isFilled, pointers, STAGE_ONE_FIELDS } from "./field_pointers.ts";
import type { Channel, Framework, Spec } from "./framework.ts";
import { Lease } from "./lease.svelte.ts";
import { type Json, read, same } from "./pointer.ts";
import { ReviewMarks } from "./review_marks.svelte.ts";
import { keepsDraft } from "./trace_slots.ts";

/** States in which nobody holds the task and somebody has to take it. */
const WAITING_STATES = ["open", "stage1_locked", "submitted", "rework", "checked"];

export class TaskEditor {
  task = $state.raw<Task | null>(null);
  framework = $state.raw<Framework | null>(null);
  /** The label before anybody changed it; null while it is unknown. */
  initial = $state.raw<Json | null>(null);
  /** Track id of the object that is selected in the view. */
  selected = $state<string | null>(null);
  /** What was just done, for screen readers: undo may change what is out of sight. */
  announcement = $state("");
  /** A question to the lead is being written. */
  asking = $state(false);
  /** Number of the component that evidence and objects go to. */
  currentComponent = $state(0);
  readonly id: string;
  readonly draft: Draft;
  readonly clip: ClipData;
  readonly review: ReviewMarks;
  readonly comments: CommentList;
  readonly request = new RequestState();
  readonly camera = new SceneCamera(() => egoPose(this.clip.scene?.ego, this.player.index, this.player.share));
  readonly ruler = new Ruler();
  #lease: Lease;

  constructor(id: string, user: User) {
    this.id = id;
    this.draft = new Draft(user.id);
    this.clip = new ClipData(id);
    this.review = new ReviewMarks(id);
    this.comments = new CommentList(id, this.request);
    this.#lease = new Lease(id, () => this.draft.queue.stop());
  }

  spec = $derived((this.task as { spec?: Spec | null } | null)?.spec ?? null);
  stage = $derived(this.task?.stage ?? "stage1");
  state = $derived(this.task?.task.state ?? "open");
  leaf = $derived.by(() => {
    const id = this.task?.task.scenario_id ?? "";
    return this.framework?.leaves.get(id) ?? this.framework?.groups.get(id) ?? null;
  });
  /** The safety filter was answered: the driving is legal and safe. */
  safe = $derived.by(() => this.draft.at(pointers.safetyAnswer) === "safe");
  /** Only the L2 is shown, and no specification comes with it: the L3, if there is one, is withheld. */
  hidesLeaf = $derived.by(() => this.stage === "stage1" && this.task?.task.scenario_id.split(".").length === 2 && !this.spec);
  target = $derived(this.task?.suggestion.target_id ?? null);
  isWaiting = $derived.by(() => WAITING_STATES.includes(this.state));
  holdsLease = $derived.by(() => this.task?.fence != null && this.draft.queue.status !== "lost");
  canEdit = $derived(this.holdsLease && this.can("edit"));
  canCheck = $derived(this.holdsLease && (this.can("accept") || this.can("send_back")));
  /** A rule, a model or an import filled the label in before the reader did. */
  drafted = $derived.by(() => this.initial !== null && this.state !== "rework");
  components = $derived.by(() => {
    const list = this.draft.at(pointers.components);
    return Array.isArray(list) ? list.map((c) => c as Record<string, Json>) : [];
  });
  /** Track ids that components are linked to. */
  linkedObjects = $derived(
    new Set(this.components.flatMap((c) => (Array.isArray(c["linked_objects"]) ? c["linked_objects"].map(String) : []))),
  );
  /** Drafted fields that the annotator has neither changed nor accepted. */
  unaccepted = $derived.by(() =>
    this.drafted && this.stage === "stage2" ? DRAFTED_FIELDS.filter((path) => this.isUnaccepted(path)) : [],
  );

  /** Shows the moment of the label's keyframe, which an annotator may have moved. */
  seekKeyframe(): void {
    this.player.seek(this.second(this.draft.at(pointers.keyframeTime("keyframe"))) ?? 0);
  }

  get player(): Player {
    return this.clip.player;
  }

  /** The frame shown now. */
  get frame(): number {
    return this.clip.frameNear(this.player.now);
  }

  /** May the reader do this with the task now? */
  can(action: string): boolean {
    return this.task?.permissions.includes(action) ?? false;
  }

  /**
   * May the reader change the field at `path` now? Stage I fills its own fields, Stage II cannot change components, and
   * decisions, causes and trace wait for the safety filter.
   */
  isEditable(path: string): boolean {
    if (!this.canEdit) return false;
    if (this.stage === "stage1") return STAGE_ONE_FIELDS.some((field) => within(path, field));
    if (!this.safe && AFTER_SAFETY.some((field) => within(path, field))) return false;
    if (this.can("uncertainty") && /\/uncertainty$/.test(path)) return true;
    return this.state === "rework" || !within(path, pointers.components);
  }

  second(iso: unknown): number | null {
    return this.clip.second(iso);
  }

  trackName(id: string): string {
    return this.clip.trackName(id);
  }

  /** The decision of a channel: null is "no change", undefined is "not chosen". */
  decision(channel: Channel): string | null | undefined {
    const value = this.draft.at(pointers.decisionOf(channel));
    return typeof value === "string" || value === null ? value : undefined;
  }

  /** The field at `path` in the label as it was drafted; undefined while that is unknown. */
  initialAt(path: string): Json | undefined {
    return this.initial === null ? undefined : read(this.initial, path);
  }

  findingsAt(path: string): readonly Finding[] {
    return this.draft.findings.filter((f) => within(f.pointer, path));
  }

  /** What a draft said in the field at `path`; undefined where nobody said anything, or that is unknown. */
  draftedAt(path: string): Json | undefined {
    const before = this.initialAt(path);
    return before === null && this.#isUndrafted() ? undefined : before;
  }

  /** Nothing was drafted: the label's nulls are no "no change" of anybody. */
  #isUndrafted(): boolean {
    return this.initial !== null && (this.initialAt(pointers.trace) ?? "") === "";
  }

  /** The validator rejects the drafted value: it cannot be accepted unchanged. */
  mustRewrite(path: string): boolean {
    return this.findingsAt(path).some((f) => f.severity === "error");
  }

  /** Nothing was drafted, and the decision at `path` is still to be chosen. */
  isUnchosen(path: string): boolean {
    return this.#isUndrafted() && this.initialAt(path) === null && this.unaccepted.includes(path);
  }

  /** Accepts the drafted field at `path` as it is. */
  accept(path: string): void {
    if (!this.mustRewrite(path)) this.review.accept(path);
  }

  /** The reader chose the value of the field at `path`, also one that the validator rejects. */
  chose(path: string): void {
    if (this.isUnchosen(path)) this.review.accept(path);
    else this.accept(path);
  }

  /** Loads everything; on a second call only what a change of stage can change. */
  async load(): Promise<void> {
    await this.request.run(async () => {
      const [task, framework] = await Promise.all([api.getTask(this.id), loadFramework()]);
      this.framework = framework;
      this.review.load();
      await this.show(task);
    });
  }

  async show(task: Task): Promise<void> {
    const shown = this.task;
    this.task = task;
    this.comments.show(task);
    this.draft.load(task);
    this.#lease.keep(task.fence ?? null, Number(task.lease_until ?? 0));
    if (task.stage === "stage2" && this.initial === null) void this.#loadInitial();
    if (!this.clip.scene) {
      await this.clip.load();
      this.seekKeyframe();
    } else if (shown?.stage !== task.stage) await this.clip.loadUntilReached();
  }

  /** Shows a mined episode, which nobody holds and nothing can be done with. */
  showMined(shown: MinedEpisode): void {
    this.task = shown.task;
    this.draft.doc = shown.task.draft as Json;
    this.clip.put(shown.scene, shown.map);
  }

  async take(): Promise<void> {
    await this.request.run(async () => {
      await this.#lease.take();
      await this.load();
    });
  }

  async release(): Promise<boolean> {
    if (this.#lease.fence === null || !(await this.draft.flush())) return false;
    return (await this.request.run(async () => (await this.#lease.release(), true))) === true;
  }

  /** Saves what is unsaved, then acts. False when that failed; `request` or the draft then has the reason. */
  async act(action: ActionName, reason?: string, rightClass?: string): Promise<boolean> {
    if (this.holdsLease && !(await this.draft.flush())) return false;
    return this.#post({ fence: this.#lease.fence, action, reason: reason ?? null, ...(rightClass !== undefined && { right_class: rightClass }) });
  }

  /** Records the answer of the safety filter; an unsafe one rejects the task. */
  async answerSafety(answer: "safe" | "unsafe", reasons: readonly SafetyReason[] = [], note: string | null = null): Promise<boolean> {
    const fence = this.#lease.fence;
    if (fence === null || !(await this.draft.flush())) return false;
    return (
      (await this.request.run(async () => {
        await this.show(await api.postTaskSafety(this.id, { fence, answer, reasons: [...reasons], note }));
        return true;
      })) === true
    );
  }

  /** Records the checker's answers to the questions that a model answered; the model's are then shown. */
  async answerJudge(answers: Record<string, boolean>): Promise<void> {
    const fence = this.#lease.fence;
    if (fence === null) return;
    await this.request.run(async () => this.show(await api.postTaskJudgement(this.id, { fence, answers })));
  }

  /** Restores the draft of an earlier entry of the history; it can be undone like an edit. */
  async restore(seq: number): Promise<boolean> {
    if (this.holdsLease && !(await this.draft.flush())) return false;
    const before = this.draft.doc;
    const done = await this.#post({ fence: this.#lease.fence, action: "restore", seq });
    if (done) this.draft.replaced(before);
    return done;
  }

  close(): void {
    this.clip.close();
    this.#lease.stop();
    // What was typed just before leaving is sent without the usual pause.
    void this.draft.flush().finally(() => this.draft.close());
  }

  private isUnaccepted(path: string): boolean {
    const before = this.initialAt(path);
    if (before === undefined || !isFilled(path, before)) return false;
    // What nobody said is to be chosen, whatever the validator says of it.
    const canStay = !this.mustRewrite(path) || this.draftedAt(path) === undefined;
    return !this.#isEvident(path) && this.#isAsDrafted(path, before) && !this.review.accepted.has(path) && canStay;
  }

  /** The trace is as drafted while its state and its reason are: its decision follows the choice by itself. */
  #isAsDrafted(path: string, before: Json): boolean {
    if (same(before, this.draft.at(path))) return true;
    return path === pointers.trace && typeof before === "string" && keepsDraft(this.draft.text(path), before);
  }

  /** The only component is linked: nothing was chosen, so nothing needs to be confirmed. */
  #isEvident(path: string): boolean {
    if (this.components.length !== 1) return false;
    return (["longitudinal", "lateral"] as const).some((channel) => {
      const named = path === pointers.causesOf(channel) ? this.draft.at(pointers.causeComponents(channel)) : null;
      return Array.isArray(named) && named.length === 1 && named[0] === this.components[0]?.["id"];
    });
  }

  async #post(action: Parameters<typeof api.postTaskActions>[1]): Promise<boolean> {
    const done = await this.request.run(async () => {
      try {
        const task = await api.postTaskActions(this.id, action);
        if (action.action === "submit") this.review.clearStored();
        // What was said of the stage before is over.
        this.announcement = "";
        this.draft.notice = null;
        await this.show(task);
        return true;
      } catch (error) {
        const more = error instanceof ApiError ? error.more : {};
        if (Array.isArray(more["findings"])) this.draft.findings = more["findings"] as Finding[];
        throw error;
      }
    });
    return done === true;
  }

  async #loadInitial(): Promise<void> {
    try {
      this.initial = (await api.getTaskHistoryBySeq(this.id, 1)).draft as Json;
    } catch {
      // Only those who may read the history see what a field was before.
    }
  }
}
