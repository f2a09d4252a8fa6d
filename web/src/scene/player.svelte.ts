// The clock of the labeling screen: scene, plots, timeline and camera all show its time.

export const RATES = [0.25, 0.5, 1, 2, 4] as const;

export class Player {
  /** Seconds from the suggested keyframe, ascending, one per frame. */
  times = $state.raw<readonly number[]>([]);
  /** Now, s. */
  now = $state(0);
  playing = $state(false);
  rate = $state<number>(1);
  /** Playback loops in `range` instead of stopping at the end. */
  loop = $state(false);
  range = $state.raw<readonly [number, number] | null>(null);

  /** Last frame at or before now. */
  index = $derived(frameAt(this.times, this.now));
  /** Fraction of the time to the next frame. */
  share = $derived.by(() => {
    const a = this.times[this.index];
    const b = this.times[this.index + 1];
    return a === undefined || b === undefined ? 0 : Math.min(1, Math.max(0, (this.now - a) / (b - a)));
  });

  #last = 0;
  #frame = 0;

  get first(): number {
    return this.times[0] ?? 0;
  }

  get end(): number {
    return this.times.at(-1) ?? 0;
  }

  /** Shows `times`, at the current time where it is among them. */
  load(times: readonly number[]): void {
    this.times = times;
    this.seek(this.now);
  }

  seek(t: number): void {
    this.now = Math.min(this.end, Math.max(this.first, t));
  }

  /** Moves by whole frames and stops playback. */
  step(frames: number): void {
    this.pause();
    // Between two frames, one step back goes to the earlier one of them.
    const from = this.share > 1e-6 && frames < 0 ? this.index + 1 : this.index;
    const to = Math.min(this.times.length - 1, Math.max(0, from + frames));
    this.now = this.times[to] ?? 0;
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    if (this.times.length < 2) return;
    if (this.now >= this.end - 1e-9) this.now = this.loop && this.range ? this.range[0] : this.first;
    this.playing = true;
    this.#last = performance.now();
    cancelAnimationFrame(this.#frame);
    this.#frame = requestAnimationFrame(this.#tick);
  }

  pause(): void {
    cancelAnimationFrame(this.#frame);
    if (!this.playing) return;
    this.playing = false;
    this.now = this.times[this.index] ?? this.now;
  }

  faster(steps: number): void {
    const at = RATES.findIndex((r) => r >= this.rate);
    this.rate = RATES[Math.min(RATES.length - 1, Math.max(0, at + steps))] ?? 1;
  }

  #tick = (at: number): void => {
    if (!this.playing) return;
    const next = this.now + (Math.max(0, at - this.#last) / 1000) * this.rate;
    this.#last = at;
    const [from, to] = this.loop && this.range ? this.range : [this.first, this.end];
    if (next < to) this.now = next;
    else if (this.loop) this.now = Math.max(this.first, from);
    else {
      this.now = this.end;
      this.playing = false;
      return;
    }
    this.#frame = requestAnimationFrame(this.#tick);
  };
}

/** Last frame at or before `t`; 0 before the first. */
export function frameAt(times: readonly number[], t: number): number {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const mid = (low + high + 1) >> 1;
    if ((times[mid] ?? 0) <= t + 1e-6) low = mid;
    else high = mid - 1;
  }
  return Math.max(0, low);
}

/** An image older than this does not show the current time, s. */
export const IMAGE_LIFETIME_S = 1;

/** The image of a camera at `t`: its last one at or before, unless that is too old; null without one. */
export function imageAt(times: readonly number[], t: number): number | null {
  const at = frameAt(times, t);
  const age = t - (times[at] ?? Infinity);
  return age >= -1e-6 && age <= IMAGE_LIFETIME_S ? at : null;
}
