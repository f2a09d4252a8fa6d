//! Words that say nearly the same, in either language (`concepts` of `schema/label_words.yaml`): two components that
//! share several are compared by what they mean. A word may say more than one thing.

use super::Words;
use super::compile::{expanded, limit, trie};
use crate::lexicon::trie::Trie;
use crate::lexicon::units::Units;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Concepts that a set can hold.
const MAX_CONCEPTS: usize = 256;

/// A set of concepts, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConceptSet([u64; MAX_CONCEPTS / 64]);

impl ConceptSet {
    fn of(index: usize) -> Self {
        let mut out = Self::default();
        if let Some(bits) = out.0.get_mut(index / 64) {
            *bits = 1 << (index % 64);
        }
        out
    }

    /// Both together.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a |= b);
        self
    }

    /// What is in `other`, too.
    #[must_use]
    pub fn only(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a &= b);
        self
    }

    /// How many there are.
    pub fn count(self) -> u32 {
        self.0.iter().map(|bits| bits.count_ones()).sum()
    }

    /// True when there is none.
    pub fn is_empty(self) -> bool {
        self.count() == 0
    }
}

/// All words, as one search.
#[derive(Clone, Debug, Default)]
pub struct Concepts {
    trie: Trie,
    says: Vec<ConceptSet>,
    /// What says that something cannot be seen.
    pub unseen: ConceptSet,
}

impl Concepts {
    /// What `text`, which is cut into `units`, speaks of.
    pub fn of(&self, text: &str, units: &Units) -> ConceptSet {
        let mut out = ConceptSet::default();
        self.trie.find_in(units, 0..text.len(), |f| out = out.with(self.says[f.word]));
        out
    }
}

/// `unseen`: the concepts that say that something cannot be seen.
pub(super) fn compile(
    raw: &BTreeMap<String, Words>,
    unseen: &[&str],
    problems: &mut Vec<Bilingual>,
) -> Concepts {
    limit(["concepts"; 2], ["项", "entries"], raw.len(), MAX_CONCEPTS, problems);
    let mut says: BTreeMap<String, ConceptSet> = BTreeMap::new();
    let mut hidden = ConceptSet::default();
    for (i, (id, words)) in raw.iter().enumerate() {
        let own = ConceptSet::of(i);
        if unseen.contains(&id.as_str()) {
            hidden = hidden.with(own);
        }
        for text in words.all().flat_map(|p| expanded(p, problems)) {
            let set = says.entry(text).or_default();
            *set = set.with(own);
        }
    }
    let trie = trie(says.keys().map(String::as_str), problems);
    Concepts { trie, says: says.into_values().collect(), unseen: hidden }
}
