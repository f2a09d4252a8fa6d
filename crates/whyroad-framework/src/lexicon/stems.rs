//! Stems of what the ego does (`stems` of `schema/decision_lexicon.yaml`), for words that no phrase holds. They support
//! a decision and never contradict one.

use super::{Says, Words};
use serde::Deserialize;
use whyroad_model::decision::{Lateral, Longitudinal};

/// The stems of one set of decisions.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StemWords {
    says: Says,
    #[serde(default)]
    zh: Vec<String>,
    #[serde(default)]
    en: Vec<String>,
}

/// All stems, and what denies them.
#[derive(Clone, Debug, Default)]
pub struct Stems {
    stems: Vec<(Says, Vec<String>)>,
    denied: Vec<String>,
}

impl Stems {
    pub(super) fn new(raw: &[StemWords], denied: &Words) -> Self {
        let words = |w: &StemWords| w.zh.iter().chain(&w.en).cloned().collect();
        Self {
            stems: raw.iter().map(|w| (w.says.clone(), words(w))).collect(),
            denied: denied.all().map(str::to_owned).collect(),
        }
    }

    /// Byte at which `clause` has an undenied stem of one of the decisions.
    pub fn find(&self, clause: &str, along: Option<Longitudinal>, across: Option<Lateral>) -> Option<usize> {
        let clause = clause.to_ascii_lowercase();
        let says = |s: &Says| {
            along.is_some_and(|d| s.longitudinal.contains(&d))
                || across.is_some_and(|d| s.lateral.contains(&d))
        };
        let own = || self.stems.iter().filter(|(s, _)| says(s)).flat_map(|(_, words)| words);
        let first = own().filter_map(|w| word_starts(&clause, w).next()).min()?;
        let last = own().filter_map(|w| word_starts(&clause, w).last()).max().unwrap_or(first);
        let denied = self.denied.iter().any(|w| word_starts(&clause[..last], w).next().is_some());
        (!denied).then_some(first)
    }
}

/// Where `stem` begins in `text`: anywhere in Chinese, at the start of a word in Latin letters.
fn word_starts<'t>(text: &'t str, stem: &'t str) -> impl Iterator<Item = usize> + 't {
    let begins = |at: &usize| !stem.is_ascii() || !text[..*at].ends_with(|c: char| c.is_ascii_alphanumeric());
    text.match_indices(stem).map(|(at, _)| at).filter(begins)
}
