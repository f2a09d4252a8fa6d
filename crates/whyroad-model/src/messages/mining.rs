//! The mining interface: query (DATA_FORMAT.md 5.1) and result (5.2).

use super::coverage::DriveList;
use super::ego_response::EgoResponse;
use super::query_clause::QueryClause;
use crate::{Bilingual, Nanos, ScenarioId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// `{"mining_query": {...}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MiningQueryMessage {
    /// The query.
    pub mining_query: MiningQuery,
}

/// What to look for. All conditions hold at once, for the stated time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MiningQuery {
    /// Name of the query, repeated in the result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub query_id: Option<String>,
    /// Class that the result is for: L1, L2 or leaf.
    pub scenario_id: ScenarioId,
    /// What must hold together.
    pub conditions: Vec<QueryClause>,
    /// How long they must hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constraints: Option<TimeConstraints>,
    /// Maximum number of clips, the best first; absent or null is all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_limit: Option<u32>,
}

/// Bounds, in seconds, on how long the conditions hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeConstraints {
    /// At least, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition_duration_min: Option<f64>,
    /// At most, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition_duration_max: Option<f64>,
}

/// `{"mining_result": {...}}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MiningResultMessage {
    /// The result.
    pub mining_result: MiningResult,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MiningResult {
    /// The query's id.
    pub query_id: String,
    /// The query's class.
    pub scenario_id: ScenarioId,
    /// Episodes that match.
    pub total_matched: u64,
    /// Episodes listed below.
    pub returned: u64,
    /// Best first.
    pub clips: Vec<MinedClip>,
    /// Computed over the clips listed.
    pub statistics: MiningStatistics,
    /// Leaves that some drives could not answer, with the signals that those drives lack.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_observable: Vec<NotObservable>,
}

/// One match.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MinedClip {
    /// The clip.
    pub clip_id: String,
    /// 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub match_score: f64,
    /// Where the keyframe is.
    pub keyframe_suggestion: MinedKeyframe,
    /// The deciding conditions with their values at the keyframe, at most five.
    pub conditions_matched: Vec<MatchedCondition>,
    /// The leaf, where the query was for more than one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scenario_id: Option<ScenarioId>,
    /// The episode's id in `episodes.parquet`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episode_id: Option<String>,
    /// The target, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_id: Option<String>,
    /// Whether the ego responded to the trigger.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ego_response: Option<EgoResponse>,
    /// False where the score is not a share of right episodes, because none is known for the class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<bool>,
}

/// Keyframe of a match.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MinedKeyframe {
    /// Moment.
    pub timestamp: Nanos,
    /// Frame in the clip.
    pub frame_idx: u32,
}

/// A condition and what it measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MatchedCondition {
    /// As written, with unit: `target_vehicle.lateral_offset > 0.5m`.
    pub condition: String,
    /// The value in the condition's unit; null when unknown there.
    pub actual_value: serde_json::Value,
    /// The condition in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<Bilingual>,
    /// The value in words, with its unit; unset where it is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actual_words: Option<Bilingual>,
}

/// Figures over the clips of the result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MiningStatistics {
    /// Clips returned by score, tenths: `{"0.9-1.0": 523}`; empty tenths left out.
    pub score_distribution: BTreeMap<String, u64>,
    /// Clips returned whose class is not calibrated.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub uncalibrated: u64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// A leaf that cannot be decided on some drives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NotObservable {
    /// The leaf.
    pub scenario_id: ScenarioId,
    /// Drives on which it cannot be decided.
    #[schemars(with = "Vec<String>")]
    pub drives: DriveList,
    /// Signals that they lack.
    pub missing_signals: Vec<String>,
}
