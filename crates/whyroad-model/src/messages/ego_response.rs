//! Whether the ego responded to a trigger: a part of episodes and of mining results.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Whether the ego responded to the trigger of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EgoResponse {
    /// The ego did what the rule counts as a response (it slowed, waited, moved aside), or the rule's match is itself
    /// the ego's action.
    Observed,
    /// It did not respond in the whole time range: a missed response, or one that was not needed.
    Absent,
    /// The log does not show it: it ends before, or lacks a signal.
    Unknown,
}

impl EgoResponse {
    /// Its name in messages and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Observed => "observed",
            Self::Absent => "absent",
            Self::Unknown => "unknown",
        }
    }
}
