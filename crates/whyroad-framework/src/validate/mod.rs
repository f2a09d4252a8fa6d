//! The label checker.

mod lexicon;

pub use lexicon::Lexicon;
