// What can be inserted into the trace: components, the decision in words, and what was measured at the moment shown.
import { columnOf, isInside } from "../plots/series.ts";
import { signalRows } from "../plots/signal_rows.ts";
import { speedUnit } from "../plots/speed_unit.svelte.ts";
import { scaleOf, withUnit } from "../plots/units.ts";
import { objectsAt } from "../scene/objects.ts";
import { objectClassName } from "../text/category_names.ts";
import type { Lang } from "../text/text.svelte.ts";
import { type Chosen, decisionSentence } from "./decision_words.ts";
import { type Channel, channels } from "./framework.ts";
import { pointers } from "./field_pointers.ts";
import type { TaskEditor } from "./task_editor.svelte.ts";

export interface Insertion {
  kind: "component" | "decision" | "measured";
  /** Shown in the menu. */
  name: string;
  /** Put into the text. */
  text: string;
}

/** Measured values offered beside the ego's and the target's: those that the rule compares come first. */
const MOST_SIGNALS = 6;

/** The decisions in words: `自车让行` or `the ego yields`. Empty while nothing is chosen. */
export function decisionText(editor: TaskEditor, language: Lang): string {
  const of = (channel: Channel): Chosen | null => {
    const id = editor.decision(channel);
    if (typeof id !== "string") return null;
    return { id, name: editor.framework?.[channel].find((d) => d.id === id)?.name[language] ?? id };
  };
  const text = decisionSentence(of("longitudinal"), of("lateral"), editor.draft.text(pointers.lateralDirection), language);
  const chosen = channels.every((channel) => editor.decision(channel) !== undefined);
  if (text === "" && chosen) return language === "zh" ? "自车行驶状态不变" : "the ego goes on as before";
  return text;
}

const number = (value: number, digits: number): string => {
  const text = value.toFixed(Math.abs(value) >= 10 ? 0 : Math.min(1, digits));
  return Number(text) === 0 ? text.replace("-", "") : text;
};

/** A signal's name with what the target is: a reader of the trace knows of no target. */
export const named = (signal: string, what: string, language: Lang): string => signal.replace(language === "zh" ? /目标/g : /\btarget\b/g, what);

/** Values at the moment shown, in the reader's units. */
export function measuredNow(editor: TaskEditor, language: Lang): Insertion[] {
  const scene = editor.clip.scene;
  if (!scene) return [];
  const zh = language === "zh";
  const i = editor.player.index;
  const out: Insertion[] = [];
  const add = (name: string, text: string): void => void out.push({ kind: "measured", name: `${name} ${text}`, text: zh ? `${name} ${text}` : `${name} ${text}` });
  const ofSpeed = scaleOf("m/s", speedUnit.unit);
  const speed = scene.ego?.speed[i];
  if (typeof speed === "number") add(zh ? "自车速度" : "ego speed", `${number(speed * ofSpeed.by, 1)} ${ofSpeed.unit}`);
  const object = objectsAt(scene, i, editor.target).find((o) => o.id === (editor.selected ?? editor.target));
  const what = object ? objectClassName(object.class, language) : "";
  const ofTarget = object !== undefined && object.id === editor.target;
  const gap = object && object.gap !== null ? `${number(object.gap, 1)} m` : "";
  const itsSpeed = object && object.speed !== null ? `${number(object.speed * ofSpeed.by, 1)} ${ofSpeed.unit}` : "";
  if (gap !== "") add(zh ? `与${what}的净距` : `gap to the ${what}`, gap);
  if (itsSpeed !== "") add(zh ? `${what}速度` : `speed of the ${what}`, itsSpeed);
  const suggestion = editor.task?.suggestion;
  for (const row of signalRows(scene, suggestion?.signals ?? [], suggestion?.conditions ?? [], { speeds: speedUnit.unit, lang: language })) {
    if (out.length >= MOST_SIGNALS + 3) break;
    const column = row.column ?? columnOf([], "number");
    const value = column?.kind === "line" ? column.values[i] : null;
    // A rate that is not certain yet is no measurement to write down.
    const isUncertain = isInside(row.uncertain, i);
    if (!row.inRule || isUncertain || typeof value !== "number" || !Number.isFinite(value)) continue;
    const text = withUnit(number(value, row.scale.digits), row.scale.unit);
    // Said already, by what the target is; the lead mostly is the target.
    if (ofTarget && /^(target|lead)\.(gap|speed)$/.test(row.id) && (text === gap || text === itsSpeed)) continue;
    add(ofTarget ? named(row.title, what, language) : row.title, text);
  }
  return out;
}

/** All that can be inserted now, in the order of the menu. */
export function insertions(editor: TaskEditor, language: Lang): Insertion[] {
  const components = editor.components.flatMap((c): Insertion[] => {
    const text = String(c["description"] ?? "").trim();
    return text === "" ? [] : [{ kind: "component", name: `${String(c["id"] ?? "")} ${text}`, text }];
  });
  const decision = decisionText(editor, language);
  return [...components, ...(decision === "" ? [] : [{ kind: "decision" as const, name: decision, text: decision }]), ...measuredNow(editor, language)];
}
