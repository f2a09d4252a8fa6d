// Values of a label as text, for conflicts, comparisons and earlier values.
import { labelTexts } from "../text/label_texts.ts";
import type { TextPair } from "../text/screen_texts.ts";
import type { Lang } from "../text/text.svelte.ts";
import { categoryOf, channels, className, type Framework, type RecordSpec, type Spec } from "./framework.ts";
import { HIDDEN_MEMBERS, memberNames, pointers } from "./field_pointers.ts";
import { type Json, pointer } from "./pointer.ts";
import { signed } from "./times.ts";
import { UNKNOWN } from "./unknown.ts";

/** What formatting a value needs to know of the task. */
export interface LabelContext {
  framework: Framework | null;
  second(iso: unknown): number | null;
  /** What the class records; without it records are shown by id. */
  spec?: Spec | null;
  /** The name of an object on the screen; without it objects are shown by id. */
  trackName?(id: string): string;
}

const DECISIONS: ReadonlySet<string> = new Set(channels.map(pointers.decisionOf));

const MOMENT = /^\d{4}-\d\d-\d\dT/;

/** Members whose values say what they are. */
const SELF_EVIDENT = new Set(["description", "components", "timestamp"]);

const MEMBER_ORDER = Object.keys(memberNames);
const order = (key: string): number => (MEMBER_ORDER.indexOf(key) + 99) % 99;

const FIXED: Record<string, TextPair> = {
  low: ["低", "low"],
  high: ["高", "high"],
  left: ["左", "left"],
  right: ["右", "right"],
  uturn: ["掉头", "U-turn"],
  unknown: ["未知", "unknown"],
};

/** `path`: where in the label the value is, as far as the caller knows. */
export function readable(value: Json | undefined, words: LabelContext, lang: Lang, path = ""): string {
  const zh = lang === "zh";
  if (value === undefined) return zh ? "（无）" : "(nothing)";
  // No change is a judgment, not an empty field (SPEC 2.3).
  if (value === null && DECISIONS.has(path)) return labelTexts["dec.null"][zh ? 0 : 1];
  if (value === null) return zh ? "空" : "null";
  if (typeof value === "boolean") return zh ? (value ? "是" : "否") : value ? "yes" : "no";
  if (typeof value === "number") return String(value);
  if (typeof value === "string") return text(value, words, lang);
  if (Array.isArray(value)) {
    const items = value.map((v) => readable(v, words, lang));
    if (items.length === 0) return zh ? "（无）" : "(none)";
    return items.join(value.some((v) => typeof v === "object") ? "\n" : zh ? "、" : ", ");
  }
  const id = typeof value["id"] === "string" ? `${value["id"]}${zh ? "：" : ": "}` : "";
  const parts = Object.entries(value)
    .filter(([key]) => !HIDDEN_MEMBERS.has(key))
    .sort(([a], [b]) => order(a) - order(b))
    .map(([key, v]) => {
      const record = memberNames[key] ? undefined : words.spec?.records.find((r) => r.id === key);
      if (record) return `${record.name[lang] || key} ${recorded(record, v, words, lang)}`;
      const text = readable(key === "linked_objects" ? named(v, words) : v, words, lang, path + pointer(key));
      return SELF_EVIDENT.has(key) ? text : `${memberNames[key]?.[zh ? 0 : 1] ?? key} ${text}`;
    });
  return id + parts.join(zh ? "；" : "; ");
}

/** A recorded value: the name of a choice, an object by its name, a number with its unit. */
export function recorded(record: RecordSpec, value: Json, words: LabelContext, lang: Lang): string {
  if (value === UNKNOWN) return readable(value, words, lang);
  const choice = record.choices?.find((c) => c.id === (value === true ? "yes" : value === false ? "no" : value));
  if (choice) return choice.name[lang];
  if (record.object && typeof value === "string") return words.trackName?.(value) ?? value;
  const text = readable(value, words, lang);
  return record.unit && typeof value === "number" ? `${text} ${record.unit}` : text;
}

/** Ids of objects as the names that the screen has for them. */
const named = (ids: Json, words: LabelContext): Json =>
  Array.isArray(ids) ? ids.map((id) => (typeof id === "string" ? (words.trackName?.(id) ?? id) : id)) : ids;

const MOMENTS = /\d{4}-\d\d-\d\dT[\d:.]+Z/g;
/** What can be the id of a track that the screen has a shorter name for. */
const LONG_IDS = /[0-9A-Za-z][\w.:-]{11,}/g;
/** Not what a message quotes from the text: a reader looks for it there. */
const IDS = /(?<!(?:identifier|标识) '[a-z_]*)(?:[a-z][a-z0-9_]*(?:\.[a-z][a-z0-9_]*)+|[a-z]+(?:_[a-z]+)+)/g;

/** A message of the validator with times in seconds from the keyframe, and names instead of ids. */
export function describeFinding(sentence: string, words: LabelContext, lang: Lang): string {
  const f = words.framework;
  const named = (id: string): string => {
    const field = memberNames[id];
    if (field) return lang === "zh" ? `“${field[0]}”` : `“${field[1]}”`;
    const found = f ? ([...f.longitudinal, ...f.lateral, ...f.categories].find((d) => d.id === id)?.name ?? className(f.leaves, id)) : null;
    return found ? (lang === "zh" ? `“${found.zh}”` : `“${found.en}”`) : id;
  };
  return sentence
    .replace(LONG_IDS, (id) => words.trackName?.(id) ?? id)
    .replace(MOMENTS, (iso) => {
      const s = words.second(iso);
      return s === null ? iso : `${signed(s, 1)} s`;
    })
    .replace(IDS, named);
}

function text(value: string, words: LabelContext, lang: Lang): string {
  if (MOMENT.test(value)) {
    const s = words.second(value);
    if (s !== null) return `${signed(s, 1)} s`;
  }
  const fixed = FIXED[value];
  if (fixed) return fixed[lang === "zh" ? 0 : 1];
  const f = words.framework;
  const named = f ? ([...f.longitudinal, ...f.lateral].find((d) => d.id === value) ?? categoryOf(f.categories, value)) : undefined;
  return named ? named.name[lang] : (f?.leaves.get(value)?.name[lang] ?? value);
}
