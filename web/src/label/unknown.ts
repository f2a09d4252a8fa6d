// A record whose value cannot be seen: one value in the label, several words of people. Pure.

/** What the label has for it. */
export const UNKNOWN = "unknown";

const WORDS = ["unknown", "未知", "看不出", "看不清", "不清楚", "cannot tell", "can't tell", "cannot be seen"];

/** Does the text say that the value cannot be seen? */
export const isUnknown = (text: string): boolean => WORDS.includes(text.trim().toLowerCase().replace(/[。.]$/, ""));
