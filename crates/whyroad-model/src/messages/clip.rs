//! Clip metadata (DATA_FORMAT.md 3.1), scenario pre-label (3.2), keyframe suggestion (3.3).

use super::label::{KeyframeType, TimeRange};
use crate::Nanos;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `{"clip_metadata": {...}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClipMetadataMessage {
    /// The clip.
    pub clip_metadata: ClipMetadata,
}

/// What an annotator sees of a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClipMetadata {
    /// Id.
    pub clip_id: String,
    /// Vehicle or fleet.
    pub source: String,
    /// Time of the first frame.
    pub capture_time: Nanos,
    /// Length, s.
    pub duration_sec: f64,
    /// Nominal frames per second.
    pub frame_rate: f64,
    /// Number of frames.
    pub total_frames: u32,
    /// What was recorded.
    pub data_sources: DataSources,
    /// What mining found, when it found something.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pre_labels: Option<PreLabels>,
    /// Drive that the clip was cut from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive_id: Option<String>,
    /// City or road network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Identity of the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map_ref: Option<String>,
    /// License of the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
}

/// Kinds of data in a clip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DataSources {
    /// Cameras by name.
    pub video: Vec<String>,
    /// Other sensors by name.
    pub sensor: Vec<String>,
    /// Vehicle bus.
    pub can: bool,
    /// Map.
    pub map: bool,
}

/// Best guess of mining for a clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreLabels {
    /// Class.
    pub scenario: PreLabelScenario,
    /// Match score, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub mining_score: f64,
    /// `rule_based` or another method.
    pub mining_method: String,
}

/// Class in a clip's pre-labels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PreLabelScenario {
    /// L1 id.
    pub l1: String,
    /// L2 id.
    pub l2: String,
    /// L3 id where the rule states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub l3: Option<String>,
}

/// `{"scenario_pre_label": {...}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioPreLabelMessage {
    /// The pre-label.
    pub scenario_pre_label: ScenarioPreLabel,
    /// Episode that this refers to, in a file of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episode_id: Option<String>,
    /// Clip that this refers to, in a file of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_id: Option<String>,
}

/// Mining's proposal for one episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioPreLabel {
    /// L1 id.
    pub l1: String,
    /// L2 id.
    pub l2: String,
    /// L3 id once a person has confirmed it; null in a proposal.
    #[serde(default)]
    pub l3: Option<String>,
    /// 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confidence: f64,
    /// Conditions of the rule that held, in words.
    pub mining_conditions_matched: Vec<String>,
    /// The variant that mining suggests.
    #[serde(default)]
    pub suggested_l3: Option<String>,
}

/// `{"keyframe_suggestion": {...}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct KeyframeSuggestionMessage {
    /// The suggestion.
    pub keyframe_suggestion: KeyframeSuggestion,
    /// Episode that this refers to, in a file of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episode_id: Option<String>,
    /// Clip that this refers to, in a file of many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_id: Option<String>,
}

/// Where mining would put the keyframe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct KeyframeSuggestion {
    /// One moment or a range.
    #[serde(rename = "type")]
    pub kind: KeyframeType,
    /// Moment.
    pub suggested_timestamp: Nanos,
    /// Frame in the clip.
    pub suggested_frame_idx: u32,
    /// The rule that found it, in words.
    pub detection_rule: String,
    /// Range to look at.
    pub context_range: TimeRange,
}
