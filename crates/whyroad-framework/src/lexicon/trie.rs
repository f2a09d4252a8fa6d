//! Finds words in a text: leftmost, longest, whole words where they are of Latin letters. A trie over units
//! ([`super::units`]), because traces are short and most units start no word of the lexicon: an automaton over bytes
//! (aho-corasick, tried first) spends its time waiting for its large tables.

use super::units::{Unit, Units};
use std::ops::Range;

/// No word ends here.
const NONE: u32 = u32::MAX;
const SPACE: u64 = b' ' as u64;
/// An empty slot of a table of edges.
const FREE: u64 = u64::MAX;
/// Bits of the filter of beginnings, as a power of two.
const FILTER_BITS: u32 = 18;

#[derive(Clone, Debug, Default)]
pub struct Trie {
    /// By character: 0, or one more than its index in `starts`. Characters beyond the table start no word.
    characters: Vec<u16>,
    /// The same by runs of Latin letters: an open table of keys and indices, of a power of two.
    runs: Vec<(u64, u16)>,
    /// Edges of one unit.
    starts: Vec<Start>,
    /// Which pairs of a first and a second unit begin a word (behind a space: a first and a third): most texts end
    /// here. A set bit may be a false positive; an unset bit is always correct.
    filter: Vec<u64>,
    nodes: Vec<Node>,
    /// Edges of all nodes: each has an open table of a power of two, side by side.
    keys: Vec<u64>,
    children: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Start {
    node: u32,
    /// The word of this unit alone.
    word: u32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Where its table of edges is.
    edges: u32,
    /// Length of the table; 0 where there are no edges.
    slots: u32,
    word: u32,
}

/// Word number `word` is at `start..end` of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    pub word: usize,
    pub start: usize,
    pub end: usize,
}

