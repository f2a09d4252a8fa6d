// Changes of a draft that the server has not acknowledged yet: joined, put on top of a draft, undone. Pure.
import { type Json, read, same, write } from "./pointer.ts";

export interface Change {
  path: string;
  /** Absent: the field goes away. */
  value?: Json | undefined;
}

export interface Step extends Change {
  before: Json | undefined;
}

/** Is `path` the field `parent` or in it? */
export const within = (path: string, parent: string): boolean => path === parent || path.startsWith(`${parent}/`);

/** `changes` with one more. A later write of a field, or of what contains it, makes the earlier one needless. */
export function join(changes: readonly Change[], next: Change): Change[] {
  return [...changes.filter((c) => !within(c.path, next.path)), next];
}

export function apply(doc: Json, changes: readonly Change[]): Json {
  return changes.reduce((d, c) => write(d, c.path, c.value), doc);
}

/** Those of `changes` that would still change `doc`. */
export function needed(doc: Json, changes: readonly Change[]): Change[] {
  return changes.filter((c) => !same(read(doc, c.path), c.value));
}

/** Where `path` has no parent yet, the change of the nearest one that has to be made: servers do not invent parents. */
export function rooted(doc: Json, change: Change): Change {
  const keys = change.path.split("/").slice(1);
  for (let n = 1; n < keys.length; n++) {
    const parent = `/${keys.slice(0, n).join("/")}`;
    if (read(doc, parent) === undefined || read(doc, parent) === null) {
      return { path: parent, value: read(write(doc, change.path, change.value), parent) };
    }
  }
  return change;
}
