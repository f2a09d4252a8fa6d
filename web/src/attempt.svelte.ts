// Something that a screen tries to do on the server: whether it is under way, and what went wrong in the reader's words.
import { ApiError, Offline } from "./api/client.ts";
import { ended } from "./session.svelte.ts";
import { lang, t } from "./text/text.svelte.ts";

export class Attempt {
  busy = $state(false);
  #error = $state.raw<unknown>(null);

  /** What went wrong, in the language spoken now; null when nothing did. */
  get problem(): string | null {
    const error = this.#error;
    if (error === null) return null;
    if (error instanceof ApiError) return lang.now === "zh" ? error.zh : error.en;
    if (error instanceof Offline) return t("app.offline");
    // What a browser says of a chosen file that has changed on the disk since, in its own language.
    if (error instanceof DOMException && error.name === "NotReadableError") return t("app.file_changed");
    return error instanceof Error ? error.message : String(error);
  }

  /** The stable code of a refusal, for what a screen explains itself. */
  get code(): string {
    return this.#error instanceof ApiError ? this.#error.code : "";
  }

  /** Says what went wrong without the server. */
  refuse(text: string): void {
    this.#error = text;
  }

  /** Takes over what went wrong elsewhere: before this screen was there. */
  takeOver(error: unknown): void {
    this.#error = error;
  }

  /** Forgets what went wrong. */
  clear(): void {
    this.#error = null;
  }

  /** Runs `work`; undefined when it failed. A session that ended goes back to the door. */
  async run<T>(work: () => Promise<T>): Promise<T | undefined> {
    this.busy = true;
    this.#error = null;
    try {
      return await work();
    } catch (error) {
      if (!ended(error)) this.#error = error;
      return undefined;
    } finally {
      this.busy = false;
    }
  }
}
