//! Prediction targets, and how they are scored.

use crate::SplitName;
use serde::Serialize;
use whyroad_model::Bilingual;

/// Name of a null decision where a class needs a name: "no change of decision".
pub const NO_CHANGE: &str = "no_change";

/// Settings for scores and intervals.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Split that the predictions are for.
    pub split: SplitName,
    /// Bootstrap resamples.
    pub resamples: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { split: SplitName::Test, resamples: 1000, seed: 0 }
    }
}

/// A prediction target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// Longitudinal decision.
    Longitudinal,
    /// Lateral decision.
    Lateral,
    /// `scenario_id`.
    Leaf,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 3] = [Self::Longitudinal, Self::Lateral, Self::Leaf];

    /// `longitudinal`, `lateral`, `leaf`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Longitudinal => "longitudinal",
            Self::Lateral => "lateral",
            Self::Leaf => "leaf",
        }
    }

    /// Its name in a text for people.
    pub fn title(self) -> Bilingual {
        match self {
            Self::Longitudinal => Bilingual::new("纵向决策", "longitudinal"),
            Self::Lateral => Bilingual::new("横向决策", "lateral"),
            Self::Leaf => Bilingual::new("L3 场景", "leaf"),
        }
    }
}
