// The framework for the form: decisions with their definitions, scenarios, categories, the leaf's specification. Read
// from untyped JSON; where a name is missing, the id is shown.
import type { ClassChoices, FrameworkView } from "../api/types.ts";
import type { Bilingual } from "../text/text.svelte.ts";

export interface Named {
  id: string;
  name: Bilingual;
}

export interface Decision extends Named {
  meaning: Bilingual | null;
  not: Bilingual | null;
  directions: readonly string[];
}

export interface Leaf extends Named {
  /** Names of the L1, the L2 and the leaf. */
  path: readonly Bilingual[];
  definition: Bilingual | null;
  condition: Bilingual | null;
  /** Decisions that go with it; null for a class that the decision table does not have. */
  choices: ClassChoices | null;
  /** How to decide between it (or its L2) and another scenario where both seem to hold. */
  decides: readonly { against: string; rule: Bilingual }[];
}

export type Channel = "longitudinal" | "lateral";
export const channels: readonly Channel[] = ["longitudinal", "lateral"];

export interface Framework {
  longitudinal: readonly Decision[];
  lateral: readonly Decision[];
  none: Decision;
  categories: readonly Named[];
  leaves: ReadonlyMap<string, Leaf>;
  /** The L2 classes by their full ids, for tasks whose L3 is not known. */
  groups: ReadonlyMap<string, Leaf>;
  /** Longitudinal and lateral decisions that no class has together. */
  impossiblePairs: readonly (readonly string[])[];
  safetyReasons: readonly Named[];
}

/** How a decision relates to a class: seen most of the time, allowed, or contradicting it. */
export type Fit = "usual" | "possible" | "impossible";

/** How `id` ("null": no change) relates to a class; possible where the class is unknown. */
export function fitOf(choices: ClassChoices | null, channel: Channel, id: string): Fit {
  if (!choices) return "possible";
  const found = choices[channel].filter((c) => (c.id ?? "null") === id);
  if (found.length === 0) return "impossible";
  return found.some((c) => c.usual) ? "usual" : "possible";
}

/** The directions of `all` in which a class has this lateral decision; all where it has it in every direction. */
export function directionsOf(choices: ClassChoices | null, id: string, all: readonly string[]): readonly string[] {
  const found = choices?.lateral.filter((c) => c.id === id) ?? [];
  if (found.length === 0 || found.some((c) => c.direction === null || c.direction === undefined)) return all;
  return all.filter((d) => found.some((c) => c.direction === d));
}

type Dict = Record<string, unknown>;
const dict = (v: unknown): Dict => (typeof v === "object" && v !== null && !Array.isArray(v) ? (v as Dict) : {});
const list = (v: unknown): unknown[] => (Array.isArray(v) ? v : []);
const word = (v: unknown): string => (typeof v === "string" ? v : "");

/** `{zh, en}`, or the pair of members `<key>_zh` and `<key>_en`, or one text for both. */
function both(o: Dict, key: string): Bilingual | null {
  const v = o[key];
  if (typeof v === "string" && v !== "") return { zh: v, en: word(o[`${key}_en`]) || v };
  const pair = typeof v === "object" && v !== null ? (v as Dict) : { zh: o[`${key}_zh`], en: o[`${key}_en`] };
  const zh = word(pair["zh"]);
  const en = word(pair["en"]);
  return zh || en ? { zh: zh || en, en: en || zh } : null;
}

function named(v: unknown): Named {
  if (typeof v === "string") return { id: v, name: { zh: v, en: v } };
  const o = dict(v);
  const id = word(o["id"]);
  return { id, name: both(o, "name") ?? { zh: id, en: id } };
}

function decision(v: unknown): Decision {
  const o = dict(v);
  return { ...named(v), meaning: both(o, "meaning"), not: both(o, "not"), directions: list(o["directions"]).map(word).filter(Boolean) };
}

/** The name of a leaf, an L2 or an L1 by its full id; null for an unknown id. */
export function className(leaves: ReadonlyMap<string, Leaf>, id: string): Bilingual | null {
  const depth = id.split(".").length;
  const leaf = leaves.get(id) ?? [...leaves.values()].find((l) => l.id.startsWith(`${id}.`));
  return leaf?.path[depth - 1] ?? null;
}

/** The category that a component gives by id or by name: drafts use either. */
export function categoryOf(categories: readonly Named[], text: string): Named | undefined {
  return categories.find((c) => c.id === text || c.name.en === text || c.name.zh === text);
}

export function readFramework(view: FrameworkView): Framework {
  const decisions = dict(view.decisions);
  const leaves = new Map<string, Leaf>();
  const groups = new Map<string, Leaf>();
  const decidesOf = (o: Dict): Leaf["decides"] =>
    list(o["decides"]).map((d) => ({ against: word(dict(d)["against"]), rule: both(dict(d), "rule") ?? { zh: "", en: "" } }));
  for (const l1 of list(Array.isArray(view.taxonomy) ? view.taxonomy : dict(view.taxonomy)["l1"])) {
    const a = named(l1);
    for (const l2 of list(dict(l1)["l2"])) {
      const b = named(l2);
      const bo = dict(l2);
      const group = `${a.id}.${b.id}`;
      groups.set(group, {
        id: group,
        name: b.name,
        path: [a.name, b.name],
        definition: both(bo, "definition"),
        condition: both(bo, "condition"),
        decides: decidesOf(bo),
        choices: view.choices[group] ?? null,
      });
      for (const l3 of list(bo["l3"] ?? bo["leaves"])) {
        const c = named(l3);
        const co = dict(l3);
        const id = c.id.includes(".") ? c.id : `${a.id}.${b.id}.${c.id}`;
        leaves.set(id, {
          id,
          name: c.name,
          path: [a.name, b.name, c.name],
          definition: both(co, "definition") ?? both(bo, "definition"),
          condition: both(co, "condition"),
          decides: [...decidesOf(co), ...decidesOf(bo)],
          choices: view.choices[id] ?? null,
        });
      }
    }
  }
  const none = decision(decisions["null"]);
  return {
    longitudinal: list(decisions["longitudinal"]).map(decision),
    lateral: list(decisions["lateral"]).map(decision),
    none: { ...none, id: "null" },
    categories: list(view.categories).map(named),
    leaves,
    groups,
    impossiblePairs: view.impossible_pairs,
    safetyReasons: view.safety_reasons.map(named),
  };
}

export interface Moment {
  rule: Bilingual;
  expr?: string;
}
export interface Bound extends Moment {
  fallback?: Moment;
}
export interface RecordSpec {
  id: string;
  name: Bilingual;
  unit?: string;
  /** Signal that measures it. */
  signal?: string;
  /** Its value is the id of an object of the scene. */
  object?: boolean;
  choices?: Named[];
}
/** `spec` of a task: `ResolvedSpec` of the framework. */
export interface Spec {
  leaf: string;
  keyframe: Bound & { type: "reactive" | "proactive" };
  second_keyframe?: Bound & { type: "reactive" | "proactive" };
  start: Bound;
  end: Bound;
  pack: { before_s: number; after_s: number };
  records: RecordSpec[];
  uncertainty_high: boolean;
  lateral?: string;
}
