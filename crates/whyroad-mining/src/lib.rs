//! Rules to programs to episodes: the rule language, the interpreter that defines it, the fast evaluator, episode
//! building, arbitration.
//!
//! Evaluation is a pure function of one drive's signals: no I/O, no clock, and no knowledge of single scenarios.
//! Scenarios are defined in `scenarios/`.

pub mod cases;
mod comparison;
mod deviation;
pub mod drive;
pub mod episode;
pub mod explain;
pub mod fast;
pub mod interpret;
pub mod language;
pub mod rule;

pub use drive::{DriveEpisodes, mine_drive};
pub use episode::{Episode, Rank};
pub use rule::{CODES, Rule, RuleSet};

/// Version of the evaluation of rules: changes with its code.
pub const VERSION: &str = env!("WHYROAD_MINING_VERSION");
