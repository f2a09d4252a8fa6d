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
    /// What the leaf obliges the annotator to note (TAXONOMY.md last column), by record id. Since 2.1.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub records: BTreeMap<String, serde_json::Value>,
    /// For each decision the components that cause it. Since 2.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub causes: Option<Causes>,
    /// The second moment of the leaves that have two (LABELING.md 4, `cutout_reveal`). Since 2.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<Keyframe>,
    /// Full ids of the other triggers that were active (LABELING.md 1). Since 2.1.
    #[serde(default, deserialize_with = "none_as_empty", skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<Vec<String>>")]
    pub secondary_scenarios: Vec<String>,
    /// Who made it, with what. Since 2.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

impl CocLabel {
    /// The same in format 2.0.0: without everything that 2.1 added.
    #[must_use]
    pub fn to_2_0(mut self) -> Self {
        self.version = Some("2.0.0".to_owned());
        self.records.clear();
        (self.causes, self.second_keyframe, self.provenance) = (None, None, None);
        self.secondary_scenarios.clear();
        for c in &mut self.critical_components {
            c.id = None;
            c.evidence_times.clear();
            c.linked_objects.clear();
        }
        self
    }
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

/// A field that must be there and may be null. schemars, left alone, takes an `Option` to be a field that may be
/// absent.
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
    /// Name of the component within the label: what `causes` refers to. Since 2.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// When it could be seen; never after the keyframe. Since 2.1.
    #[serde(default, deserialize_with = "none_as_empty", skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<Vec<Nanos>>")]
    pub evidence_times: Vec<Nanos>,
    /// Track ids of the objects that it speaks of. Since 2.1.
    #[serde(default, deserialize_with = "none_as_empty", skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<Vec<String>>")]
    pub linked_objects: Vec<String>,
}

/// Causes of the decision, a channel each; a channel without a decision has none (LABELING.md 6, causal coverage).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Causes {
    /// Of the longitudinal decision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longitudinal: Option<Cause>,
    /// Of the lateral decision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral: Option<Cause>,
}

/// Components that cause a decision, or why none could be observed. One of the two.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Cause {
    /// Ids of critical components.
    #[serde(default, deserialize_with = "none_as_empty", skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<Vec<String>>")]
    pub components: Vec<String>,
    /// The cause is UNOBSERVED, for this reason.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unobserved: Option<String>,
}

closed_set!(
    /// Who made a label.
    ProvenanceSource {
        /// A mining rule.
        Rule = "rule",
        /// A model.
        Model = "model",
        /// A person.
        Person = "person",
    }
);

/// Who made a label, with what.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Kind of author.
    pub source: ProvenanceSource,
    /// The author: a rule's class, a model's name, a person's id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// When.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Nanos>,
    /// Program and version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<String>,
    /// Versions of what it was made with: `taxonomy`, `rules`, `model`, ...
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub versions: BTreeMap<String, String>,
}

/// `null` where an optional list may stand is the same as none, as it is for every other optional field.
fn none_as_empty<'de, D: serde::Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or_default())
}
