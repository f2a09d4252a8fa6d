// How many labels an agreement needs before its kappa says anything. Pure.

/** Below this kappa is mostly chance: with ten labels its standard error is still about 0.3. */
const LEAST_LABELS = 10;

export const isTooFew = (labels: number): boolean => labels < LEAST_LABELS;
