//! A sample as the baseline sees it, and the settings of the training.

use super::features::{self, Features, LastAction};
use crate::Sample;
use crate::score::truth::Truth;
use serde::{Deserialize, Serialize};

/// A sample as the baseline sees it.
#[derive(Clone, Debug)]
pub struct Row {
    /// The correct answer.
    pub truth: Truth,
    /// The state known at t0.
    pub features: Features,
    /// The ego's last meta actions.
    pub last: LastAction,
    /// Sampling weight.
    pub weight: f64,
}

impl Row {
    /// From a sample.
    pub fn of(sample: &Sample) -> Self {
        Self {
            truth: Truth::of(sample),
            features: features::of(sample),
            last: features::last_action(sample),
            weight: sample.weight,
        }
    }
}

/// Settings of the training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Trees per class.
    pub rounds: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rounds: 60, seed: 0 }
    }
}
