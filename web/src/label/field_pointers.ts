// The fields of a label as the page uses them: JSON pointers (RFC 6901) and names for people. Both come from the field
// table (label_fields.generated.ts); this module groups and orders them for the form.
import type { TextPair } from "../text/screen_texts.ts";
import type { Channel } from "./framework.ts";
import * as fields from "./label_fields.generated.ts";
import { type Json, pointer } from "./pointer.ts";

export type KeyframeName = "keyframe" | "second_keyframe";
export type ComponentPart = "id" | "description" | "category" | "uncertainty" | "evidence_times" | "linked_objects";

const KEYFRAMES = {
  keyframe: { at: fields.KEYFRAME, time: fields.KEYFRAME_TIMESTAMP },
  second_keyframe: { at: fields.SECOND_KEYFRAME, time: fields.SECOND_KEYFRAME_TIMESTAMP },
} as const satisfies Record<KeyframeName, unknown>;

const KEYFRAME_RANGE = { range_start: fields.KEYFRAME_RANGE_START, range_end: fields.KEYFRAME_RANGE_END } as const;

const RANGE_ENDS = {
  start: { time: fields.TIME_RANGE_START_TIMESTAMP, frame: fields.TIME_RANGE_START_FRAME_IDX },
  end: { time: fields.TIME_RANGE_END_TIMESTAMP, frame: fields.TIME_RANGE_END_FRAME_IDX },
} as const;

const COMPONENT_PARTS = {
  id: fields.criticalComponentsItemId,
  description: fields.criticalComponentsItemDescription,
  category: fields.criticalComponentsItemCategory,
  uncertainty: fields.criticalComponentsItemUncertainty,
  evidence_times: fields.criticalComponentsItemEvidenceTimes,
  linked_objects: fields.criticalComponentsItemLinkedObjects,
} as const satisfies Record<ComponentPart, unknown>;

const CHANNELS = {
  longitudinal: {
    decision: fields.DRIVING_DECISION_LONGITUDINAL,
    causes: fields.CAUSES_LONGITUDINAL,
    components: fields.CAUSES_LONGITUDINAL_COMPONENTS,
    unobserved: fields.CAUSES_LONGITUDINAL_UNOBSERVED,
  },
  lateral: {
    decision: fields.DRIVING_DECISION_LATERAL,
    causes: fields.CAUSES_LATERAL,
    components: fields.CAUSES_LATERAL_COMPONENTS,
    unobserved: fields.CAUSES_LATERAL_UNOBSERVED,
  },
} as const satisfies Record<Channel, unknown>;

export const pointers = {
  keyframe: fields.KEYFRAME,
  secondKeyframe: fields.SECOND_KEYFRAME,
  timeRange: fields.TIME_RANGE,
  components: fields.CRITICAL_COMPONENTS,
  decision: fields.DRIVING_DECISION,
  lateralDirection: fields.DRIVING_DECISION_LATERAL_DIRECTION,
  causes: fields.CAUSES,
  trace: fields.COC_TRACE,
  records: fields.RECORDS,
  secondaryScenarios: fields.SECONDARY_SCENARIOS,
  provenance: fields.PROVENANCE,
  version: fields.VERSION,
  safetyFilter: fields.SAFETY_FILTER,
  safetyAnswer: fields.SAFETY_FILTER_ANSWER,

  keyframeOf: (name: KeyframeName): string => KEYFRAMES[name].at,
  keyframeTime: (name: KeyframeName): string => KEYFRAMES[name].time,
  keyframeRange: (end: "range_start" | "range_end"): string => KEYFRAME_RANGE[end],
  rangeTime: (end: "start" | "end"): string => RANGE_ENDS[end].time,
  rangeFrame: (end: "start" | "end"): string => RANGE_ENDS[end].frame,
  component: fields.criticalComponentsItem,
  componentPart: (n: number, part: ComponentPart): string => COMPONENT_PARTS[part](n),
  decisionOf: (channel: Channel): string => CHANNELS[channel].decision,
  causesOf: (channel: Channel): string => CHANNELS[channel].causes,
  causeComponents: (channel: Channel): string => CHANNELS[channel].components,
  unobservedReason: (channel: Channel): string => CHANNELS[channel].unobserved,
  record: (id: string): string => fields.RECORDS + pointer(id),
} as const;

/** Fields that Stage I fills; all others open with Stage II. */
export const STAGE_ONE_FIELDS: readonly string[] = [pointers.components, pointers.keyframe];

/** Fields that a draft fills in and that a person must have accepted or changed before submitting. */
export const DRAFTED_FIELDS: readonly string[] = [
  pointers.decisionOf("longitudinal"),
  pointers.decisionOf("lateral"),
  pointers.causesOf("longitudinal"),
  pointers.causesOf("lateral"),
  pointers.trace,
];

/** Did the draft say something in the field at `path`? "No change", which is null, is said of a decision. */
export function isFilled(path: string, before: Json | undefined): boolean {
  if (before === null) return path === pointers.decisionOf("longitudinal") || path === pointers.decisionOf("lateral");
  return before !== undefined && before !== "" && !(Array.isArray(before) && before.length === 0);
}

/** Fields that an adjudication compares, in the order of the form. */
export const COMPARED_FIELDS: readonly string[] = [
  pointers.keyframe,
  pointers.timeRange,
  pointers.components,
  pointers.decisionOf("longitudinal"),
  pointers.decisionOf("lateral"),
  pointers.lateralDirection,
  pointers.causesOf("longitudinal"),
  pointers.causesOf("lateral"),
  pointers.trace,
  pointers.records,
  pointers.secondaryScenarios,
];

/** Fields that the service writes itself. */
export const SERVICE_FIELDS: ReadonlySet<string> = new Set([pointers.provenance, pointers.version, pointers.safetyFilter]);

/** Fields that wait for the answer of the safety filter. */
export const AFTER_SAFETY: readonly string[] = [pointers.decision, pointers.causes, pointers.trace];

/** Sections of the form by the top-level field that they hold. */
export const SECTION_OF_FIELD: Readonly<Record<string, string>> = {
  critical_components: "components",
  driving_decision: "decisions",
  causes: "causes",
  coc_trace: "trace",
  records: "records",
  secondary_scenarios: "records",
};

/** Top-level fields: [Chinese, English]. */
export const fieldNames: Readonly<Record<string, TextPair>> = fields.TOP_NAMES;

const { description, ...otherMembers } = fields.MEMBER_NAMES;

/** Members of these fields, in the order of the form (a component's description first): [Chinese, English]. */
export const memberNames: Readonly<Record<string, TextPair>> = { description, ...otherMembers };

/** Members that follow from the times beside them: shown to nobody. */
export const HIDDEN_MEMBERS: ReadonlySet<string> = new Set(["frame_idx", "start_frame_idx", "end_frame_idx", "type", "id"]);

/** Is the field at `path` such a member? */
export const isHidden = (path: string): boolean => HIDDEN_MEMBERS.has(path.slice(path.lastIndexOf("/") + 1));
