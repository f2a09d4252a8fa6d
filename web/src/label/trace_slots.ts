// The causal trace as three slots, state, reason and decision, that flow into the one text which the label holds, and
// back. Pure.
import type { Lang } from "../text/text.svelte.ts";

export interface TraceSlots {
  state: string;
  reason: string;
  decision: string;
}

export type SlotName = keyof TraceSlots;
export const slotNames: readonly SlotName[] = ["state", "reason", "decision"];

/** What a program's draft opens with; a trace that a person has worked on does not. */
const DRAFT_MARK = /^\s*(?:【草稿】|\[DRAFT\])\s*/i;
const HAN = /\p{Script=Han}/gu;
const WORD = /[\p{Script=Latin}\d][\p{Script=Latin}\d'-]*/gu;

const JOINT = String.raw`\s*(?:因此|所以|故而|(?<!\p{L})(?:therefore|so|hence)(?!\p{L}))[，,]?\s*`;
/** Before the decision: the last of these in the text. */
const THEREFORE = new RegExp(`[，,；;。.]?${JOINT}`, "giu");
/** Who writes a decision writes this before it, as in a sentence; the text has it already. */
const LEADS = new RegExp(`^[，,；;]?${JOINT}`, "iu");
/** A text that is only a decision, as `traceOf` writes it. */
const BARE_DECISION = /^(?:因此|therefore )/i;
/** Between state and reason: the first of these. */
const BETWEEN = /[；;]\s*/u;
const END = /[。.\s]+$/u;
/** An end of a sentence with another sentence after it. */
const SENTENCE = /。\s*(?=\S)|\.\s+(?=\S)/gu;

export const isDraft = (text: string): boolean => DRAFT_MARK.test(text);

/** `text` with the mark of a draft as long as `before` has it and the reason, which no program gives, is missing. */
export function stillDraft(text: string, before: string, slots: TraceSlots): string {
  return isDraft(before) && slots.reason.trim() === "" ? (DRAFT_MARK.exec(before)?.[0] ?? "") + text : text;
}

/** The language of a text: that of most of its words; `otherwise` without any. */
export function languageOf(text: string, otherwise: Lang): Lang {
  const han = text.match(HAN)?.length ?? 0;
  const words = text.match(WORD)?.length ?? 0;
  return han === 0 && words === 0 ? otherwise : han >= words ? "zh" : "en";
}

/**
 * The slots of a text. A text in another form keeps all of its words: what has no slot of its own is in `state`.
 * `sentences`: the last sentence before the decision is the reason where nothing else marks it. Not for a text that is
 * being typed: a full stop in one slot would move what follows into another.
 */
export function slotsOf(text: string, sentences = false): TraceSlots {
  const plain = text.replace(DRAFT_MARK, "").trim();
  // At the beginning: a decision that has neither state nor reason yet.
  const found = [...plain.matchAll(THEREFORE)].filter((m) => m.index > 0 || BARE_DECISION.test(plain)).at(-1);
  const before = found ? plain.slice(0, found.index) : plain;
  const decision = found ? plain.slice(found.index + found[0].length).replace(END, "") : "";
  const between = BETWEEN.exec(before) ?? (found && sentences ? [...before.matchAll(SENTENCE)].at(-1) : null);
  if (!between) return { state: found ? before : before.replace(END, ""), reason: "", decision };
  // After a semicolon no word begins with a capital because of its place.
  const reason = before.slice(between.index + between[0].length).replace(END, "").replace(/^[A-Z](?=[a-z ])/u, (c) => c.toLowerCase());
  return { state: before.slice(0, between.index), reason, decision };
}

/** Are state and reason of `text` those of the draft? What it decides follows the choice: no sign of a reader. */
export function keepsDraft(text: string, draft: string): boolean {
  const [now, was] = [slotsOf(text, true), slotsOf(draft, true)];
  return now.state + now.reason !== "" && now.state === was.state && now.reason === was.reason;
}

/** What a person typed into the slots, and the text that it made. */
export interface TypedTrace {
  text: string;
  slots: TraceSlots;
}

/**
 * The slots to show for `text`: those that were typed, as long as nothing else changed the text. Read back from the
 * text, a "so" or a semicolon would move what is being typed into another slot.
 */
export function slotsShown(text: string, typed: TypedTrace | null, sentences = false): TraceSlots {
  return typed?.text === text ? typed.slots : slotsOf(text, sentences);
}

/** The text of the slots: one sentence in the order state, reason, decision. Empty slots leave no marks behind. */
export function traceOf(slots: TraceSlots, language: Lang): string {
  const [state, reason] = [slots.state.replace(END, ""), slots.reason.replace(END, "")];
  const decision = slots.decision.replace(LEADS, "").replace(END, "");
  const zh = language === "zh";
  const first = [state, reason].filter((part) => part !== "").join(zh ? "；" : "; ");
  if (first === "" && decision === "") return "";
  const whole = decision === "" ? first : first === "" ? (zh ? `因此${decision}` : `Therefore ${decision}`) : first + (zh ? `，因此${decision}` : `, therefore ${decision}`);
  return whole + (zh ? "。" : ".");
}

/** Do the slots give back the text, so that editing them loses nothing? */
export function fitsSlots(text: string): boolean {
  const plain = text.replace(DRAFT_MARK, "");
  const bare = (t: string): string => t.replace(/[\s，。；,.;]|因此|所以|故而|therefore|hence|\bso\b/giu, "").toLowerCase();
  return bare(traceOf(slotsOf(plain), languageOf(plain, "zh"))) === bare(plain);
}

/** What is missing for a trace that explains: judged by content, not by length alone. */
export type TraceLack = "state" | "reason" | "decision" | "short_reason" | "repeats_state";

/** Least content of a reason: Chinese characters, or words. */
const REASON_LEAST = { zh: 5, en: 4 } as const;

/** The content of a text: Chinese characters, or words of other languages. */
export function contentOf(text: string, otherwise: Lang = "zh"): { n: number; language: Lang } {
  const language = languageOf(text, otherwise);
  return { n: (language === "zh" ? text.match(HAN) : text.match(WORD))?.length ?? 0, language };
}

export function lacks(slots: TraceSlots): TraceLack[] {
  const out: TraceLack[] = slotNames.filter((name) => slots[name].trim() === "");
  const { n, language } = contentOf(slots.reason);
  if (n > 0 && n < REASON_LEAST[language]) out.push("short_reason");
  if (n > 0 && slots.reason.trim() === slots.state.trim()) out.push("repeats_state");
  return out;
}
