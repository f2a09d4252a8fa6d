//! What questions to a language model have cost.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a run of questions to a language model has spent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ModelSpent {
    /// Requests sent, retries among them.
    pub requests: u64,
    /// Answers taken from the cache: they cost nothing.
    pub cached: u64,
    /// Tokens of questions.
    pub input_tokens: u64,
    /// Tokens of answers.
    pub output_tokens: u64,
    /// Answers whose tokens the endpoint does not state: the sums lack them.
    pub answers_without_count: u64,
    /// Cost of the counted tokens; null without prices.
    pub cost: Option<f64>,
}

impl ModelSpent {
    /// Both together; the cost is unknown where one of them is unknown and has tokens.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let free = |s: &Self| s.input_tokens + s.output_tokens == 0;
        let cost = match (self.cost, other.cost) {
            (Some(a), Some(b)) => Some(a + b),
            (Some(a), None) if free(other) => Some(a),
            (None, Some(b)) if free(self) => Some(b),
            _ => None,
        };
        Self {
            requests: self.requests + other.requests,
            cached: self.cached + other.cached,
            input_tokens: self.input_tokens + other.input_tokens,
            output_tokens: self.output_tokens + other.output_tokens,
            answers_without_count: self.answers_without_count + other.answers_without_count,
            cost,
        }
    }
}
