//! Names of things of one family that exclude one another: a hatchback is not a pickup, a dog not a cow (`apart` of
//! `schema/label_words.yaml`). A name that may be of several kinds is listed under each of them.

use super::Words;
use super::compile::limit;
use serde::Deserialize;
use std::collections::BTreeMap;
use whyroad_model::Bilingual;

/// Maximum number of kinds of a family.
const MAX_KINDS: usize = 64;

/// All families.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    /// For each family the names, in lower case, with their kinds, one bit each.
    families: Vec<Vec<(String, u64)>>,
}

impl Apart {
    /// Families of which `name` contains a word, with its possible kinds: those of its longest words.
    pub fn kinds(&self, name: &str) -> Vec<(usize, u64)> {
        let lower = name.to_ascii_lowercase();
        let of = |family: &Vec<(String, u64)>| {
            let found = family.iter().filter(|(w, _)| holds(&lower, w));
            let longest = found.clone().map(|(w, _)| w.len()).max()?;
            Some(found.filter(|(w, _)| w.len() == longest).fold(0, |all, (_, kinds)| all | kinds))
        };
        self.families.iter().enumerate().filter_map(|(i, f)| Some((i, of(f)?))).collect()
    }
}

/// `name` holds `word`: one of Latin letters as a word, in singular or plural.
fn holds(name: &str, word: &str) -> bool {
    name.match_indices(word).any(|(at, _)| {
        let is_letter = |c: char| c.is_ascii_alphanumeric();
        let behind = &name[at + word.len()..];
        let behind = behind.strip_prefix("es").or_else(|| behind.strip_prefix('s')).unwrap_or(behind);
        !word.is_ascii() || !name[..at].ends_with(is_letter) && !behind.starts_with(is_letter)
    })
}

/// The lists as written: for each family, the names of each kind.
pub(super) type RawApart = BTreeMap<String, RawFamily>;

#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct RawFamily(BTreeMap<String, Words>);

pub(super) fn compile(raw: &RawApart, problems: &mut Vec<Bilingual>) -> Apart {
    let families = raw.iter().map(|(id, RawFamily(kinds))| {
        let family = [&*format!("apart 的 {id}"), &*format!("{id} of apart")];
        limit(family, ["类", "kinds"], kinds.len(), MAX_KINDS, problems);
        let mut names: BTreeMap<String, u64> = BTreeMap::new();
        for (i, words) in kinds.values().take(MAX_KINDS).enumerate() {
            for word in words.all() {
                *names.entry(word.to_ascii_lowercase()).or_default() |= 1 << i;
            }
        }
        names.into_iter().collect()
    });
    Apart { families: families.collect() }
}
