//! What a trace says about the ego's decision, and whether that goes with the label (LABELING.md 7).
//!
//! [`mention`] finds every span where a decision is named and how firmly it is said of the ego; [`judge`]
//! compares that with the label. Not a parser of language: clause by clause, with the words of the lexicon,
//! and silent wherever it is not sure.

pub(super) mod aftermath;
mod form;
mod judge;
mod mention;

#[cfg(test)]
pub(super) use form::Form;
pub(super) use form::form;
pub(super) use judge::{TraceVerdict, judge};
pub(in crate::check) use mention::Mention;
pub(in crate::check) use mention::{Force, Reading, read};

#[cfg(test)]
mod tests;
