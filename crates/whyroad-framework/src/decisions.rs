//! Names and meanings of the driving decisions (`schema/driving_decisions.yaml`). The closed sets themselves
//! are `whyroad_model::decision`; loading checks that the two are equal.

mod read;

pub use read::read_decisions;

use whyroad_model::Bilingual;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};

/// The decisions of both channels, in the order of LABELING.md 2.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DecisionSets {
    /// `major.minor.patch`.
    pub version: String,
    /// Meaning of null: no change of decision.
    pub null_decision: DecisionText,
    /// Along the path.
    pub longitudinal: Vec<LongitudinalText>,
    /// Across the path.
    pub lateral: Vec<LateralText>,
}

/// Texts of one longitudinal decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LongitudinalText {
    /// Which.
    pub id: Longitudinal,
    /// In words.
    pub text: DecisionText,
}

/// Texts of one lateral decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LateralText {
    /// Which.
    pub id: Lateral,
    /// In words.
    pub text: DecisionText,
    /// The directions it may have; empty when it must have none.
    pub directions: Vec<LateralDirection>,
}

/// Texts of a decision.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DecisionText {
    /// Short name.
    pub name: Bilingual,
    /// Its meaning.
    pub meaning: Bilingual,
    /// Similar decisions and how they differ.
    pub not: Option<Bilingual>,
    /// The row of AR1 table 1 that it maps to (LABELING.md 2), where there is one.
    pub ar1: Option<String>,
}

impl DecisionSets {
    /// Name and meaning of a longitudinal decision.
    pub fn longitudinal(&self, id: Longitudinal) -> Option<&DecisionText> {
        self.longitudinal.iter().find(|d| d.id == id).map(|d| &d.text)
    }

    /// Name and meaning of a lateral decision.
    pub fn lateral(&self, id: Lateral) -> Option<&DecisionText> {
        self.lateral.iter().find(|d| d.id == id).map(|d| &d.text)
    }

    /// Displayed name of a decision of either channel; its id where the file has no name.
    pub fn name(&self, id: &str) -> Bilingual {
        let along = Longitudinal::from_id(id).and_then(|d| self.longitudinal(d));
        let text = along.or_else(|| Lateral::from_id(id).and_then(|d| self.lateral(d)));
        text.map_or_else(|| Bilingual::same(id), |t| t.name.clone())
    }
}
