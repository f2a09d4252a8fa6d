//! The label checker.

mod json;
mod lexicon;
mod trace;

pub use lexicon::Lexicon;
