//! A text cut once into the units that every word list is searched by: a run of Latin letters and digits is one unit,
//! any other character is one. Words of Latin letters match whole words only, so that no word of any list begins or
//! ends inside a unit.

use std::ops::Range;

/// Set in the key of a run of Latin letters and digits.
const LATIN: u64 = 1 << 63;
/// Runs up to this length are their own key; longer ones are hashed.
const PACKED: usize = 7;

/// One unit: upper and lower case alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Equal for equal units: the character, or the run's letters.
    pub key: u64,
    /// First byte in the text.
    pub start: usize,
}

impl Unit {
    /// A run of Latin letters, digits and underscores.
    pub fn is_latin(self) -> bool {
        self.key & LATIN != 0
    }
}

/// A punctuation mark, which may divide a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// The mark.
    pub sign: char,
    /// First byte in the text.
    pub start: usize,
}

impl Mark {
    /// One past the last byte.
    pub fn end(self) -> usize {
        self.start + self.sign.len_utf8()
    }
}

/// A text in units.
#[derive(Clone, Debug, Default)]
pub struct Units {
    marks: Vec<Mark>,
    /// All units, and one after them that starts where the text ends.
    units: Vec<Unit>,
}

#[cfg(test)]
pub(crate) fn is_latin(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl Units {
    /// Cuts `text`.
    pub fn of(text: &str) -> Self {
        let mut out = Self::default();
        out.cut(text);
        out
    }

    /// Cuts another text with the memory of the last one.
    pub fn cut(&mut self, text: &str) {
        self.units.clear();
        self.marks.clear();
        // A unit has three bytes in Chinese, and some two in English with its spaces.
        self.units.reserve(text.len() / 2 + 2);
        let bytes = text.as_bytes();
        let mut at = 0;
        while let Some(&b) = bytes.get(at) {
            let start = at;
            let key = if b >= 0x80 {
                let Some(c) = text[at..].chars().next() else { break };
                at += c.len_utf8();
                if matches!(c, '\u{2010}'..='\u{206f}' | '\u{3001}'..='\u{303f}' | '\u{ff01}'..='\u{ff65}') {
                    self.marks.push(Mark { sign: c, start });
                }
                u64::from(u32::from(c))
            } else if b.is_ascii_alphanumeric() || b == b'_' {
                let (mut packed, mut hash) = (0_u64, 0xcbf2_9ce4_8422_2325_u64);
                while let Some(b) = bytes.get(at).filter(|b| b.is_ascii_alphanumeric() || **b == b'_') {
                    let lower = u64::from(b.to_ascii_lowercase());
                    packed = packed << 8 | lower;
                    if at - start >= PACKED - 1 {
                        hash = (hash ^ packed).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23);
                    }
                    at += 1;
                }
                if at - start <= PACKED { LATIN | packed } else { LATIN | 1 << 62 | hash >> 2 }
            } else {
                at += 1;
                // "1.5 m" continues.
                let in_number = b == b'.' && bytes.get(at).is_some_and(u8::is_ascii_digit);
                if b > b' ' && !in_number {
                    self.marks.push(Mark { sign: char::from(b), start });
                }
                u64::from(b)
            };
            self.units.push(Unit { key, start });
        }
        self.units.push(Unit { key: u64::MAX, start: at });
    }

    /// The units in order.
    pub fn all(&self) -> &[Unit] {
        self.units.split_last().map_or(&[], |(_, all)| all)
    }

    /// The punctuation in order. A decimal point is not a punctuation mark.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// The units that start in a part of the text, and one after them that starts where the next unit starts: the input
    /// of a search. The part begins and ends between units.
    pub(crate) fn part(&self, bytes: Range<usize>) -> &[Unit] {
        let Some(last) = self.units.len().checked_sub(1) else { return &[] };
        let at = |byte: usize| self.units.partition_point(|u| u.start < byte);
        let from = if bytes.start == 0 { 0 } else { at(bytes.start) };
        let to = if bytes.end >= self.units[last].start { last } else { at(bytes.end) };
        self.units.get(from..=to).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_letters_are_units_whatever_their_case() {
        let cut = |text: &str| Units::of(text);
        let starts = |text: &str| cut(text).all().iter().map(|u| u.start).collect::<Vec<_>>();
        assert_eq!(starts("左 G6x, ok"), [0, 3, 4, 7, 8, 9]);
        assert!(starts("").is_empty());
        let keys = |text: &str| cut(text).all().iter().map(|u| u.key).collect::<Vec<_>>();
        assert_eq!(keys("Stop SUV_2"), keys("stop suv_2"));
        assert_eq!(keys("Intersection"), keys("interSECTION"));
        let mut all: Vec<u64> =
            ["a", "aa", "aaaaaaa", "aaaaaaaa", "aaaaaaaaa", "intersection", "intersections", "停", "1", "10"]
                .iter()
                .flat_map(|t| keys(t))
                .collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 10);
    }

    #[test]
    fn a_part_has_its_units_and_one_behind() {
        let units = Units::of("前车 stops，so 停");
        let starts = |range| units.part(range).iter().map(|u| u.start).collect::<Vec<_>>();
        assert_eq!(starts(0..21), [0, 3, 6, 7, 12, 15, 17, 18, 21]);
        assert_eq!(starts(7..12), [7, 12]);
        assert_eq!(starts(21..21), [21]);
        assert!(Units::default().part(0..3).is_empty());
    }
}
