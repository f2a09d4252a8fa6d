//! The statements of a trace about the ego's decision, and whether they agree with the label (LABELING.md 7).
//!
//! [`mention`] finds every span that names a decision and how certainly it is attributed to the ego; [`judge`] compares
//! that with the label. This is not a language parser: it reads clause by clause with the words of the lexicon, and
//! reports nothing where it is not certain.

pub(super) mod aftermath;
mod form;
mod judge;
mod mention;

#[cfg(test)]
pub(super) use form::Form;
pub(in crate::check) use form::form;
pub(super) use judge::{TraceVerdict, judge};
pub(in crate::check) use mention::Mention;
pub(in crate::check) use mention::{Force, Reading, read};

#[cfg(test)]
mod tests;
