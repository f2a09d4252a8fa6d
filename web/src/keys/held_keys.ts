// Keys typed while the service answers, for the field that has the focus afterwards: who knows the way types faster
// than an answer comes. Only single characters without modifiers, and none that a text field or a list gets.

/** Keys beyond these are forgotten: nobody types more blindly. */
const MOST = 8;

const isTypedIn = (element: Element | null): boolean =>
  element instanceof HTMLTextAreaElement ||
  element instanceof HTMLSelectElement || (element instanceof HTMLInputElement && ["text", "search", "number"].includes(element.type));

const turn = (): Promise<void> => new Promise((done) => setTimeout(done));

export class HeldKeys {
  #held: string[] | null = null;

  /** Holds what is typed from now on. */
  hold(): void {
    if (this.#held) return;
    this.#held = [];
    window.addEventListener("keydown", this.#take, { capture: true });
  }

  /** Gives what was typed to the focused element, key by key; the focus may move between them. */
  async release(): Promise<void> {
    const keys = this.drop();
    for (const key of keys) {
      const event = new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true });
      const taken = !(document.activeElement ?? document.body).dispatchEvent(event);
      await turn();
      if (!taken) break;
    }
  }

  /** Forgets what was typed; returns it. */
  drop(): readonly string[] {
    window.removeEventListener("keydown", this.#take, { capture: true });
    const keys = this.#held ?? [];
    this.#held = null;
    return keys;
  }

  #take = (e: KeyboardEvent): void => {
    if (!this.#held || e.ctrlKey || e.altKey || e.metaKey || e.isComposing || e.repeat || e.key.length !== 1 || isTypedIn(document.activeElement)) return;
    if (this.#held.length < MOST) this.#held.push(e.key);
    e.preventDefault();
    e.stopPropagation();
  };
}
