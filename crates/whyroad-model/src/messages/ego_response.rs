//! Whether the ego answered a trigger: a part of episodes and of mining results.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Whether the ego answered what triggered an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EgoResponse {
    /// The ego did what the rule counts as an answer (it slowed, waited, moved aside), or the rule's match is itself
    /// what the ego did.
    Observed,
    /// It did not, in the whole time range: a missed response, or one that was not needed.
    Absent,
    /// The log cannot tell: it ends before, or lacks a signal.
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
