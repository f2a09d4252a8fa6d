// Ids that fill a line without telling anything, as people are shown them; the whole id stays in a tooltip. Pure.

const UUID = /([0-9a-f]{8})-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}/gi;
/** Characters that have room in a list; of a longer id, those that are kept of its beginning and of its end. */
const MOST = 24;
const FIRST = 8;
const LAST = 15;
/** Longer ids of objects say nothing and fill the screen: UUIDs and hashes. */
export const LONGEST_TRACK = 12;

/**
 * `adcf7d18…_000` for an id with a UUID in it. Of another long id the beginning and the end, where names of a series
 * differ: `sd_nusce…_scene-0061_000`.
 */
export function shortId(id: string): string {
  const short = id.replace(UUID, "$1…");
  return short.length > MOST ? `${short.slice(0, FIRST)}…${short.slice(-LAST)}` : short;
}

/** Of an id of an object that is longer than a name its beginning, which tells objects of one drive apart. */
export function shortTrack(id: string): string {
  return id.length > LONGEST_TRACK ? `${id.slice(0, FIRST)}…` : id;
}
