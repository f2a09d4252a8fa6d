// A number as people type it. Pure.

/** Digits, signs and points of full width, as a Chinese input method writes them, become those of ASCII. */
const narrow = (text: string): string =>
  text.replace(/[\uFF01-\uFF5E]/g, (c) => String.fromCharCode(c.charCodeAt(0) - 0xfee0)).replace(/[。．]/g, ".").replace(/[−－]/g, "-").replace(/\u3000/g, " ");

/**
 * The number that `typed` is, with or without the unit that stands beside the field; a comma is a decimal point. Null
 * for anything else, also for another unit: nobody knows what was meant.
 */
export function typedNumber(typed: string, unit: string): number | null {
  const plain = narrow(typed).trim();
  const bare = plain.endsWith(unit) ? plain.slice(0, -unit.length).trim() : plain;
  if (!/^[-+]?(\d+([.,]\d*)?|[.,]\d+)(e[-+]?\d+)?$/i.test(bare)) return null;
  const number = Number(bare.replace(",", "."));
  return Number.isFinite(number) ? number : null;
}
