//! Gold tasks and qualification: hidden tasks with known answers, and each annotator's agreement with them. For leads
//! only.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use whyroad_model::Bilingual;

/// Body of `POST /projects/{p}/gold`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewGold {
    /// Ids of accepted tasks whose labels are the known answers; at most 200.
    pub tasks: Vec<String>,
    /// Names or ids of the annotators who get a copy of each; at most 50.
    pub users: Vec<String>,
}

/// Result of `POST /projects/{p}/gold`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MadeGold {
    /// Gold tasks created.
    pub made: u32,
    /// Copies that were not created, and why.
    pub refused: Vec<GoldRefused>,
}

/// A gold task that was not created.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct GoldRefused {
    /// The accepted task.
    pub task: String,
    /// The annotator, by display name.
    pub user: String,
    /// Why.
    pub text: Bilingual,
}

/// The gold tasks of a project.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct GoldReport {
    /// By annotator.
    pub people: Vec<GoldPerson>,
    /// Newest first.
    pub tasks: Vec<GoldTask>,
}

/// Agreement of one annotator with gold answers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct GoldPerson {
    /// Display name.
    pub user: String,
    /// Gold tasks created for them.
    pub given: i64,
    /// Of these, submitted.
    pub done: i64,
    /// Mean share of fields that agree, in percent; null before the first is submitted.
    pub percent: Option<f64>,
    /// Shares of submitted tasks that agree, in percent, by field: `scenario`, `longitudinal`, `lateral`, `keyframe`,
    /// `objects`.
    pub fields: std::collections::BTreeMap<String, f64>,
    /// Resulting qualification.
    pub standing: GoldStanding,
}

/// Whether an annotator is qualified in a project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GoldStanding {
    /// The project requires no qualification.
    NotAsked,
    /// Too few gold tasks are submitted; labels are audited at the maximum rate.
    Open,
    /// Enough gold tasks agree with their answers.
    Qualified,
    /// Too few agree; labels are audited at the maximum rate.
    Failed,
}

/// One gold task.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct GoldTask {
    /// Task id of the copy.
    pub task: String,
    /// The accepted task from which it was created.
    pub source: String,
    /// Class of the known answer.
    pub scenario_id: String,
    /// Annotator for whom it was created, by display name.
    pub user: String,
    /// State of the copy.
    pub state: String,
    /// Fields that differ from the answer; null before it is submitted.
    pub differs: Option<Vec<String>>,
}
