//! Rules to programs to episodes: the rule language, its reference evaluator, episode building, arbitration.
//!
//! The evaluator is a pure function of one drive's signals: no I/O, no clock, and no knowledge of what a
//! scenario is about. What a scenario is stands in `scenarios/`; only [`engine`] reads a lake.

pub mod cases;
pub mod drive;
pub mod engine;
pub mod episode;
pub mod evaluate;
pub mod explain;
pub mod fast;
pub mod language;
pub mod output;
pub mod rule;

pub use drive::{DriveEpisodes, mine_drive};
pub use episode::{Episode, Rank};
pub use rule::{CODES, Rule, RuleSet};
