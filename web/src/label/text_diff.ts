// The difference of two texts, word by word (Chinese: character by character). Pure.

export interface Piece {
  kind: "same" | "removed" | "added";
  text: string;
}

/** Longer texts are compared as wholes: the table below grows with the square. */
const MOST_WORDS = 600;

const words = (text: string): string[] => text.match(/\p{Script=Han}|[^\p{Script=Han}\s]+|\s+/gu) ?? [];

/** Below this share of the shorter text, what both have in common are single words by chance: each is shown whole. */
const LEAST_SHARED = 0.5;

/** The pieces of `before` and `after` in reading order, by their longest common subsequence. */
export function difference(before: string, after: string): Piece[] {
  const a = words(before);
  const b = words(after);
  if (a.length > MOST_WORDS || b.length > MOST_WORDS) {
    return before === after ? [{ kind: "same", text: after }] : replaced(before, after);
  }
  const width = b.length + 1;
  const common = new Uint16Array((a.length + 1) * width);
  for (let i = a.length - 1; i >= 0; i--) {
    for (let j = b.length - 1; j >= 0; j--) {
      common[i * width + j] =
        a[i] === b[j] ? (common[(i + 1) * width + j + 1] ?? 0) + 1 : Math.max(common[(i + 1) * width + j] ?? 0, common[i * width + j + 1] ?? 0);
    }
  }
  const out: Piece[] = [];
  const put = (kind: Piece["kind"], text: string): void => {
    const last = out.at(-1);
    if (last?.kind === kind) last.text += text;
    else out.push({ kind, text });
  };
  let i = 0;
  let j = 0;
  while (i < a.length || j < b.length) {
    const x = a[i];
    const y = b[j];
    if (x !== undefined && x === y) {
      put("same", x);
      i++;
      j++;
    } else if (x !== undefined && (y === undefined || (common[(i + 1) * width + j] ?? 0) >= (common[i * width + j + 1] ?? 0))) {
      put("removed", x);
      i++;
    } else if (y !== undefined) {
      put("added", y);
      j++;
    }
  }
  const shared = out.reduce((n, piece) => (piece.kind === "same" ? n + piece.text.length : n), 0);
  return shared < LEAST_SHARED * Math.min(before.length, after.length) ? replaced(before, after) : out;
}

function replaced(before: string, after: string): Piece[] {
  const both: Piece[] = [{ kind: "removed", text: before }, { kind: "added", text: after }];
  return both.filter((piece) => piece.text !== "");
}
