//! Rules to programs to episodes: the rule language, its reference evaluator, episode building, arbitration.
//!
//! The evaluator is a pure function of one drive's signals: no I/O, no clock, and no knowledge of what a
//! scenario is about. What a scenario is stands in `scenarios/`; only [`engine`] reads a lake.

pub mod evaluate;
pub mod language;
