//! Names of things of one family that exclude one another: a hatchback is not a pickup, a dog not a cow (`apart` of
//! `schema/label_words.yaml`). A name that may be of several kinds is listed under each of them.

use super::Words;
use super::compile::limit;
use crate::phrases::ByFirst;
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Maximum number of kinds of a family.
const MAX_KINDS: usize = 64;

/// All families.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    /// Number of families.
    families: usize,
    /// Names of all families, in lower case.
    names: Vec<Name>,
    index: ByFirst,
}

/// A name of one family.
#[derive(Clone, Debug)]
struct Name {
    word: String,
    family: usize,
    /// One bit for each kind that it may be.
    kinds: u64,
}

impl Apart {
    /// Families of which `name` contains a word, with its possible kinds: those of its longest words.
    pub fn kinds(&self, name: &str) -> Vec<(usize, u64)> {
        let lower = name.to_ascii_lowercase();
        // Of each family the length of the longest word, and the kinds of all words of that length.
        let mut longest = vec![(0, 0); self.families];
        for (at, first) in lower.char_indices() {
            for name in self.index.at(first).iter().map(|i| &self.names[*i as usize]) {
                let (length, kinds) = &mut longest[name.family];
                if name.word.len() < *length || !holds(&lower, at, &name.word) {
                    continue;
                }
                *kinds = if name.word.len() > *length { name.kinds } else { *kinds | name.kinds };
                *length = name.word.len();
            }
        }
        let found = longest.into_iter().enumerate().filter(|(_, (length, _))| *length > 0);
        found.map(|(family, (_, kinds))| (family, kinds)).collect()
    }
}

/// `name` holds `word` at this place: one of Latin letters as a word, in singular or plural.
fn holds(name: &str, at: usize, word: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric();
    let Some(behind) = name[at..].strip_prefix(word) else { return false };
    let behind = behind.strip_prefix("es").or_else(|| behind.strip_prefix('s')).unwrap_or(behind);
    !word.is_ascii() || !name[..at].ends_with(is_letter) && !behind.starts_with(is_letter)
}

/// The lists as written: for each family, the names of each kind.
pub(super) type RawApart = BTreeMap<String, RawFamily>;

#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct RawFamily(BTreeMap<String, Words>);

pub(super) fn compile(raw: &RawApart, problems: &mut Vec<Bilingual>) -> Apart {
    let families = raw.iter().enumerate().flat_map(|(number, (id, RawFamily(kinds)))| {
        let family = [&*format!("apart 的 {id}"), &*format!("{id} of apart")];
        limit(family, ["类", "kinds"], kinds.len(), MAX_KINDS, problems);
        let mut names: BTreeMap<String, u64> = BTreeMap::new();
        for (i, words) in kinds.values().take(MAX_KINDS).enumerate() {
            for word in words.all() {
                *names.entry(word.to_ascii_lowercase()).or_default() |= 1 << i;
            }
        }
        names.into_iter().map(move |(word, kinds)| Name { word, family: number, kinds })
    });
    let names: Vec<Name> = families.collect();
    let index = ByFirst::of(names.iter().map(|n| n.word.as_str()));
    Apart { families: raw.len(), names, index }
}
