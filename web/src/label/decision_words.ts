// Decisions as sentences: what the ego does, for the trace. Names are for lists; a sentence of names reads as none.
// Wording as `decisions` of schema/draft_texts.yaml, but without what a choice alone does not say, such as the motion.
import type { TextPair } from "../text/screen_texts.ts";
import type { Lang } from "../text/text.svelte.ts";

/** With the ego as their subject. */
const LONGITUDINAL: Record<string, TextPair> = {
  set_speed_tracking: ["自车保持目标车速", "the ego keeps its set speed"],
  lead_following: ["自车跟车行驶", "the ego follows the lead"],
  road_speed_adaptation: ["自车减速慢行", "the ego slows down for the road"],
  gap_matching: ["自车调整车速匹配空档", "the ego adjusts its speed to the gap"],
  acceleration_for_passing: ["自车加速超车", "the ego accelerates to pass"],
  yield_to_agent: ["自车让行", "the ego yields"],
  stop_for_regulation: ["自车按规定停车", "the ego stops as required"],
  stop_for_obstacle: ["自车减速停车", "the ego slows down and stops"],
  resume: ["自车起步", "the ego moves off"],
};

/** After the subject; `{side}` is the direction, with the words in brackets left out where there is none. */
const LATERAL: Record<string, TextPair> = {
  lane_keeping: ["保持在本车道内行驶", "stays in its lane"],
  in_lane_nudge: ["在本车道内[向{side}]偏移", "nudges[ to the {side}] within its lane"],
  out_of_lane_nudge: ["[向{side}]借道绕行", "goes round over the line[ on the {side}]"],
  lane_change: ["[向{side}]换道", "changes lanes[ to the {side}]"],
  merge_or_split: ["汇入或汇出", "merges or leaves the road"],
  turn: ["[向{side}]转弯", "turns[ {side}]"],
  pull_over: ["靠边停车", "pulls over"],
  maneuver_abort: ["放弃变道，回到原车道", "aborts the maneuver and returns to its lane"],
  reverse: ["倒车", "reverses"],
};

const SIDES: Record<string, TextPair> = { left: ["左", "left"], right: ["右", "right"] };

/** A decision of each channel: its id and its name, for an id without words; null: none. */
export interface Chosen {
  id: string;
  name: string;
}

/** `自车让行，并向左转弯`; the decision of one channel alone; empty without any. */
export function decisionSentence(along: Chosen | null, across: Chosen | null, side: string, lang: Lang): string {
  const at = lang === "zh" ? 0 : 1;
  const ego = lang === "zh" ? "自车" : "the ego ";
  const first = along && (LONGITUDINAL[along.id]?.[at] ?? `${ego}${along.name}`);
  const second = across && (across.id === "turn" && side === "uturn" ? (lang === "zh" ? "掉头" : "makes a U-turn") : sided(LATERAL[across.id]?.[at] ?? across.name, SIDES[side]?.[at]));
  if (first && second) return lang === "zh" ? `${first}，并${second}` : `${first} and ${second}`;
  return first ?? (second ? ego + second : "");
}

const sided = (text: string, side: string | undefined): string =>
  side === undefined ? text.replace(/\[.*?\]/g, "") : text.replace(/\[(.*?)\]/g, "$1").replace("{side}", side);
