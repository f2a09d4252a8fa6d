// Ids that fill a line without telling anything, as people are shown them; the whole id stays in a tooltip. Pure.

const UUID = /([0-9a-f]{8})-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}/gi;

/** `adcf7d18…_000` for an id with a UUID in it; others as they are. The service finds tasks by this beginning, too. */
export const shortId = (id: string): string => id.replace(UUID, "$1…");
