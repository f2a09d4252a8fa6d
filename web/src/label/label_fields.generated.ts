// Generated from schema/label_fields.yaml: `cargo run -q -p whyroad-model --example label_fields >
// web/src/label/label_fields.generated.ts`. Do not edit.
import type { TextPair } from "../text/screen_texts.ts";

// JSON pointers (RFC 6901).
export const VERSION = "/version";
export const CLIP_ID = "/clip_id";
export const SCENARIO = "/scenario";
export const SCENARIO_L1 = "/scenario/l1";
export const SCENARIO_L2 = "/scenario/l2";
export const SCENARIO_L3 = "/scenario/l3";
export const SCENARIO_FULL_ID = "/scenario/full_id";
export const TIME_RANGE = "/time_range";
export const TIME_RANGE_START_TIMESTAMP = "/time_range/start_timestamp";
export const TIME_RANGE_END_TIMESTAMP = "/time_range/end_timestamp";
export const TIME_RANGE_START_FRAME_IDX = "/time_range/start_frame_idx";
export const TIME_RANGE_END_FRAME_IDX = "/time_range/end_frame_idx";
export const KEYFRAME = "/keyframe";
export const KEYFRAME_TIMESTAMP = "/keyframe/timestamp";
export const KEYFRAME_FRAME_IDX = "/keyframe/frame_idx";
export const KEYFRAME_TYPE = "/keyframe/type";
export const KEYFRAME_RANGE_START = "/keyframe/range_start";
export const KEYFRAME_RANGE_END = "/keyframe/range_end";
export const DRIVING_DECISION = "/driving_decision";
export const DRIVING_DECISION_LONGITUDINAL = "/driving_decision/longitudinal";
export const DRIVING_DECISION_LATERAL = "/driving_decision/lateral";
export const DRIVING_DECISION_LATERAL_DIRECTION = "/driving_decision/lateral_direction";
export const CRITICAL_COMPONENTS = "/critical_components";
export const criticalComponentsItem = (n0: number): string => `/critical_components/${n0}`;
export const criticalComponentsItemCategory = (n0: number): string => `/critical_components/${n0}/category`;
export const criticalComponentsItemDescription = (n0: number): string => `/critical_components/${n0}/description`;
export const criticalComponentsItemUncertainty = (n0: number): string => `/critical_components/${n0}/uncertainty`;
export const criticalComponentsItemId = (n0: number): string => `/critical_components/${n0}/id`;
export const criticalComponentsItemEvidenceTimes = (n0: number): string => `/critical_components/${n0}/evidence_times`;
export const criticalComponentsItemLinkedObjects = (n0: number): string => `/critical_components/${n0}/linked_objects`;
export const COC_TRACE = "/coc_trace";
export const RECORDS = "/records";
export const CAUSES = "/causes";
export const CAUSES_LONGITUDINAL = "/causes/longitudinal";
export const CAUSES_LONGITUDINAL_COMPONENTS = "/causes/longitudinal/components";
export const CAUSES_LONGITUDINAL_UNOBSERVED = "/causes/longitudinal/unobserved";
export const CAUSES_LATERAL = "/causes/lateral";
export const CAUSES_LATERAL_COMPONENTS = "/causes/lateral/components";
export const CAUSES_LATERAL_UNOBSERVED = "/causes/lateral/unobserved";
export const SECOND_KEYFRAME = "/second_keyframe";
export const SECOND_KEYFRAME_TIMESTAMP = "/second_keyframe/timestamp";
export const SECOND_KEYFRAME_FRAME_IDX = "/second_keyframe/frame_idx";
export const SECOND_KEYFRAME_TYPE = "/second_keyframe/type";
export const SECOND_KEYFRAME_RANGE_START = "/second_keyframe/range_start";
export const SECOND_KEYFRAME_RANGE_END = "/second_keyframe/range_end";
export const SECONDARY_SCENARIOS = "/secondary_scenarios";
export const SAFETY_FILTER = "/safety_filter";
export const SAFETY_FILTER_ANSWER = "/safety_filter/answer";
export const SAFETY_FILTER_REASONS = "/safety_filter/reasons";
export const SAFETY_FILTER_NOTE = "/safety_filter/note";
export const PROVENANCE = "/provenance";
export const PROVENANCE_SOURCE = "/provenance/source";
export const PROVENANCE_BY = "/provenance/by";
export const PROVENANCE_AT = "/provenance/at";
export const PROVENANCE_TOOL = "/provenance/tool";
export const PROVENANCE_VERSIONS = "/provenance/versions";

/** Names of the fields of the label: [Chinese, English]. */
export const TOP_NAMES = {
  scenario: ["场景", "Scenario"],
  time_range: ["时间范围", "Time range"],
  keyframe: ["关键帧", "Keyframe"],
  driving_decision: ["决策", "Decision"],
  critical_components: ["关键要素", "Critical components"],
  coc_trace: ["因果描述", "Causal trace"],
  records: ["必填记录", "Required records"],
  causes: ["原因", "Causes"],
  second_keyframe: ["第二关键帧", "Second keyframe"],
  secondary_scenarios: ["次场景", "Secondary scenarios"],
  safety_filter: ["安全过滤", "Safety filter"],
} as const satisfies Record<string, TextPair>;

/** Names of the members of these fields: [Chinese, English]. */
export const MEMBER_NAMES = {
  start_timestamp: ["起点", "start"],
  end_timestamp: ["终点", "end"],
  timestamp: ["时刻", "time"],
  range_start: ["范围起点", "range start"],
  range_end: ["范围终点", "range end"],
  longitudinal: ["纵向", "longitudinal"],
  lateral: ["横向", "lateral"],
  lateral_direction: ["方向", "direction"],
  category: ["类别", "category"],
  description: ["描述", "description"],
  uncertainty: ["不确定性", "uncertainty"],
  evidence_times: ["证据时刻", "evidence times"],
  linked_objects: ["关联目标", "linked objects"],
  components: ["要素", "components"],
  unobserved: ["未观测到", "unobserved"],
  answer: ["结论", "answer"],
  reasons: ["依据", "reasons"],
  note: ["说明", "note"],
} as const satisfies Record<string, TextPair>;
