//! The label checker.

mod json;
mod lexicon;

pub use lexicon::Lexicon;
