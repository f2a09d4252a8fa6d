//! A bit per row, 64 rows per word, the first row in the lowest bit. The representation of boolean conditions in the
//! fast evaluator: `and`, `or`, `not` of 64 rows are one instruction. Bits beyond the last row are always 0.

use std::ops::Range;

/// Packed bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    words: Vec<u64>,
    len: usize,
}

/// Ones below bit `n` of a word; all 64 for `n >= 64`.
fn low(n: usize) -> u64 {
    if n >= 64 { u64::MAX } else { (1 << n) - 1 }
}

impl Bits {
    /// All 0.
    pub fn zeros(len: usize) -> Self {
        Self { words: vec![0; len.div_ceil(64)], len }
    }

    /// All 1.
    pub fn ones(len: usize) -> Self {
        Self::of_words(vec![u64::MAX; len.div_ceil(64)], len)
    }

    /// From words; bits beyond `len` are cleared.
    pub fn of_words(mut words: Vec<u64>, len: usize) -> Self {
        debug_assert_eq!(words.len(), len.div_ceil(64));
        if let (Some(last), used @ 1..) = (words.last_mut(), len % 64) {
            *last &= low(used);
        }
        Self { words, len }
    }

    /// One bit per item.
    pub fn collect(len: usize, mut bit: impl FnMut(usize) -> bool) -> Self {
        let mut words = Vec::with_capacity(len.div_ceil(64));
        for start in (0..len).step_by(64) {
            let mut word = 0;
            for i in start..len.min(start + 64) {
                word |= u64::from(bit(i)) << (i - start);
            }
            words.push(word);
        }
        Self { words, len }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// 64 rows per word.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// The bit of a row; 0 beyond the last one.
    pub fn get(&self, i: usize) -> bool {
        self.words.get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1)
    }

    /// True when no bit is set.
    pub fn none(&self) -> bool {
        self.words.iter().all(|w| *w == 0)
    }

    /// True when all bits are set.
    pub fn all(&self) -> bool {
        self.count() == self.len
    }

    /// Number of bits that are set.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Number of bits that are set in these rows.
    pub fn count_in(&self, rows: Range<usize>) -> usize {
        self.masked(rows).map(|(_, w)| w.count_ones() as usize).sum()
    }

    /// True when a bit is set in these rows.
    pub fn any_in(&self, rows: Range<usize>) -> bool {
        self.masked(rows).any(|(_, w)| w != 0)
    }

