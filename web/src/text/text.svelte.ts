// Which language the page speaks, and how it says things. Switching is a state change: no reload.
import { words } from "./words.ts";

export type Lang = "zh" | "en";
export type WordKey = keyof typeof words;
/** A text that the server sends in both languages. */
export interface Bilingual {
  zh: string;
  en: string;
}

const KEY = "whyroad.lang";
const stored = localStorage.getItem(KEY);
const first: Lang = stored === "zh" || stored === "en" ? stored : navigator.language.startsWith("zh") ? "zh" : "en";

export const lang = $state<{ now: Lang }>({ now: first });

export function speak(next: Lang): void {
  lang.now = next;
  localStorage.setItem(KEY, next);
  document.documentElement.lang = next === "zh" ? "zh-CN" : "en";
}
speak(first);

/** The text of `key`, `{name}` replaced by `values.name`. */
export function t(key: WordKey, values: Record<string, string | number> = {}): string {
  const text: string = words[key][lang.now === "zh" ? 0 : 1];
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}

/** The reader's side of a bilingual text. */
export function say(text: Bilingual | null | undefined): string {
  return text ? text[lang.now] || text.en || text.zh : "";
}
