//! What came of mining and labelling: coverage over all leaves, the report that shows it, label drafts, and how good
//! the episodes are against a truth.
//!
//! Nothing here finds episodes or derives signals: both are handed in, because this crate must not depend on
//! the crates that make them. Nothing here writes a file; callers store what is returned.

pub mod comparison;
pub mod coverage;
pub mod evaluation;
pub mod mined;
pub mod report;

#[cfg(test)]
#[path = "../../whyroad-model/testing/hand_drive.rs"]
mod fixture;