    /// The words that cover these rows, with other rows cleared, and the index of each.
    fn masked(&self, rows: Range<usize>) -> impl Iterator<Item = (usize, u64)> + '_ {
        let end = rows.end.min(self.len).max(rows.start);
        let words = if rows.start == end { 0..0 } else { rows.start / 64..end.div_ceil(64) };
        words.map(move |i| {
            let below = rows.start.saturating_sub(i * 64);
            (i, self.words[i] & low(end - i * 64) & !low(below.min(64)))
        })
    }

    /// Word by word.
    #[must_use]
    pub fn map2(&self, other: &Bits, f: impl Fn(u64, u64) -> u64) -> Bits {
        debug_assert_eq!(self.len, other.len);
        let words = self.words.iter().zip(&other.words).map(|(a, b)| f(*a, *b)).collect();
        Bits::of_words(words, self.len)
    }

    /// `self &= other`.
    pub fn and_with(&mut self, other: &Bits) {
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a &= b);
    }

    /// `self |= other`.
    pub fn or_with(&mut self, other: &Bits) {
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a |= b);
    }

    /// The complement.
    #[must_use]
    pub fn inverted(&self) -> Bits {
        Bits::of_words(self.words.iter().map(|w| !w).collect(), self.len)
    }

    /// Sets all bits of these rows.
    pub fn set_range(&mut self, rows: Range<usize>) {
        self.each_word(rows, |word, mask| *word |= mask);
    }

    /// Clears all bits of these rows.
    pub fn clear_range(&mut self, rows: Range<usize>) {
        self.each_word(rows, |word, mask| *word &= !mask);
    }

    fn each_word(&mut self, rows: Range<usize>, f: impl Fn(&mut u64, u64)) {
        if rows.start >= rows.end {
            return;
        }
        let (first, last) = (rows.start / 64, (rows.end - 1) / 64);
        for i in first..=last {
            let mut mask = low(rows.end - i * 64);
            if i == first {
                mask &= !low(rows.start % 64);
            }
            f(&mut self.words[i], mask);
        }
    }

    /// Up to 64 bits from row `at` on, the first in the lowest bit; 0 beyond the last one.
    pub fn word_at(&self, at: usize) -> u64 {
        let (i, shift) = (at / 64, at % 64);
        let low_part = self.words.get(i).map_or(0, |w| w >> shift);
        // A shift by 64 is not a shift.
        let high = if shift == 0 { 0 } else { self.words.get(i + 1).map_or(0, |w| w << (64 - shift)) };
        low_part | high
    }

    /// Copies `rows` of `from` to the rows that begin at `to`, which must be 0 so far.
    pub fn copy_from(&mut self, from: &Bits, rows: Range<usize>, to: usize) {
        let mut done = 0;
        while done < rows.len() {
            let (i, shift) = ((to + done) / 64, (to + done) % 64);
            let take = (64 - shift).min(rows.len() - done);
            self.words[i] |= (from.word_at(rows.start + done) & low(take)) << shift;
            done += take;
        }
    }

    /// These rows alone.
    #[must_use]
    pub fn slice(&self, rows: Range<usize>) -> Bits {
        let mut out = Bits::zeros(rows.len());
        out.copy_from(self, rows, 0);
        out
    }

    /// Of each 64 rows, how many bits are set before them.
    pub fn counts_before(&self) -> Vec<usize> {
        let mut before = 0;
        let count = |word: &u64| {
            let of_word = before;
            before += word.count_ones() as usize;
            of_word
        };
        self.words.iter().map(count).collect()
    }

    /// These bits one after another to the rows that are set in `rows`; 0 in the others.
    #[must_use]
    pub fn spread_over(&self, rows: &Bits) -> Bits {
        let mut from = 0;
        let word = |into: &u64| {
            let n = into.count_ones() as usize;
            let out = if n == 0 { 0 } else { deposited(self.word_at(from), *into) };
            from += n;
            out
        };
        Bits::of_words(rows.words.iter().map(word).collect(), rows.len)
    }

    /// Each bit one row later; the first row gets 0, the last one is lost.
    #[must_use]
    pub fn later(&self) -> Bits {
        let mut carry = 0;
        let shifted = self.words.iter().map(|w| {
            let out = w << 1 | carry;
            carry = w >> 63;
            out
        });
        Bits::of_words(shifted.collect(), self.len)
    }

    /// Maximal runs of 1 in these rows, in order.
    pub fn runs(&self, rows: Range<usize>) -> Runs<'_> {
        Runs { bits: self, at: rows.start, end: rows.end.min(self.len) }
    }

    /// The first row from `at` on, before `end`, whose bit is `wanted`; `end` if not found.
    fn next(&self, at: usize, end: usize, wanted: bool) -> usize {
        if at >= end {
            return end;
        }
        let flip = if wanted { 0 } else { u64::MAX };
        let mut i = at / 64;
        let mut word = (self.words[i] ^ flip) & !low(at % 64);
        while word == 0 {
            i += 1;
            if i * 64 >= end {
                return end;
            }
            word = self.words[i] ^ flip;
        }
        (i * 64 + word.trailing_zeros() as usize).min(end)
    }

    /// Rows whose bit is set, in order.
    pub fn positions(&self, rows: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        self.masked(rows).flat_map(|(i, mut word)| {
            std::iter::from_fn(move || {
                (word != 0).then(|| {
                    let bit = word.trailing_zeros() as usize;
                    word &= word - 1;
                    i * 64 + bit
                })
            })
        })
    }

    /// The last row before `end`, not before `start`, whose bit is set.
    pub fn last_in(&self, rows: Range<usize>) -> Option<usize> {
        let mut end = rows.end.min(self.len);
        while end > rows.start {
            let i = (end - 1) / 64;
            let word = self.words[i] & low(end - i * 64);
            if word != 0 {
                let at = i * 64 + 63 - word.leading_zeros() as usize;
                return (at >= rows.start).then_some(at);
            }
            end = i * 64;
        }
        None
    }
}

