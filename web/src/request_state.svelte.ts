// A request that a screen makes: whether it is running, and what went wrong in the reader's language.
import { ApiError, Offline } from "./api/client.ts";
import { sessionEnded } from "./session.svelte.ts";
import { lang, t } from "./text/text.svelte.ts";

export class RequestState {
  busy = $state(false);
  #error = $state.raw<unknown>(null);

  /** The error in the current language; null without one. */
  get problem(): string | null {
    const error = this.#error;
    if (error === null) return null;
    if (error instanceof ApiError) return lang.now === "zh" ? error.zh : error.en;
    if (error instanceof Offline) return t("app.offline");
    // The browser's own message for a chosen file that has changed since is not in the page's language.
    if (error instanceof DOMException && error.name === "NotReadableError") return t("app.file_changed");
    return error instanceof Error ? error.message : String(error);
  }

  /** The stable code of a refusal by the service; empty otherwise. */
  get code(): string {
    return this.#error instanceof ApiError ? this.#error.code : "";
  }

  /** Another task of the reader that has to be finished first; null where that is not why. */
  get blockingTask(): string | null {
    const task = this.#error instanceof ApiError && this.code === "task.stage1_first" ? this.#error.more["task"] : null;
    return typeof task === "string" ? task : null;
  }

  /** Shows an error found in the page itself. */
  fail(text: string): void {
    this.#error = text;
  }

  /** Shows an error that was caught elsewhere. */
  setError(error: unknown): void {
    this.#error = error;
  }

  /** Removes the error. */
  clear(): void {
    this.#error = null;
  }

  /** Runs `work`; undefined when it failed. When the session has ended, the sign-in is shown. */
  async run<T>(work: () => Promise<T>): Promise<T | undefined> {
    this.busy = true;
    this.#error = null;
    try {
      return await work();
    } catch (error) {
      if (!sessionEnded(error)) this.#error = error;
      return undefined;
    } finally {
      this.busy = false;
    }
  }
}
