//! Words of the closed lists that maps and context states are made of (`whyroad_model::vocabulary`): those that are not
//! in them are collected and reported with the nearest one that is.

use super::findings;
use std::collections::BTreeMap;
use whyroad_model::Diagnostic;

/// Words of one table that are in no list.
#[derive(Default)]
pub(super) struct UnknownWords {
    /// By column and word: how many rows have it, and the list.
    found: BTreeMap<(&'static str, String), (usize, Vec<&'static str>)>,
}

impl UnknownWords {
    /// `word` in lower case when it is in `known`; else it is recorded under `column`.
    pub fn check(&mut self, column: &'static str, word: &str, known: &[&'static str]) -> Option<String> {
        let word = word.to_ascii_lowercase();
        if known.contains(&word.as_str()) {
            return Some(word);
        }
        self.found.entry((column, word)).or_insert_with(|| (0, known.to_vec())).0 += 1;
        None
    }

    pub fn diagnostics(&self, file: &str) -> Vec<Diagnostic> {
        let tell = |((column, word), (rows, known)): (&(&str, String), &(usize, Vec<&str>))| {
            findings::unknown_word(file, column, word, *rows, known)
        };
        self.found.iter().map(tell).collect()
    }
}
