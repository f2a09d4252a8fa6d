// Choosing in a group of radio buttons by one key: a digit is the number of the choice, letters are the beginning of
// its name. Pure but for the timer of what is typed.

/** A pause of this length begins a new word, ms. */
const TYPING_REST_MS = 900;

/** Digits as they are on a keyboard: the last choice of a group, "no change", is 0. */
export const CHOICE_KEYS = "123456789";

export interface Choice {
  id: string;
  /** Names that typing finds: those on the screen, since a letter of another name would choose what nobody reads. */
  names: readonly string[];
}

/** The key that chooses the `n`th of `count` choices; undefined beyond the digits. The last one is always `0`. */
export function choiceKey(n: number, count: number): string | undefined {
  return n === count - 1 ? "0" : CHOICE_KEYS[n];
}

/** The choice whose name, or a word of it, begins with what was typed; null without any. */
export function typed(choices: readonly Choice[], text: string): Choice | null {
  const wanted = text.toLowerCase();
  const begins = (name: string): boolean => name.toLowerCase().startsWith(wanted);
  const words = (name: string): string[] => name.toLowerCase().split(/\s+/);
  return (
    choices.find((c) => c.names.some(begins)) ?? choices.find((c) => c.names.some((name) => words(name).some((word) => word.startsWith(wanted)))) ?? null
  );
}

/**
 * Handles the keys of one group. `choose` gets the choice, and whether one key said all, so that the next may follow.
 */
export function choiceKeys(choices: () => readonly Choice[], choose: (id: string, done: boolean) => void): (e: KeyboardEvent) => void {
  let text = "";
  let timer: ReturnType<typeof setTimeout> | undefined;
  return (e) => {
    if (e.isComposing || e.ctrlKey || e.altKey || e.metaKey || e.key.length !== 1 || e.key === " ") return;
    const all = choices();
    const byDigit = all.find((_, n) => choiceKey(n, all.length) === e.key);
    if (byDigit) choose(byDigit.id, true);
    else if (/\p{L}/u.test(e.key)) {
      clearTimeout(timer);
      timer = setTimeout(() => (text = ""), TYPING_REST_MS);
      const found = typed(all, text + e.key);
      if (!found) return;
      text += e.key;
      choose(found.id, false);
    } else return;
    e.preventDefault();
    e.stopPropagation();
  };
}
