// The service's types, generated from its OpenAPI document, and the few that the document does not describe.
export * from "./schema.generated.ts";

/** In `more` of a 409 `draft.conflict`. */
export interface Conflicts {
  version: number;
  draft: unknown;
  conflicts: FieldConflict[];
}

export interface FieldConflict {
  /** JSON pointer. */
  path: string;
  mine: unknown;
  theirs: unknown;
}
