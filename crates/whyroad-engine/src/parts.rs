//! Mining a lake with several workers: a plan of work lists, a part folder for each worker, and one mined folder merged
//! from the parts, the same byte for byte as that of one run over the whole lake.
//!
//! The program that starts the workers (cron, SLURM, Kubernetes, Airflow, Ray, Spark) only passes files; nothing here
//! schedules, and workers are independent of each other.

mod folder;
mod merge;
mod plan;
mod wire;
mod work;

pub use folder::{Failed, Part, PartError, Versions};
pub use merge::{Expected, MergeError, Merged, merge};
pub use plan::{PlannedDrive, PlannedLake, WorkList, WorkListError, plan};
pub use work::{PartOptions, Worked, work};

use crate::output::{Question, Searched};
use serde::{Deserialize, Serialize};
use whyroad_lake::mined::MiningQuestion;
use whyroad_model::{ClipCut, Lang, ScenarioId};

/// Codes of the diagnostics about plans and parts; each has a page in the documentation.
pub const CODES: &[&str] = &[
    "mine.drive.unknown",
    "mine.drive.kills_worker",
    "merge.part.unreadable",
    "merge.part.incomplete",
    "merge.part.differs",
    "merge.drive.doubled",
    "merge.drive.missing",
    "merge.drive.changed",
    "merge.expected.unknown",
];

/// The request of a run: everything besides drives and rules that affects its results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// The question recorded in the mined folder.
    pub asked: MiningQuestion,
    /// A `mining_result` is written for each.
    pub questions: Vec<Question>,
    /// Classes for which a rule is run, in the order of the rules.
    pub classes: Vec<ScenarioId>,
    /// Source of the rules.
    pub searched: Searched,
    /// Language of texts in messages.
    pub lang: Lang,
    /// How clips are cut for episodes.
    #[serde(default)]
    pub clips: ClipCut,
}

#[cfg(test)]
mod tests;
