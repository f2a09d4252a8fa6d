// What the list of mined episodes shows, as it is in the address of the screen. Pure.
import { queryString } from "./api/client.ts";

/** Moments that no class explains are mined as this class. They are listed apart: they are no class to compare with. */
export const UNEXPLAINED = "other";

export interface EpisodeFilter {
  /** Mined folder; empty: the first one. */
  mined: string;
  /** A class, `other`, or empty: all classes. */
  scenario: string;
  /** Only episodes without a verdict of the reader. */
  unjudged: boolean;
}

/** The filter in the query of an address. */
export function filterOf(query: string): EpisodeFilter {
  const q = new URLSearchParams(query);
  return { mined: q.get("mined") ?? "", scenario: q.get("scenario") ?? "", unjudged: q.get("unjudged") === "true" };
}

/** The query of the address: what `filterOf` reads. */
export const queryOf = (filter: EpisodeFilter): string => queryString({ ...filter });

/** What the service is asked for. */
export function requestOf({ scenario, unjudged }: EpisodeFilter): { scenario?: string; unjudged?: true; explained?: true } {
  return { ...(scenario === "" ? { explained: true } : { scenario }), ...(unjudged && { unjudged: true }) };
}
