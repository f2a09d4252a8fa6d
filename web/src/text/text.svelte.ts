// The page's language and its texts. Switching the language is a state change: no reload.
import type { TextPair } from "./screen_texts.ts";
import { texts } from "./texts.ts";

export type Lang = "zh" | "en";
export type TextKey = keyof typeof texts;
/** A text from the service in both languages. */
export interface Bilingual {
  zh: string;
  en: string;
}

const KEY = "whyroad.lang";
const stored = localStorage.getItem(KEY);
const first: Lang = stored === "zh" || stored === "en" ? stored : navigator.language.startsWith("zh") ? "zh" : "en";

export const lang = $state<{ now: Lang }>({ now: first });

export function setLanguage(next: Lang): void {
  lang.now = next;
  localStorage.setItem(KEY, next);
  document.documentElement.lang = next === "zh" ? "zh-CN" : "en";
}
setLanguage(first);

/** The names in braces in a text: `"n" | "of"` for `{n} of {of}`. Chinese has no plurals, so its names are plain. */
type Placeholder<Text extends string> = Text extends `${string}{${infer Name}}${infer Rest}` ? Name | Placeholder<Rest> : never;
type PlaceholderOf<Key extends TextKey> = Placeholder<(typeof texts)[Key][0]>;
type Values<Key extends TextKey> = [PlaceholderOf<Key>] extends [never] ? [] : [Record<PlaceholderOf<Key>, string | number>];

/** Texts without placeholders. */
export type PlainTextKey = { [Key in TextKey]: Values<Key> extends [] ? Key : never }[TextKey];

/** The text of `key` in the current language with its placeholders filled in. */
export function t<Key extends TextKey>(key: Key, ...[values]: Values<Key>): string {
  const text: string = texts[key][lang.now === "zh" ? 0 : 1];
  return filled(text, values as Record<string, string | number> | undefined);
}

/** `{name}` is the value, `{name:one|many}` the first word for the value 1 and the second for any other. */
const PLACEHOLDER = /\{(\w+)(?::([^|}]*)\|([^}]*))?\}/g;

/** `text` with its placeholders replaced; a name without a value stays. */
export function filled(text: string, values: Record<string, string | number> = {}): string {
  return text.replace(PLACEHOLDER, (whole, name: string, one?: string, many?: string) => {
    const value = values[name];
    if (value === undefined) return whole;
    return one === undefined || many === undefined ? String(value) : Number(value) === 1 ? one : many;
  });
}

/** The text of a pair in `language`; undefined without a pair. */
export const sideOf = (pair: TextPair | undefined, language: Lang): string | undefined => pair?.[language === "zh" ? 0 : 1];

/** `text` as a sentence of its own: the service's messages begin in lower case, as compilers' do. */
export const sentence = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** A bilingual text in the current language. */
export function localized(text: Bilingual | null | undefined): string {
  return text ? text[lang.now] || text.en || text.zh : "";
}
