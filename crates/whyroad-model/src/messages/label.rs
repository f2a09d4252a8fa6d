//! The CoC label (DATA_FORMAT.md 4) and the scenario label (2.2).

use crate::Nanos;
use crate::decision::{Lateral, LateralDirection, Longitudinal, closed_set};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `{"scenario_label": {...}}` (DATA_FORMAT.md 2.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioLabelMessage {
    /// The label.
    pub scenario_label: ScenarioLabel,
}

/// Place of a sample in the taxonomy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioLabel {
    /// L1 id.
    pub l1: String,
    /// L2 id.
    pub l2: String,
    /// L3 id, null or absent when only the L2 is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub l3: Option<String>,
    /// `l1.l2.l3`; must agree with the parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_id: Option<String>,
}

/// A finished label: one keyframe of one clip, the decision, its causes, the trace (DATA_FORMAT.md 4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CocLabel {
    /// Format version, `major.minor.patch`; absent means 2.0.0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// The clip that is labelled.
    pub clip_id: String,
    /// Class.
    pub scenario: ScenarioLabel,
    /// The part of the clip that the label speaks of; half open.
    pub time_range: TimeRange,
    /// The decision moment.
    pub keyframe: Keyframe,
    /// What the ego does first after the keyframe.
    pub driving_decision: DrivingDecision,
    /// What caused it (open set; LABELING.md 3).
    pub critical_components: Vec<CriticalComponent>,
    /// The reason in words: state, why, decision (LABELING.md 7).
    pub coc_trace: String,
    /// What the leaf obliges the annotator to note (TAXONOMY.md last column), by record id.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub records: BTreeMap<String, serde_json::Value>,
}

/// A half-open range of time, with frames where they are known.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TimeRange {
    /// First moment.
    pub start_timestamp: Nanos,
    /// One past the last moment.
    pub end_timestamp: Nanos,
    /// First frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_frame_idx: Option<u32>,
    /// One past the last frame; equal to the clip's frame count at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_frame_idx: Option<u32>,
}

closed_set!(
    /// Kind of keyframe (LABELING.md 4).
    KeyframeType {
        /// One moment.
        Reactive = "reactive",
        /// A range.
        Proactive = "proactive",
    }
);

closed_set!(
    /// How sure the annotator or the situation lets one be.
    Uncertainty {
        /// Plain.
        Low = "low",
        /// Blind spot, occlusion or unclear intention.
        High = "high",
    }
);

/// The decision moment (DATA_FORMAT.md 4.2).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Keyframe {
    /// Moment.
    pub timestamp: Nanos,
    /// Frame in the clip.
    pub frame_idx: u32,
    /// One moment or a range.
    #[serde(rename = "type")]
    pub kind: KeyframeType,
    /// Start of a proactive range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_start: Option<Nanos>,
    /// End of a proactive range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_end: Option<Nanos>,
}

/// At most one decision a channel; null is "no change of decision" and must be written out (LABELING.md 2).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct DrivingDecision {
    /// Along the path.
    #[serde(deserialize_with = "present")]
    #[schemars(schema_with = "decision_or_null::<Longitudinal>")]
    pub longitudinal: Option<Longitudinal>,
    /// Across the path.
    #[serde(deserialize_with = "present")]
    #[schemars(schema_with = "decision_or_null::<Lateral>")]
    pub lateral: Option<Lateral>,
    /// Side, for the lateral decisions that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_direction: Option<LateralDirection>,
}

/// An `Option` whose key must be there: serde's own default treats a missing key as null.
fn present<'de, D, T>(d: D) -> Result<Option<T>, D::Error>
where
    D: serde::Deserializer<'de>,
    T: Deserialize<'de>,
{
    Option::<T>::deserialize(d)
}

/// A field that must be there and may be null. schemars, left alone, takes an `Option` to be a field that may be absent.
fn decision_or_null<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let decision = T::json_schema(generator);
    json_schema!({
        "anyOf": [decision, { "type": "null", "description": "No change of decision." }],
    })
}

/// One cause (LABELING.md 3).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct CriticalComponent {
    /// Free category; LABELING.md 3 lists the usual ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub category: Option<String>,
    /// In words.
    pub description: String,
    /// Low or high.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
}
