//! Words that are ignored when texts are compared (`compared` of `schema/label_words.yaml`): particles, and words
//! without information about a scene.

use super::Words;
use serde::Deserialize;
use std::collections::HashSet;

/// Words and characters that make no difference.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// Chinese characters that make no difference between two components.
    pub particles: CharSet,
    /// Words of Latin letters that make none, as [`hashed`], sorted.
    empty: Vec<u64>,
    /// The same as bits: a word whose bit is not set is not empty.
    empty_bits: [u64; 4],
    /// Chinese characters without information about a scene.
    pub of_no_scene: CharSet,
    /// Chinese characters of deciding and of reasons in general.
    pub of_deciding: CharSet,
    /// Words of Latin letters without information about a scene.
    scene: HashSet<String>,
    /// Words of Latin letters for what the ego does and where it is.
    own: HashSet<String>,
    /// Words of Latin letters of deciding and of reasons in general.
    deciding: HashSet<String>,
}

/// The hash of a word, extended by `c`, upper and lower case alike; 0 is the empty word.
pub fn hashed(word: u64, c: char) -> u64 {
    word.wrapping_mul(0x0100_0000_01b3).wrapping_add(u64::from(c.to_ascii_lowercase()) + 1)
}

fn bit(word: u64) -> usize {
    (word.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as usize
}

impl Compared {
    /// True for a word, by its hash, that makes no difference.
    pub fn is_empty_word(&self, word: u64) -> bool {
        self.may_be_empty(word) && self.empty.binary_search(&word).is_ok()
    }

    /// The same, faster, and sometimes true for another word.
    pub fn may_be_empty(&self, word: u64) -> bool {
        let bit = bit(word);
        self.empty_bits[bit / 64] >> (bit % 64) & 1 != 0
    }

    /// True for a word of Latin letters, in lower case, without information about a scene, or for what the ego does or
    /// where it is.
    pub fn is_plain(&self, word: &str) -> bool {
        self.scene.contains(word) || self.is_own(word)
    }

    /// True for a word of Latin letters, in lower case, for what the ego does or where it is.
    pub fn is_own(&self, word: &str) -> bool {
        self.own.contains(word)
    }

    /// True for a word of Latin letters, in lower case, that is about decisions and reasons in general.
    pub fn is_deciding(&self, word: &str) -> bool {
        self.deciding.contains(word)
    }
}

/// A set of characters of the basic plane.
#[derive(Clone, Debug, Default)]
pub struct CharSet(Vec<u64>);

impl CharSet {
    pub(super) fn of<'t>(texts: impl Iterator<Item = &'t str>) -> Self {
        let mut bits = vec![0; 0x1_0000 / 64];
        for c in texts.flat_map(str::chars) {
            if let Some(word) = bits.get_mut(c as usize / 64) {
                *word |= 1 << (c as usize % 64);
            }
        }
        Self(bits)
    }

    /// True when the set has `c`.
    pub fn contains(&self, c: char) -> bool {
        self.0.get(c as usize / 64).is_some_and(|word| word >> (c as usize % 64) & 1 != 0)
    }
}

/// The lists as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCompared {
    components: Words,
    scene: Words,
    own: Words,
    deciding: Words,
}

impl RawCompared {
    pub(super) fn compile(&self) -> Compared {
        let chars = |w: &Words| CharSet::of(w.zh.iter().map(String::as_str));
        let mut empty: Vec<u64> = self.components.en.iter().map(|w| w.chars().fold(0, hashed)).collect();
        empty.sort_unstable();
        let mut empty_bits = [0; 4];
        for word in &empty {
            empty_bits[bit(*word) / 64] |= 1 << (bit(*word) % 64);
        }
        Compared {
            particles: chars(&self.components),
            empty,
            empty_bits,
            of_no_scene: chars(&self.scene),
            of_deciding: chars(&self.deciding),
            scene: self.scene.en.iter().cloned().collect(),
            own: self.own.en.iter().cloned().collect(),
            deciding: self.deciding.en.iter().cloned().collect(),
        }
    }
}