/// The lowest bits to the positions that are set in `into`. These are few stretches, nearly always one.
fn deposited(mut bits: u64, mut into: u64) -> u64 {
    if into == u64::MAX {
        return bits;
    }
    let mut out = 0;
    while into != 0 {
        let start = into.trailing_zeros() as usize;
        let long = (into >> start).trailing_ones() as usize;
        let stretch = low(long) << start;
        out |= (bits << start) & stretch;
        // Less than 64, since not all are set.
        bits >>= long;
        into &= !stretch;
    }
    out
}

/// Maximal runs of 1.
pub struct Runs<'a> {
    bits: &'a Bits,
    at: usize,
    end: usize,
}

impl Iterator for Runs<'_> {
    type Item = Range<usize>;

    fn next(&mut self) -> Option<Range<usize>> {
        let start = self.bits.next(self.at, self.end, true);
        if start >= self.end {
            return None;
        }
        self.at = self.bits.next(start, self.end, false);
        Some(start..self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(v: &[bool]) -> Bits {
        Bits::collect(v.len(), |i| v[i])
    }

    fn back(b: &Bits) -> Vec<bool> {
        (0..b.len()).map(|i| b.get(i)).collect()
    }

    proptest! {
        #[test]
        fn bits_are_a_vector_of_bools(
            v in prop::collection::vec(prop::bool::weighted(0.8), 1..300),
            (a, b, to) in (0usize..300, 0usize..300, 0usize..100),
        ) {
            let n = v.len();
            let (a, b) = (a.min(b).min(n), a.max(b).min(n));
            let bits = of(&v);
            prop_assert_eq!(back(&bits), v.clone());
            prop_assert_eq!(bits.count_in(a..b), v[a..b].iter().filter(|x| **x).count());
            prop_assert_eq!(bits.any_in(a..b), v[a..b].contains(&true));
            prop_assert_eq!(back(&bits.slice(a..b)), v[a..b].to_vec());
            prop_assert_eq!(back(&bits.inverted()), v.iter().map(|x| !x).collect::<Vec<_>>());
            prop_assert_eq!(bits.inverted().count() + bits.count(), n);
            let later: Vec<bool> = std::iter::once(false).chain(v.iter().copied()).take(n).collect();
            prop_assert_eq!(back(&bits.later()), later);
            let set: Vec<usize> = (a..b).filter(|i| v[*i]).collect();
            prop_assert_eq!(bits.positions(a..b).collect::<Vec<_>>(), set.clone());
            prop_assert_eq!(bits.last_in(a..b), set.last().copied());
            let covered: Vec<usize> = bits.runs(a..b).flatten().collect();
            prop_assert_eq!(covered, set);
            let runs: Vec<_> = bits.runs(a..b).collect();
            prop_assert!(runs.windows(2).all(|w| w[0].end < w[1].start), "runs are maximal");
            let mut copied = Bits::zeros(to + b - a + 7);
            copied.copy_from(&bits, a..b, to);
            prop_assert_eq!(back(&copied)[to..to + b - a].to_vec(), v[a..b].to_vec());
            prop_assert_eq!(copied.count(), bits.count_in(a..b));
            // Each set bit at its position again, with the bits of another vector.
            let taken: Vec<bool> = (0..n).filter(|i| v[*i]).map(|i| i % 3 == 0).collect();
            let spread = of(&taken).spread_over(&bits);
            for (i, was) in v.iter().enumerate() {
                prop_assert_eq!(spread.get(i), *was && i % 3 == 0);
                prop_assert_eq!(bits.counts_before()[i / 64], bits.count_in(0..i / 64 * 64));
            }
            let (mut set, mut clear) = (bits.clone(), bits.clone());
            set.set_range(a..b);
            clear.clear_range(a..b);
            for (i, was) in v.iter().enumerate() {
                prop_assert_eq!(set.get(i), *was || (a..b).contains(&i));
                prop_assert_eq!(clear.get(i), *was && !(a..b).contains(&i));
            }
        }
    }
}
