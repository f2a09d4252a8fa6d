// Short names of the findings that a submitted label may have: warnings and notes. Pure.
import type { Lang } from "./text.svelte.ts";

/** By code, in the order of a label: `docs/diagnostics/<code>.md` describes each. */
const NAMES: Readonly<Record<string, readonly [zh: string, en: string]>> = {
  "label.class.rule": ["规则找到的是另一场景", "the rules find another class"],
  "label.clip.unrecorded": ["没有可核对的录制", "no recording to compare with"],
  "label.class.motion": ["决策与场景不符", "decision against the class"],
  "label.text.class": ["文字没有提到场景的主体", "texts do not mention the subject of the class"],
  "label.keyframe.moment": ["关键帧偏离规则的时刻", "keyframe off the rule's moment"],
  "label.keyframe.range_on_reactive": ["反应式关键帧带区间", "range on a reactive keyframe"],
  "label.second_keyframe.missing": ["缺第二关键帧", "second keyframe missing"],
  "label.time_range.start": ["时间范围起点偏离规格", "range start off the specification"],
  "label.secondary.primary": ["主场景又列为次场景", "primary class also a secondary one"],
  "label.component.duplicate": ["关键要素重复", "duplicate component"],
  "label.component.too_long": ["关键要素过长", "component too long"],
  "label.component.too_short": ["关键要素过短", "component too short"],
  "label.text.unrelated": ["文字与驾驶无关", "text not about driving"],
  "label.object.unknown": ["没有文字所说的目标", "no object of the kind"],
  "label.object.position": ["目标的方位或距离与描述不符", "position of the object differs"],
  "label.object.state": ["目标的运动与描述不符", "motion of the object differs"],
  "label.decision.unchanged": ["一直停着却决策停车", "decides to stop while standing"],
  "label.motion.no_change": ["决策后车速没有变化", "no change of speed after the decision"],
  "label.motion.stated": ["所述车速或距离与录制不符", "stated speed or distance differs"],
  "label.motion.unlabelled": ["车速变化没有决策", "change of speed without a decision"],
  "label.cause.missing": ["要素都不会引起决策", "no component that causes the decision"],
  "label.cause.without_decision": ["没有决策却有原因", "cause without a decision"],
  "label.cause.kind": ["原因不会引起该决策", "cause that does not fit the decision"],
  "label.cause.no_effect": ["去掉该原因没有影响", "cause without effect"],
  "label.cause.proximate": ["更近的原因是前车", "the lead is the nearer cause"],
  "label.cause.circular": ["因果描述没有给出原因", "trace without a reason"],
  "label.trace.contradicts": ["因果描述与决策矛盾", "trace contradicts the decision"],
  "label.trace.unnamed_object": ["因果描述提到未列出的目标", "trace names an unlisted object"],
  "label.trace.object_differs": ["因果描述与要素不一致", "trace differs from a component"],
  "label.trace.unlabelled": ["因果描述的决策没有选", "decision in the trace only"],
  "label.trace.decision_missing": ["因果描述没有写决策", "trace without the decision"],
  "label.trace.decision_id": ["因果描述里有编号", "identifier in the trace"],
  "label.trace.numbers": ["因果描述里数字过多", "too many numbers in the trace"],
  "label.trace.too_long": ["因果描述过长", "trace too long"],
  "label.record.value": ["记录与文字不符", "record differs from the texts"],
};

/** Codes that lists can be filtered by. */
export const FINDING_CODES: readonly string[] = Object.keys(NAMES);

/** The name of a finding; that of all others for a code without one. */
export function findingName(code: string, lang: Lang): string {
  const [zh, en] = NAMES[code] ?? ["其他提醒", "another warning"];
  return lang === "zh" ? zh : en;
}
