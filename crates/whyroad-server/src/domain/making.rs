//! Creating tasks: from episodes, from mined folders, from files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use whyroad_model::Bilingual;
use whyroad_model::messages::EpisodeRecord;

/// Body of `POST /projects/{p}/tasks:create`. Exactly one of `episodes` and `mined`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CreateTasks {
    /// Episodes as `whyroad mine` writes them.
    #[schemars(with = "Vec<Value>")]
    pub episodes: Vec<EpisodeRecord>,
    /// Name of a mined folder that was given to the service at its start (`GET /mined`).
    pub mined: Option<String>,
    /// Maximum number of tasks.
    pub limit: Option<u32>,
    /// Maximum number of episodes per L3 class.
    pub per_leaf: Option<u32>,
    /// Annotators per episode (independent); default 1.
    pub overlap: Option<u32>,
    /// Higher values come first.
    pub priority: i64,
    /// Secondary episodes too.
    pub secondary: bool,
    /// Episodes whose keyframe is the first frame of their drive too: there is no history to label from.
    pub without_history: bool,
    /// `zh` or `en`: the queue gives these tasks only to annotators of this language. Default: the project's language,
    /// and all annotators.
    pub lang: Option<String>,
}

/// Body of `POST /projects/{p}/mined/{m}/tasks`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EpisodeTask {
    /// Drive of the episode.
    pub drive: String,
    /// Class of the episode.
    pub scenario: String,
    /// Id of the episode.
    pub episode: String,
    /// The class of the task (an L3, or an L2 of unknown variant), if it is not that of the episode; required where no
    /// class explains the episode.
    #[serde(default)]
    pub as_class: Option<String>,
    /// Higher values come first.
    #[serde(default)]
    pub priority: i64,
}

/// Result of creating tasks.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Created {
    /// Ids of the new tasks.
    pub tasks: Vec<String>,
    /// Episodes that already had a task.
    pub known: u32,
    /// Episodes that were not used: the sum of the next four.
    pub left_out: u32,
    /// Of these, beyond a limit. Once the limit of tasks is reached, also episodes that have a task already.
    pub over_limit: u32,
    /// Of these, secondary, where secondary episodes were not requested.
    pub secondary: u32,
    /// Of these, of no class of the taxonomy.
    pub no_class: u32,
    /// Of these, with the first frame of their drive as keyframe, where such episodes were not requested.
    pub no_history: u32,
    /// Episodes with new tasks whose window (2 s before the keyframe, 6 s after it) reaches beyond their drive: their
    /// labels cannot become samples of the default spec of a data set.
    pub short_window: u32,
    /// Episodes without a usable drive, with the reason: the first hundred.
    pub lost: Vec<LostEpisode>,
    /// Further episodes without a usable drive.
    pub more: u32,
}

/// An episode from which no task could be created.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LostEpisode {
    /// Its id.
    pub episode: String,
    /// Why.
    pub text: Bilingual,
}

/// Folders of mining results that were given to the service at its start.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MinedFolders {
    /// By name.
    pub items: Vec<MinedFolder>,
}

/// A folder of mining results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MinedFolder {
    /// Value for `mined`.
    pub name: String,
    /// Episodes in it.
    pub episodes: u32,
}

/// Answer of `POST /projects/{p}/import`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Imported {
    /// Tasks created.
    pub tasks: u32,
    /// Tasks that already existed.
    pub known: u32,
    /// Lines that could not be read, with the reason: the first hundred.
    pub lost: Vec<LostLine>,
    /// Further lines that could not be read.
    pub more: u32,
}

/// A line that could not be read.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LostLine {
    /// Its number, from 1.
    pub line: u32,
    /// Why.
    pub text: Bilingual,
}
