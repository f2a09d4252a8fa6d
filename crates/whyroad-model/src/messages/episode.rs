//! One episode as mining writes it to `episodes.jsonl`: the content of `episodes.parquet`, and the texts that the
//! report and the label drafts need. Not one of DATA_FORMAT.md's messages.

use super::ego_response::EgoResponse;
use super::label::{Keyframe, TimeRange};
use super::mining::MatchedCondition;
use crate::{Bilingual, ClipId, DriveId, ScenarioId, TrackId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A stretch of a drive in which one leaf's rule held, with the evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EpisodeRecord {
    /// Id, the same as in `episodes.parquet`.
    pub episode_id: String,
    /// The leaf.
    pub scenario_id: ScenarioId,
    /// The drive.
    pub drive_id: DriveId,
    /// The clip that the keyframe is in.
    pub clip_id: ClipId,
    /// The target that the rule bound; null for rules without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_id: Option<TrackId>,
    /// Object for each role, where the rule binds two objects (`{"lead": .., "obstacle": ..}`); empty otherwise.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub roles: BTreeMap<String, TrackId>,
    /// From start to end; frames count from the clip's first frame and are clamped to the clip.
    pub time_range: TimeRange,
    /// The keyframe; its frame counts from the clip's first frame.
    pub keyframe: Keyframe,
    /// The second keyframe, where the labeling spec has two and it was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<Keyframe>,
    /// Match score, 0 to 1: the share of such episodes that is right where `calibrated`, else the margin score.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub score: f64,
    /// How far the conditions are exceeded, 0.5 to 1; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub margin_score: Option<f64>,
    /// False where no share is known for the class; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<bool>,
    /// True when arbitration chose this leaf for its keyframe (LABELING.md 1, MECE).
    pub is_primary: bool,
    /// The primary episode that this one is secondary to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub primary_episode_id: Option<String>,
    /// Whether the ego responded to the trigger; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ego_response: Option<EgoResponse>,
    /// How the keyframe was found, from the labeling spec.
    pub keyframe_rule: Bilingual,
    /// Conditions of the rule with their values at the keyframe.
    pub conditions_matched: Vec<MatchedCondition>,
    /// Signals that the rule read, by catalog name, sorted.
    pub signals: Vec<String>,
    /// The rule that found it: a hash of all that the rule is made of, 12 hex digits; absent in files of earlier
    /// versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule_version: Option<String>,
}
