// Changes of a draft that the service has not acknowledged: joined and applied to a draft. Pure.
import { type Json, read, same, write } from "./pointer.ts";

export interface Change {
  path: string;
  /** Absent: the field is removed. */
  value?: Json | undefined;
}

export interface Step extends Change {
  before: Json | undefined;
}

/** Is `path` the field `parent` or in it? */
export const within = (path: string, parent: string): boolean => path === parent || path.startsWith(`${parent}/`);

/** `changes` with one more. A later write of a field, or of what contains it, replaces the earlier one. */
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

/** Where the parent of `path` is missing, the change that creates it: the service does not create parents. */
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
