// What the annotator has confirmed before submitting: drafted fields accepted as they are, and that the driving is
// legal and safe. Kept in this browser until the label is submitted.

export class ReviewMarks {
  /** Pointers of drafted fields that were accepted unchanged. */
  accepted = $state.raw<ReadonlySet<string>>(new Set());
  /** The driving was confirmed to be legal and safe. */
  safe = $state(false);
  #task: string;

  constructor(task: string) {
    this.#task = task;
  }

  load(): void {
    this.safe = localStorage.getItem(this.#key("safe")) !== null;
    try {
      const paths: unknown = JSON.parse(localStorage.getItem(this.#key("accepted")) ?? "[]");
      if (Array.isArray(paths)) this.accepted = new Set(paths.map(String));
    } catch {
      // Written by an older version of the page: nothing is accepted yet.
    }
  }

  accept(path: string): void {
    this.accepted = new Set([...this.accepted, path]);
    localStorage.setItem(this.#key("accepted"), JSON.stringify([...this.accepted]));
  }

  setSafe(safe: boolean): void {
    this.safe = safe;
    if (safe) localStorage.setItem(this.#key("safe"), "yes");
    else localStorage.removeItem(this.#key("safe"));
  }

  /** Removes the copy in this browser: the label was submitted. */
  clearStored(): void {
    for (const name of ["safe", "accepted"]) localStorage.removeItem(this.#key(name));
  }

  #key(name: string): string {
    return `whyroad.${name}.${this.#task}`;
  }
}