/// Spreads the bits of a key.
fn mixed(key: u64) -> u64 {
    let z = (key ^ (key >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z ^ (z >> 29)
}

/// The filter's bit of two units.
fn pair(first: u64, second: u64, behind_space: bool) -> usize {
    let both = first.rotate_left(25) ^ second ^ u64::from(behind_space) << 50;
    (mixed(both) >> (64 - FILTER_BITS)) as usize
}

impl Trie {
    /// A trie of `words`, which are in lower case and different. `None` when there are too many.
    pub fn new<'w>(words: impl Iterator<Item = &'w str>) -> Option<Self> {
        let mut words: Vec<(Vec<u64>, u32)> =
            words.zip(0..).map(|(w, i)| (Units::of(w).all().iter().map(|u| u.key).collect(), i)).collect();
        words.sort_unstable();
        let mut trie = Self {
            characters: vec![0; 0x1_0000],
            filter: vec![0; (1 << FILTER_BITS) / 64],
            ..Self::default()
        };
        let mut runs = Vec::new();
        // Sorted words with a common beginning stand side by side: each node is a range of them.
        let mut from = 0;
        while from < words.len() {
            let Some(&first) = words[from].0.first() else {
                from += 1;
                continue;
            };
            let to = from + words[from..].iter().take_while(|w| w.0.first() == Some(&first)).count();
            let node = trie.add(&words, from, to, 1)?;
            trie.starts.push(Start { node, word: trie.nodes[node as usize].word });
            let place = u16::try_from(trie.starts.len()).ok()?;
            if (Unit { key: first, start: 0 }).is_latin() {
                runs.push((first, place));
            } else {
                *trie.characters.get_mut(usize::try_from(first).ok()?)? = place;
            }
            for (word, _) in &words[from..to] {
                let bit = match word.as_slice() {
                    [_, SPACE, third, ..] => pair(first, *third, true),
                    [_, second, ..] => pair(first, *second, false),
                    _ => continue,
                };
                trie.filter[bit / 64] |= 1 << (bit % 64);
            }
            from = to;
        }
        trie.runs = vec![(0, 0); (runs.len() * 2).next_power_of_two()];
        let mask = trie.runs.len() - 1;
        for (key, place) in runs {
            let mut slot = mixed(key) as usize & mask;
            while trie.runs[slot].1 != 0 {
                slot = (slot + 1) & mask;
            }
            trie.runs[slot] = (key, place);
        }
        Some(trie)
    }

    fn add(&mut self, words: &[(Vec<u64>, u32)], from: usize, to: usize, depth: usize) -> Option<u32> {
        let is_word = words[from].0.len() == depth;
        let word = if is_word { words[from].1 } else { NONE };
        let mut children = Vec::new();
        let mut at = from + words[from..to].iter().take_while(|w| w.0.len() == depth).count();
        while at < to {
            let key = words[at].0[depth];
            let end = at + words[at..to].iter().take_while(|w| w.0[depth] == key).count();
            children.push((key, self.add(words, at, end, depth + 1)?));
            at = end;
        }
        let slots = match children.len() {
            few @ (0 | 1) => few,
            many => (many * 2).next_power_of_two(),
        };
        let edges = self.keys.len();
        self.keys.resize(edges + slots, FREE);
        self.children.resize(edges + slots, NONE);
        for (key, child) in children {
            let mut slot = mixed(key) as usize & (slots - 1);
            while self.keys[edges + slot] != FREE {
                slot = (slot + 1) & (slots - 1);
            }
            self.keys[edges + slot] = key;
            self.children[edges + slot] = child;
        }
        self.nodes.push(Node { edges: u32::try_from(edges).ok()?, slots: u32::try_from(slots).ok()?, word });
        u32::try_from(self.nodes.len() - 1).ok()
    }

    /// Passes the words of `text` to `take`, in order, never overlapping.
    pub fn find(&self, text: &str, take: impl FnMut(Found)) {
        self.find_in(&Units::of(text), 0..text.len(), take);
    }

    /// The same in a part of a text that has been cut, which begins and ends between units.
    pub fn find_in(&self, units: &Units, bytes: Range<usize>, mut take: impl FnMut(Found)) {
        let units = units.part(bytes);
        let Some(end) = units.len().checked_sub(1).filter(|_| !self.starts.is_empty()) else { return };
        let mut at = 0;
        while at < end {
            let found = self.start(units[at]).and_then(|s| self.longest(s, units, at, end));
            match found {
                Some((word, next)) => {
                    take(Found { word: word as usize, start: units[at].start, end: units[next].start });
                    at = next;
                }
                None => at += 1,
            }
        }
    }

    #[inline]
    fn start(&self, unit: Unit) -> Option<Start> {
        let place = if unit.is_latin() {
            let mask = self.runs.len().checked_sub(1)?;
            let mut slot = mixed(unit.key) as usize & mask;
            loop {
                match self.runs[slot] {
                    (_, 0) => return None,
                    (key, place) if key == unit.key => break place,
                    _ => slot = (slot + 1) & mask,
                }
            }
        } else {
            *self.characters.get(usize::try_from(unit.key).ok()?)?
        };
        self.starts.get(usize::from(place).checked_sub(1)?).copied()
    }

    fn child(&self, node: Node, key: u64) -> Option<usize> {
        let edges = node.edges as usize..(node.edges + node.slots) as usize;
        let keys = &self.keys[edges.clone()];
        let mask = keys.len().checked_sub(1)?;
        let mut slot = mixed(key) as usize & mask;
        // A table of one has no free slot.
        for _ in 0..keys.len() {
            match keys[slot] {
                k if k == key => return Some(self.children[edges.start + slot] as usize),
                FREE => return None,
                _ => slot = (slot + 1) & mask,
            }
        }
        None
    }

    fn has(&self, bit: usize) -> bool {
        self.filter[bit / 64] >> (bit % 64) & 1 != 0
    }

    /// The longest word from unit `at` on, and the unit after it.
    fn longest(&self, start: Start, units: &[Unit], at: usize, end: usize) -> Option<(u32, usize)> {
        let mut best = (start.word != NONE).then_some((start.word, at + 1));
        let key = |i: usize| if i < end { units[i].key } else { u64::MAX };
        let second = key(at + 1);
        let first = units[at].key;
        let may_go_on = self.has(pair(first, second, false))
            || (second == SPACE && self.has(pair(first, key(at + 2), true)));
        if !may_go_on {
            return best;
        }
        let (mut node, mut next) = (start.node as usize, at + 1);
        while next < end {
            let Some(child) = self.child(self.nodes[node], units[next].key) else { break };
            node = child;
            next += 1;
            if self.nodes[node].word != NONE {
                best = Some((self.nodes[node].word, next));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexicon::units::is_latin;
    use proptest::prelude::*;

    /// The same by trying every word at every position.
    fn plainly(words: &[&str], text: &str) -> Vec<Found> {
        let chars: Vec<(usize, char)> = text.char_indices().collect();
        let latin_at = |i: Option<usize>| i.and_then(|i| chars.get(i)).is_some_and(|c| is_latin(c.1));
        let (mut out, mut i) = (Vec::new(), 0);
        while i < chars.len() {
            let start = chars[i].0;
            let fits = |w: &&str| {
                let n = w.chars().count();
                let same = text[start..].chars().take(n).map(|c| c.to_ascii_lowercase()).eq(w.chars());
                let cut_before = latin_at(i.checked_sub(1)) && latin_at(Some(i));
                let cut_after = w.chars().last().is_some_and(is_latin) && latin_at(Some(i + n));
                same && !cut_before && !cut_after
            };
            let best =
                words.iter().enumerate().filter(|(_, w)| fits(w)).max_by_key(|(_, w)| w.chars().count());
            match best {
                Some((word, w)) => {
                    out.push(Found { word, start, end: start + w.len() });
                    i += w.chars().count();
                }
                None => i += 1,
            }
        }
        out
    }

    const WORDS: &[&str] = &[
        ", so",
        "no",
        "no need",
        "stop",
        "stop at",
        "不",
        "不得不",
        "停",
        "停车",
        "停车线",
        "变道",
        "左变道",
    ];

    proptest! {
        #[test]
        fn same_as_trying_everything(pieces in prop::collection::vec(
            prop::sample::select(vec!["不", "得", "停", "车", "线", "左", "变道", "no", " ", "need", "Stop", "at", "s", ", so", "，", "_", "1"]), 0..12)) {
            let text = pieces.concat();
            let mut sorted = WORDS.to_vec();
            sorted.sort_unstable();
            let trie = Trie::new(sorted.iter().copied()).unwrap();
            let mut found = Vec::new();
            trie.find(&text, |f| found.push(f));
            prop_assert_eq!(found, plainly(&sorted, &text));
        }
    }
}
