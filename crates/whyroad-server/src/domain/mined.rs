//! Mined episodes as people browse and judge them, without labeling.

use super::scene::{MapView, SceneView};
use super::task::Task;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use whyroad_model::Bilingual;
use whyroad_model::messages::VerdictKind;

/// A mined episode in a list.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct EpisodeCard {
    /// Id.
    pub episode_id: String,
    /// Class.
    pub scenario_id: String,
    /// Drive.
    pub drive_id: String,
    /// Clip.
    pub clip_id: String,
    /// Keyframe. Only drives whose log states dates have a time of day.
    pub keyframe: String,
    /// Seconds from the start of the drive to the keyframe; absent where the lake does not have the drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframe_s: Option<f64>,
    /// Score, 0 to 1: the share of such episodes that is right where `calibrated`, else comparable only within a class.
    pub score: f64,
    /// The score was calibrated with verdicts.
    pub calibrated: bool,
    /// It is the primary episode of its moment.
    pub is_primary: bool,
    /// The caller's verdict.
    pub verdict: Option<VerdictKind>,
}

/// A page of mined episodes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct EpisodeCards {
    /// By drive and keyframe.
    pub items: Vec<EpisodeCard>,
    /// Number of episodes that match the filter; on the first page only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total: Option<u64>,
    /// Value for `cursor`, if there are more.
    pub next: Option<String>,
}

/// One mined episode with all data for showing it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MinedEpisode {
    /// As on the screen of a task: the result of the rule, the specification of its class. The only possible action is
    /// a verdict.
    pub task: Task,
    /// Rule of the keyframe as text.
    pub keyframe_rule: Bilingual,
    /// The drive around the keyframe.
    pub scene: SceneView,
    /// The map there.
    pub map: MapView,
    /// The caller's verdict.
    pub verdict: Option<Verdict>,
}

/// Body of `POST /projects/{p}/verdicts`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewVerdict {
    /// Mined folder.
    pub mined: String,
    /// Drive of the episode.
    pub drive: String,
    /// Class of the episode.
    pub scenario: String,
    /// Id of the episode.
    pub episode: String,
    /// The verdict; null removes it.
    pub verdict: Option<VerdictKind>,
    /// For `wrong_leaf`: the correct class, if it is known; an L2 or L3 class.
    #[serde(default)]
    pub leaf: Option<String>,
    /// For `keyframe_moved`: the correct moment.
    #[serde(default)]
    pub keyframe: Option<String>,
    /// Explanation.
    #[serde(default)]
    pub note: Option<String>,
}

/// A verdict; also one line of the export (docs/reference/verdicts.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// The verdict.
    pub verdict: VerdictKind,
    /// Mined folder from which the episode was shown.
    pub mined: String,
    /// Id of the episode.
    pub episode_id: String,
    /// Drive.
    pub drive_id: String,
    /// Class that mining gave.
    pub scenario_id: String,
    /// Target of the rule.
    pub target_id: Option<String>,
    /// Start of the episode, ns since 1970 on the drive's clock.
    pub start_ns: i64,
    /// Its keyframe as mined.
    pub keyframe_ns: i64,
    /// Its end, exclusive.
    pub end_ns: i64,
    /// Its score, 0 to 1.
    pub score: f64,
    /// The correct class, of `wrong_leaf`.
    pub right_scenario_id: Option<String>,
    /// The correct keyframe, of `keyframe_moved`.
    pub right_keyframe_ns: Option<i64>,
    /// Explanation.
    pub note: Option<String>,
    /// Login name of the author.
    pub by: String,
    /// When, ms since 1970.
    pub at: i64,
}

/// Episodes similar to one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SimilarEpisodes {
    /// The most similar first.
    pub items: Vec<SimilarEpisode>,
    /// Episodes that were compared.
    pub compared: u64,
}

/// An episode similar to another.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct SimilarEpisode {
    /// The episode.
    pub episode: EpisodeCard,
    /// 1 for identical, near 0 for a different one.
    pub similarity: f64,
}
