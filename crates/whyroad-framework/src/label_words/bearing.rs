//! What a text states besides its things: whether there is anything to respond to, whether it concerns traffic, and
//! whether the response is over (`bearing` of `schema/label_words.yaml`). Searched separately from all other words.

use super::Words;
use super::compile::{expanded, trie};
use crate::lexicon::trie::Trie;
use crate::lexicon::units::Units;
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Meaning of a phrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bears {
    /// Nothing blocks the view or the path.
    Clear,
    /// There is nothing to respond to.
    Harmless,
    /// Not about roads or traffic.
    Idle,
    /// Off the road, or on another one.
    Apart,
    /// A time at which the ego has already responded, or the road user that it responds to is gone.
    Done,
}

/// All phrases, as one search.
#[derive(Clone, Debug, Default)]
pub struct Bearing {
    trie: Trie,
    says: Vec<Bears>,
}

impl Bearing {
    /// Passes the phrases of a text to `take`: meaning, first byte, one past the last byte.
    pub fn hits(&self, units: &Units, length: usize, mut take: impl FnMut(Bears, usize, usize)) {
        self.trie.find_in(units, 0..length, |f| take(self.says[f.word], f.start, f.end));
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBearing {
    clear: Words,
    harmless: Words,
    idle: Words,
    apart: Words,
    done: Words,
}

impl RawBearing {
    pub(super) fn compile(&self, problems: &mut Vec<Bilingual>) -> Bearing {
        let lists = [
            (&self.clear, Bears::Clear),
            (&self.harmless, Bears::Harmless),
            (&self.idle, Bears::Idle),
            (&self.apart, Bears::Apart),
            (&self.done, Bears::Done),
        ];
        let mut says = BTreeMap::new();
        for (words, bears) in lists {
            let texts: Vec<String> = words.all().flat_map(|p| expanded(p, problems)).collect();
            for text in texts {
                if says.insert(text.clone(), bears).is_some_and(|other| other != bears) {
                    problems.push(Bilingual::new(
                        format!("'{text}' 在 bearing 中有两种含义"),
                        format!("'{text}' has two meanings in bearing"),
                    ));
                }
            }
        }
        Bearing { trie: trie(says.keys().map(String::as_str), problems), says: says.into_values().collect() }
    }
}
