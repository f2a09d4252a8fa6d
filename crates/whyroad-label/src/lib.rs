//! Semantics of a label: the checks of every document, and drafts from what mining found.
//!
//! Pure functions: nothing here opens a file, reads a clock or knows how drives and labels are stored.

pub mod agreement;
pub mod carry;
pub mod check;
pub mod counterfactual;
pub mod draft;
mod driven;
pub mod episode_of;
pub mod facts;
pub mod import;
pub mod judged;
pub mod merge;
pub mod migrate;

#[cfg(test)]
#[path = "../../whyroad-model/testing/hand_drive.rs"]
mod fixture;
