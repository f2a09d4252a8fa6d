// What the annotator has confirmed before submitting: drafted fields accepted as they are. Kept in this browser until
// the label is submitted.

export class ReviewMarks {
  /** Pointers of drafted fields that were accepted unchanged. */
  accepted = $state.raw<ReadonlySet<string>>(new Set());
  #task: string;

  constructor(task: string) {
    this.#task = task;
  }

  load(): void {
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

  /** Removes the copy in this browser: the label was submitted. */
  clearStored(): void {
    localStorage.removeItem(this.#key("accepted"));
  }

  #key(name: string): string {
    return `whyroad.${name}.${this.#task}`;
  }
}
