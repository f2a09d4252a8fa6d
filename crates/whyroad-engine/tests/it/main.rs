//! One binary for all integration tests of the engine.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

mod again;
mod drafts;
mod incremental;
mod label_checks;
mod quality;
mod refav;
mod stage_one;
