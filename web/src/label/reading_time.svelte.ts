// How long a label has been on screen: a checker can accept it only after that. A hidden page does not count.

/** Time that a label has to be on screen before it can be accepted, ms: fewer than a person needs to read one. */
export const READING_MS = 3_000;
const STEP_MS = 250;

export class ReadingTime {
  #shownMs = $state(0);
  #timer: ReturnType<typeof setInterval> | undefined;

  /** The label was on screen long enough to be accepted. */
  get isEnough(): boolean {
    return this.#shownMs >= READING_MS;
  }

  /** The label is on screen from now on. */
  begin(): void {
    if (this.#timer !== undefined || this.isEnough) return;
    this.#timer = setInterval(() => {
      if (document.visibilityState === "hidden") return;
      this.#shownMs += STEP_MS;
      if (this.isEnough) this.pause();
    }, STEP_MS);
  }

  /** The label is no longer on screen; what was counted stays. */
  pause(): void {
    clearInterval(this.#timer);
    this.#timer = undefined;
  }
}
