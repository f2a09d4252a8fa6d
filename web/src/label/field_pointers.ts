// The fields of a label as the page uses them: where they are (JSON pointers, RFC 6901) and what people call them. The
// only module of the page that spells a pointer or a field's name; everything else refers to `pointers` and
// `fieldNames`.
import type { TextPair } from "../text/screen_texts.ts";
import type { Channel } from "./framework.ts";
import { pointer } from "./pointer.ts";

export type KeyframeName = "keyframe" | "second_keyframe";
export type ComponentPart = "id" | "description" | "category" | "uncertainty" | "evidence_times" | "linked_objects";

export const pointers = {
  keyframe: "/keyframe",
  secondKeyframe: "/second_keyframe",
  timeRange: "/time_range",
  components: "/critical_components",
  decision: "/driving_decision",
  lateralDirection: "/driving_decision/lateral_direction",
  causes: "/causes",
  trace: "/coc_trace",
  records: "/records",
  secondaryScenarios: "/secondary_scenarios",
  provenance: "/provenance",
  version: "/version",

  keyframeOf: (name: KeyframeName): string => `/${name}`,
  keyframeTime: (name: KeyframeName): string => `/${name}/timestamp`,
  keyframeRange: (end: "range_start" | "range_end"): string => `/keyframe/${end}`,
  rangeTime: (end: "start" | "end"): string => `/time_range/${end}_timestamp`,
  rangeFrame: (end: "start" | "end"): string => `/time_range/${end}_frame_idx`,
  component: (n: number): string => `/critical_components/${n}`,
  componentPart: (n: number, part: ComponentPart): string => `/critical_components/${n}/${part}`,
  decisionOf: (channel: Channel): string => `/driving_decision/${channel}`,
  causesOf: (channel: Channel): string => `/causes/${channel}`,
  causeComponents: (channel: Channel): string => `/causes/${channel}/components`,
  unobservedReason: (channel: Channel): string => `/causes/${channel}/unobserved`,
  record: (id: string): string => pointer("records", id),
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
export const SERVICE_FIELDS: ReadonlySet<string> = new Set([pointers.provenance, pointers.version]);

/** Sections of the form by the top-level field that they hold. */
export const SECTION_OF_FIELD: Readonly<Record<string, string>> = {
  critical_components: "components",
  driving_decision: "decisions",
  causes: "causes",
  coc_trace: "trace",
  records: "records",
  secondary_scenarios: "records",
};

/** Top-level fields in the order of the form: [Chinese, English]. */
export const fieldNames: Readonly<Record<string, TextPair>> = {
  critical_components: ["关键要素", "Critical components"],
  keyframe: ["关键帧", "Keyframe"],
  second_keyframe: ["第二关键帧", "Second keyframe"],
  time_range: ["时间范围", "Time range"],
  driving_decision: ["决策", "Decision"],
  causes: ["原因", "Causes"],
  coc_trace: ["因果描述", "Causal trace"],
  records: ["必填记录", "Required records"],
  scenario: ["场景", "Scenario"],
  secondary_scenarios: ["次场景", "Secondary scenarios"],
};

/** Members of these fields, in the order of the form: [Chinese, English]. */
export const memberNames: Readonly<Record<string, TextPair>> = {
  description: ["描述", "description"],
  category: ["类别", "category"],
  uncertainty: ["不确定性", "uncertainty"],
  evidence_times: ["证据时刻", "evidence times"],
  linked_objects: ["关联目标", "linked objects"],
  timestamp: ["时刻", "time"],
  range_start: ["范围起点", "range start"],
  range_end: ["范围终点", "range end"],
  start_timestamp: ["起点", "start"],
  end_timestamp: ["终点", "end"],
  longitudinal: ["纵向", "longitudinal"],
  lateral: ["横向", "lateral"],
  lateral_direction: ["方向", "direction"],
  components: ["要素", "components"],
  unobserved: ["未观测到", "unobserved"],
};

/** Members that follow from the times beside them: shown to nobody. */
export const HIDDEN_MEMBERS: ReadonlySet<string> = new Set(["frame_idx", "start_frame_idx", "end_frame_idx", "type", "id"]);
