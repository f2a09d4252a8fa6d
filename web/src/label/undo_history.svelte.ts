// Undo and redo of a draft: which steps one press takes back. Knows neither the draft nor the service.
import type { Change, Step } from "./changes.ts";

/** Text typed into one field with shorter pauses than this is undone as one step. */
const TYPING_PAUSE_MS = 900;

export class UndoHistory {
  canUndo = $state(false);
  canRedo = $state(false);

  /** One entry per press of undo: the steps of one edit, first to last. */
  #done: Step[][] = [];
  #undone: Step[][] = [];
  #group: Step[] | null = null;
  #lastStepAt = 0;

  clear(): void {
    this.#done = [];
    this.#undone = [];
    this.#update();
  }

  /** Adds a step that was just made. A new step ends what could be redone. */
  record(step: Step): void {
    const now = performance.now();
    const top = this.#done.at(-1);
    const last = top?.at(-1);
    const isTyping = typeof step.value === "string" && now - this.#lastStepAt < TYPING_PAUSE_MS;
    if (this.#group) this.#group.push(step);
    else if (top?.length === 1 && last?.path === step.path && isTyping) last.value = step.value;
    else this.#done.push([step]);
    this.#lastStepAt = now;
    this.#undone = [];
    this.#update();
  }

  /** All steps that `edit` records are undone together. */
  group(edit: () => void): void {
    if (this.#group) return edit();
    const steps: Step[] = [];
    this.#group = steps;
    try {
      edit();
    } finally {
      this.#group = null;
    }
    if (steps.length > 0) this.#done.push(steps);
    this.#lastStepAt = 0;
    this.#update();
  }

  /** The changes that take the last edit back, in order; null when there is nothing to undo. */
  undo(): Change[] | null {
    const steps = this.#done.pop();
    if (!steps) return null;
    this.#undone.push(steps);
    this.#lastStepAt = 0;
    this.#update();
    return [...steps].reverse().map((step) => ({ path: step.path, value: step.before }));
  }

  /** The changes that repeat the edit undone last; null without one. */
  redo(): Change[] | null {
    const steps = this.#undone.pop();
    if (!steps) return null;
    this.#done.push(steps);
    this.#update();
    return steps.map((step) => ({ path: step.path, value: step.value }));
  }

  #update(): void {
    this.canUndo = this.#done.length > 0;
    this.canRedo = this.#undone.length > 0;
  }
}
