//! One bit per row, 64 per word, the first row in the lowest bit: which rows are null, and flags, as they come out of
//! pages.

/// Bits that are appended.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Bitmap {
    pub words: Vec<u64>,
    pub len: usize,
    /// Number of ones.
    pub ones: usize,
}

/// Ones below bit `n` of a word; all 64 for `n >= 64`.
pub(crate) fn low(n: usize) -> u64 {
    if n >= 64 { u64::MAX } else { (1 << n) - 1 }
}

impl Bitmap {
    pub fn with_capacity(rows: usize) -> Self {
        Self { words: Vec::with_capacity(rows.div_ceil(64)), len: 0, ones: 0 }
    }

    /// Appends the `n` (at most 64) lowest bits.
    pub fn push_word(&mut self, word: u64, n: usize) {
        let word = word & low(n);
        let shift = self.len % 64;
        match self.words.last_mut() {
            Some(last) if shift > 0 => {
                *last |= word << shift;
                if shift + n > 64 {
                    self.words.push(word >> (64 - shift));
                }
            }
            _ if n > 0 => self.words.push(word),
            _ => {}
        }
        self.len += n;
        self.ones += word.count_ones() as usize;
    }

    /// Appends the same bit `n` times.
    pub fn push_run(&mut self, bit: bool, n: usize) {
        let word = if bit { u64::MAX } else { 0 };
        let mut left = n;
        while left > 0 {
            // Up to the end of a word first, then whole words.
            let take = left.min(64 - self.len % 64);
            self.push_word(word, take);
            left -= take;
        }
    }

    /// Appends the first `n` bits of these bytes, of each the lowest bit first; `None` where there are fewer.
    pub fn push_bytes(&mut self, bytes: &[u8], n: usize) -> Option<()> {
        let bytes = bytes.get(..n.div_ceil(8))?;
        let (eights, rest) = bytes.as_chunks::<8>();
        let mut left = n;
        for eight in eights {
            self.push_word(u64::from_le_bytes(*eight), left.min(64));
            left -= left.min(64);
        }
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.push_word(u64::from_le_bytes(last), left);
        Some(())
    }

    /// The bit of a row.
    pub fn get(&self, row: usize) -> bool {
        self.words.get(row / 64).is_some_and(|w| w >> (row % 64) & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn appended_bits_are_a_vector_of_bools(
            parts in prop::collection::vec((any::<[u8; 24]>(), 0usize..190, any::<bool>(), any::<bool>()), 0..12),
        ) {
            let (mut bits, mut expected) = (Bitmap::default(), Vec::new());
            for (bytes, n, same, bit) in parts {
                if same {
                    bits.push_run(bit, n);
                    expected.extend(std::iter::repeat_n(bit, n));
                } else {
                    bits.push_bytes(&bytes, n).unwrap();
                    expected.extend((0..n).map(|i| bytes[i / 8] >> (i % 8) & 1 == 1));
                }
            }
            prop_assert_eq!(bits.len, expected.len());
            prop_assert_eq!(bits.words.len(), expected.len().div_ceil(64));
            prop_assert_eq!(bits.ones, expected.iter().filter(|b| **b).count());
            prop_assert_eq!((0..bits.len).map(|i| bits.get(i)).collect::<Vec<_>>(), expected);
        }
    }
}
