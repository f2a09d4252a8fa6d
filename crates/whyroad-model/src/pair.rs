//! Signals of pairs of objects: rows only for pairs that come near each other, and only from the first to the last
//! frame in which they are near.

use crate::{Column, FrameRange};
use std::collections::BTreeMap;
use std::ops::Range;

/// Two objects farther apart than this, box to box, are not a pair, m.
pub const PAIR_REACH_M: f64 = 50.0;

/// Signals of ordered pairs of the targets of one drive.
#[derive(Clone, Debug, Default)]
pub struct PairTable {
    /// Ordered by first, then second object. Each pair occurs in both orders, with the same frames.
    pub spans: Vec<PairSpan>,
    /// By row: whether both are observed in the frame, and within [`PAIR_REACH_M`].
    pub near: Vec<bool>,
    /// Signals by name (`pair.distance`); each has as many rows as `near`.
    pub columns: BTreeMap<String, Column>,
}

/// Where the rows of one pair are: dense over its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PairSpan {
    /// Index of the object that `pair.` signals are about.
    pub first: usize,
    /// Index of the other one.
    pub second: usize,
    /// Row of the first frame in every column.
    pub first_row: usize,
    /// From the first to the last frame in which they are near; both tracks cover all of them.
    pub frames: FrameRange,
}

impl PairSpan {
    /// Its rows in every column.
    pub fn rows(&self) -> Range<usize> {
        self.first_row..self.first_row + self.frames.len()
    }
}

impl PairTable {
    /// Index of the span of a pair; `None` when the two never come near.
    pub fn find(&self, first: usize, second: usize) -> Option<usize> {
        self.spans.binary_search_by_key(&(first, second), |s| (s.first, s.second)).ok()
    }

    /// Indices of the spans of all pairs that are about this object.
    pub fn of_first(&self, first: usize) -> Range<usize> {
        self.spans.partition_point(|s| s.first < first)..self.spans.partition_point(|s| s.first <= first)
    }

    /// Index of the span with the two exchanged.
    pub fn reversed(&self, span: usize) -> Option<usize> {
        let PairSpan { first, second, .. } = *self.spans.get(span)?;
        self.find(second, first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_found_in_both_orders() {
        let span = |first, second, first_row, n: usize| PairSpan {
            first,
            second,
            first_row,
            frames: FrameRange::new(2, 2 + n),
        };
        let table = PairTable {
            spans: vec![span(0, 2, 0, 3), span(1, 2, 3, 1), span(2, 0, 4, 3), span(2, 1, 7, 1)],
            ..PairTable::default()
        };
        assert_eq!(table.find(1, 2), Some(1));
        assert_eq!(table.find(0, 1), None);
        assert_eq!(table.of_first(2), 2..4);
        assert_eq!(table.reversed(0), Some(2));
        assert_eq!(table.spans[3].rows(), 7..8);
    }
}
