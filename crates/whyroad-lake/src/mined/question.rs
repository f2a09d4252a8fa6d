//! The question that a mined folder answers, recorded with the results: results of one question are never silently
//! continued or replaced by those of another.

use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;
use whyroad_model::ScenarioId;

/// The question that a mining run asks. How it runs (cores, limits, language) is not part of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum MiningQuestion {
    /// The rules of the framework.
    Framework {
        /// Only these classes, sorted; empty is all of them.
        scenarios: Vec<ScenarioId>,
    },
    /// A custom rule.
    Rule {
        /// Class of what it finds.
        scenario: ScenarioId,
        /// Its text, or the content of its file.
        rule: String,
        /// What its target can be, where that was given beside the text.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        target: Option<String>,
    },
    /// A `mining_query` message.
    Query {
        /// The message.
        query: serde_json::Value,
    },
}

impl MiningQuestion {
    /// `None` when the file does not exist or is not a question.
    pub(super) fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&fs::read(path).ok()?).ok()
    }
}
