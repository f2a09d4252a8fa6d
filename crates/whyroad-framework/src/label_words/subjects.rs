//! How the thing is found that a component speaks of (`subjects` of `schema/label_words.yaml`).

use super::{CharSet, Words};
use serde::Deserialize;
use std::collections::HashSet;

/// Words around the name of a thing.
#[derive(Clone, Debug, Default)]
pub struct Subjects {
    ends: HashSet<String>,
    pronouns: HashSet<String>,
    /// A text in Chinese that begins with one of these speaks of the ego.
    pub own: Vec<String>,
    /// How many, in Chinese.
    pub counts: CharSet,
    /// The word that counts, behind it.
    pub counters: CharSet,
    /// Whoever is there is neither to the left nor to the right; in lower case.
    pub opposite: Vec<String>,
    /// In so many names of things that to share one says nothing.
    pub common: CharSet,
    /// The same of Latin letters, in lower case.
    pub common_words: HashSet<String>,
    /// Names for all of a kind, in lower case.
    general: HashSet<String>,
    /// Behind the name of a place.
    pub places: CharSet,
}

impl Subjects {
    /// The word of Latin letters, in lower case, ends the words for a thing.
    pub fn ends(&self, word: &str) -> bool {
        self.ends.contains(word)
    }

    /// `name`, in upper or lower case, is that of all of a kind.
    pub fn is_general(&self, name: &str) -> bool {
        self.general.contains(&name.to_lowercase())
    }

    /// A text that begins with this word of Latin letters, in lower case, speaks of what was named before or of no
    /// thing.
    pub fn is_pronoun(&self, word: &str) -> bool {
        self.pronouns.contains(word)
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSubjects {
    ends: Words,
    pronouns: Words,
    own: Words,
    counts: Words,
    counters: Words,
    opposite: Words,
    common: Words,
    general: Words,
    places: Words,
}

impl RawSubjects {
    pub(super) fn compile(&self) -> Subjects {
        let list = |w: &Words| w.en.iter().cloned().collect();
        let chars = |w: &Words| CharSet::of(w.zh.iter().map(String::as_str));
        Subjects {
            ends: list(&self.ends),
            pronouns: list(&self.pronouns),
            own: self.own.zh.clone(),
            counts: chars(&self.counts),
            counters: chars(&self.counters),
            opposite: self.opposite.all().map(str::to_owned).collect(),
            common: chars(&self.common),
            common_words: list(&self.common),
            general: self.general.all().map(str::to_owned).collect(),
            places: chars(&self.places),
        }
    }
}
