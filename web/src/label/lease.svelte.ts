// The lease on one task: the fence token that every write carries, and the heartbeats that keep it.
import * as api from "../api/calls.generated.ts";
import { ApiError } from "../api/client.ts";

/** Heartbeats come at a third of what is left of the lease, so that two may be lost; within these bounds. */
const HEARTBEAT_MS = { min: 5_000, max: 40_000 };

export class Lease {
  /** The token of the lease; null without one. */
  fence = $state<number | null>(null);
  #task: string;
  #lost: () => void;
  #timer: ReturnType<typeof setInterval> | undefined;

  /** `lost` is called when the service reports that the lease has ended. */
  constructor(task: string, lost: () => void) {
    this.#task = task;
    this.#lost = lost;
  }

  /** Keeps the lease with this token until `untilMs` (ms since 1970) and beyond; null: no lease. */
  keep(fence: number | null, untilMs: number): void {
    this.stop();
    this.fence = fence;
    if (fence === null) return;
    const interval = Math.min(HEARTBEAT_MS.max, Math.max(HEARTBEAT_MS.min, (untilMs - Date.now()) / 3));
    this.#timer = setInterval(() => void this.#heartbeat(fence), interval);
  }

  async take(): Promise<void> {
    await api.postTaskLease(this.#task, { action: "take", fence: null });
  }

  async release(): Promise<void> {
    if (this.fence !== null) await api.postTaskLease(this.#task, { action: "release", fence: this.fence });
  }

  /** Ends the heartbeats. */
  stop(): void {
    clearInterval(this.#timer);
  }

  async #heartbeat(fence: number): Promise<void> {
    try {
      await api.postTaskLease(this.#task, { action: "heartbeat", fence });
    } catch (error) {
      // Being offline does not end a lease: the next heartbeat or save shows whether it has ended.
      if (!(error instanceof ApiError) || !error.code.startsWith("lease.")) return;
      this.stop();
      this.#lost();
    }
  }
}
