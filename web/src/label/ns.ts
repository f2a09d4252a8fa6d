// Times: nanoseconds since the epoch as bigint, because a double holds only 53 bits; ISO 8601 in labels.

export type Ns = bigint;

/** From the API: a number, digits, or ISO 8601. */
export function toNs(value: number | string): Ns {
  if (typeof value === "number") return BigInt(Math.round(value));
  if (/^-?\d+$/.test(value)) return BigInt(value);
  const parts = /^(.*?)(?:\.(\d{1,9}))?(Z|[+-]\d\d:\d\d)$/.exec(value);
  if (!parts) throw new RangeError(`not a time: ${value}`);
  const seconds = Math.floor(Date.parse(`${parts[1]}${parts[3]}`) / 1000);
  return BigInt(seconds) * 1_000_000_000n + BigInt((parts[2] ?? "").padEnd(9, "0"));
}

/** ISO 8601 in UTC with three, six or nine digits of fraction, as the label format writes it. */
export function toIso(ns: Ns): string {
  const second = 1_000_000_000n;
  let rest = ns % second;
  if (rest < 0n) rest += second;
  const whole = new Date(Number((ns - rest) / 1_000_000n)).toISOString().slice(0, 19);
  const digits = rest.toString().padStart(9, "0");
  const kept = rest % 1_000_000n === 0n ? 3 : rest % 1000n === 0n ? 6 : 9;
  return `${whole}.${digits.slice(0, kept)}Z`;
}

/** Seconds from `from` to `to`; exact to a nanosecond for the lengths of clips. */
export function secondsBetween(from: Ns, to: Ns): number {
  return Number(to - from) / 1e9;
}

/** The nearest of `times` (ascending) to `ns`. */
export function nearestIndex(times: readonly Ns[], ns: Ns): number {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const mid = (low + high) >> 1;
    if ((times[mid] ?? 0n) < ns) low = mid + 1;
    else high = mid;
  }
  const before = times[low - 1];
  const at = times[low];
  if (before !== undefined && at !== undefined && ns - before < at - ns) return low - 1;
  return Math.max(low, 0);
}
