//! Numbers per row, and how they are compared. A store returns the numbers of the known rows only, one after
//! another: they are compared as they are, and only the resulting bits are spread over the rows; so are the
//! numbers where an operator needs one per row. A column that is compared again first gets the range of each 64
//! numbers (signals change slowly), so that most words are decided without reading their numbers, however many
//! rules ask.

use super::bits::Bits;
use super::compare::{compare_columns, compare_slice, compare_word, holds, pack_all, range, settled};
use super::truth::Truth;
use crate::language::syntax::CompareOp;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::ops::Range;
use std::rc::Rc;

/// A column of numbers.
#[derive(Debug)]
pub struct NumberColumn<'a> {
    /// One number per row, NaN where it is unknown; or those of the known rows alone.
    stored: Cow<'a, [f64]>,
    /// The rows of the stored numbers, unless all.
    of_rows: Option<Rc<Bits>>,
    known: OnceCell<Rc<Bits>>,
    /// One number per row, computed on first use.
    by_row: OnceCell<Vec<f64>>,
    /// How many numbers are stored before each 64 rows.
    before: OnceCell<Vec<usize>>,
    compared: Cell<bool>,
    /// Least and greatest known value of each 64 stored numbers; infinity and minus infinity where none is known.
    ranges: OnceCell<Vec<(f64, f64)>>,
    /// The same of each 64 rows, where not every row is stored.
    ranges_by_row: OnceCell<Vec<(f64, f64)>>,
}

/// One number per row.
#[derive(Clone, Debug)]
pub enum Numbers<'a> {
    /// The same value in this number of rows.
    Same(f64, usize),
    /// Some rows of a column.
    Column(Rc<NumberColumn<'a>>, Range<usize>),
}

/// All numbers of a column, or one for all rows, with the range of each 64 rows.
#[derive(Clone, Copy, Debug)]
pub enum Ranged<'n> {
    /// The same value in all rows.
    Same(f64),
    /// A value per row, and least and greatest known value of each 64 rows.
    Column {
        /// NaN where it is unknown.
        values: &'n [f64],
        /// Infinity and minus infinity where none is known.
        ranges: &'n [(f64, f64)],
    },
}

impl Ranged<'_> {
    /// The numbers of up to 64 rows; `room` is where the same value is repeated.
    pub fn rows<'r>(&'r self, rows: Range<usize>, room: &'r mut [f64; 64]) -> &'r [f64] {
        match self {
            Self::Same(x) => {
                room.fill(*x);
                &room[..rows.len()]
            }
            Self::Column { values, .. } => &values[rows],
        }
    }

    /// Least and greatest known number of 64 rows.
    pub fn range(&self, word: usize) -> (f64, f64) {
        match self {
            Self::Same(x) => (*x, *x),
            Self::Column { ranges, .. } => ranges[word],
        }
    }

    /// Distance from zero of the known number of 64 rows that is farthest from it; 0 where none is known.
    pub fn greatest_size(&self, word: usize) -> f64 {
        let (least, greatest) = self.range(word);
        if least <= greatest { least.abs().max(greatest.abs()) } else { 0.0 }
    }
}

impl<'a> NumberColumn<'a> {
    /// One number per row; NaN is unknown.
    pub fn of_rows(values: impl Into<Cow<'a, [f64]>>) -> Self {
        Self {
            stored: values.into(),
            of_rows: None,
            known: OnceCell::new(),
            by_row: OnceCell::new(),
            before: OnceCell::new(),
            compared: Cell::new(false),
            ranges: OnceCell::new(),
            ranges_by_row: OnceCell::new(),
        }
    }

    /// The numbers of these rows, one after another; the others are unknown.
    pub fn of_known(values: Vec<f64>, known: Bits) -> Self {
        debug_assert_eq!(values.len(), known.count());
        let known = Rc::new(known);
        // As many numbers as rows: one number per row.
        let of_rows = (values.len() < known.len()).then(|| known.clone());
        Self { of_rows, known: known.into(), ..Self::of_rows(values) }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.of_rows.as_ref().map_or(self.stored.len(), |rows| rows.len())
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Which rows are known.
    pub fn known(&self) -> &Rc<Bits> {
        self.known.get_or_init(|| Rc::new(pack_all(&self.stored, |x| !x.is_nan())))
    }

    /// One number per row; NaN where it is unknown.
    pub fn values(&self) -> &[f64] {
        let Some(rows) = &self.of_rows else { return &self.stored };
        self.by_row.get_or_init(|| {
            let mut out = vec![f64::NAN; rows.len()];
            let mut from = 0;
            for run in rows.runs(0..rows.len()) {
                let n = run.len();
                out[run].copy_from_slice(&self.stored[from..from + n]);
                from += n;
            }
            out
        })
    }

    /// A number for each of these rows, without spreading those of all others.
    fn cut(&self, rows: Range<usize>) -> Cow<'_, [f64]> {
        let (Some(known), None) = (&self.of_rows, self.by_row.get()) else {
            return Cow::Borrowed(&self.values()[rows]);
        };
        let mut out = vec![f64::NAN; rows.len()];
        let before = self.before.get_or_init(|| known.counts_before());
        let word = rows.start / 64;
        let mut from = before.get(word).map_or(0, |n| n + known.count_in(word * 64..rows.start));
        for run in known.runs(rows.clone()) {
            let n = run.len();
            out[run.start - rows.start..run.end - rows.start].copy_from_slice(&self.stored[from..from + n]);
            from += n;
        }
        Cow::Owned(out)
    }

    /// The number in a row; NaN where it is unknown.
    fn at(&self, row: usize) -> f64 {
        let Some(rows) = &self.of_rows else { return self.stored[row] };
        if !rows.get(row) {
            return f64::NAN;
        }
        let before = self.before.get_or_init(|| rows.counts_before());
        self.stored[before[row / 64] + rows.count_in(row / 64 * 64..row)]
    }

    /// Least and greatest known value of each 64 stored numbers.
    fn ranges(&self) -> &[(f64, f64)] {
        self.ranges.get_or_init(|| self.stored.chunks(64).map(range).collect())
    }

    /// Least and greatest known value of each 64 rows.
    fn ranges_of_rows(&self) -> &[(f64, f64)] {
        if self.of_rows.is_none() {
            return self.ranges();
        }
        self.ranges_by_row.get_or_init(|| self.values().chunks(64).map(range).collect())
    }

    fn compare(&self, op: CompareOp, bound: f64) -> Bits {
        // For a single use, ranges do not pay off.
        let yes = if self.compared.replace(true) || self.ranges.get().is_some() {
            let each = self.stored.chunks(64).zip(self.ranges()).map(|(rows, range)| {
                match settled(op, *range, bound) {
                    Some(true) => u64::MAX,
                    Some(false) => 0,
                    None => compare_word(op, rows, bound),
                }
            });
            Bits::of_words(each.collect(), self.stored.len())
        } else {
            compare_slice(op, &self.stored, bound)
        };
        match &self.of_rows {
            Some(rows) => yes.spread_over(rows),
            None => yes.map2(self.known(), |y, k| y & k),
        }
    }
}

impl<'a> Numbers<'a> {
    /// All rows of a column.
    pub fn of(values: impl Into<Cow<'a, [f64]>>) -> Self {
        Self::all(Rc::new(NumberColumn::of_rows(values)))
    }

    /// All rows of a column.
    pub fn all(column: Rc<NumberColumn<'a>>) -> Self {
        let rows = 0..column.len();
        Self::Column(column, rows)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Same(_, n) => *n,
            Self::Column(_, rows) => rows.len(),
        }
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number in a row.
    pub fn at(&self, row: usize) -> f64 {
        match self {
            Self::Same(x, _) => *x,
            Self::Column(column, rows) => column.at(rows.start + row),
        }
    }

    /// These rows alone.
    #[must_use]
    pub fn slice(&self, rows: Range<usize>) -> Self {
        match self {
            Self::Same(x, _) => Self::Same(*x, rows.len()),
            Self::Column(column, own) => {
                Self::Column(column.clone(), own.start + rows.start..own.start + rows.end)
            }
        }
    }

    /// Each number changed by `f`.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Numbers<'static> {
        match self {
            Self::Same(x, n) => Numbers::Same(f(*x), *n),
            Self::Column(..) => Numbers::of(self.values().iter().map(|x| f(*x)).collect::<Vec<_>>()),
        }
    }

    /// Row by row with another.
    #[must_use]
    pub fn zip(&self, other: &Numbers<'_>, f: impl Fn(f64, f64) -> f64) -> Numbers<'static> {
        match (self, other) {
            (Self::Same(a, n), Numbers::Same(b, _)) => Numbers::Same(f(*a, *b), *n),
            (Self::Same(a, _), _) => other.map(|b| f(*a, b)),
            (_, Numbers::Same(b, _)) => self.map(|a| f(a, *b)),
            _ => Numbers::of(
                self.values().iter().zip(other.values().iter()).map(|(a, b)| f(*a, *b)).collect::<Vec<_>>(),
            ),
        }
    }

    /// The numbers as a slice.
    pub fn values(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Same(x, n) => Cow::Owned(vec![*x; *n]),
            Self::Column(column, rows) => Cow::Borrowed(&column.values()[rows.clone()]),
        }
    }

    /// The numbers as a slice, where few of a long column are needed.
    pub fn cut(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Same(..) => self.values(),
            Self::Column(column, rows) => column.cut(rows.clone()),
        }
    }

    /// The numbers with the range of each 64 of them; `None` for some rows of a column.
    pub fn ranged(&self) -> Option<Ranged<'_>> {
        match self {
            Self::Same(x, _) => Some(Ranged::Same(*x)),
            Self::Column(column, rows) => (*rows == (0..column.len()))
                .then(|| Ranged::Column { values: column.values(), ranges: column.ranges_of_rows() }),
        }
    }

    /// Which rows are known.
    pub fn known(&self) -> Rc<Bits> {
        match self {
            Self::Same(x, n) => Rc::new(if x.is_nan() { Bits::zeros(*n) } else { Bits::ones(*n) }),
            Self::Column(column, rows) if *rows == (0..column.len()) => column.known().clone(),
            Self::Column(column, rows) => Rc::new(column.known().slice(rows.clone())),
        }
    }

    /// Truth of a comparison, row by row.
    pub fn compare(&self, op: CompareOp, other: &Numbers<'_>) -> Truth {
        match (self, other) {
            (Numbers::Same(a, n), Numbers::Same(b, _)) => match a.is_nan() || b.is_nan() {
                true => Truth::unknown(*n),
                false => Truth::constant(holds(op, *a, *b), *n),
            },
            (_, Numbers::Same(b, _)) => self.compare_with(op, *b),
            (Numbers::Same(a, _), _) => other.compare_with(op.mirrored(), *a),
            _ => {
                let (a, b) = (self.values(), other.values());
                let mut known = (*self.known()).clone();
                known.and_with(&other.known());
                let yes = compare_columns(op, &a, &b);
                Truth::new(yes.map2(&known, |y, k| y & k), known)
            }
        }
    }

    fn compare_with(&self, op: CompareOp, bound: f64) -> Truth {
        if bound.is_nan() {
            return Truth::unknown(self.len());
        }
        let known = self.known();
        let yes = match self {
            Self::Column(column, rows) if *rows == (0..column.len()) => column.compare(op, bound),
            _ => compare_slice(op, &self.cut(), bound).map2(&known, |y, k| y & k),
        };
        Truth { yes: Rc::new(yes), known }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use whyroad_model::Tri;

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => (-4i32..5).prop_map(f64::from),
            1 => Just(f64::NAN),
            1 => Just(f64::INFINITY),
            1 => Just(f64::NEG_INFINITY),
        ]
    }

    const ALL: [CompareOp; 6] = [
        CompareOp::Less,
        CompareOp::LessOrEqual,
        CompareOp::Greater,
        CompareOp::GreaterOrEqual,
        CompareOp::Equal,
        CompareOp::NotEqual,
    ];

    fn expected(op: CompareOp, a: f64, b: f64) -> Tri {
        if a.is_nan() || b.is_nan() { Tri::Unknown } else { Tri::from(holds(op, a, b)) }
    }

    proptest! {
        #[test]
        fn comparisons_are_those_of_single_rows(
            rows in prop::collection::vec((number(), number()), 1..200),
            level in prop::collection::vec(-4i32..5, 4),
            bound in number(),
            from in 0usize..200,
        ) {
            // Stretches of equal values, so that whole words are decided by their range.
            let n = rows.len();
            let long: Vec<f64> = level.iter().flat_map(|l| std::iter::repeat_n(f64::from(*l), 70)).collect();
            let (a, b): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
            let from = from.min(n);
            for op in ALL {
                for v in [&a, &long] {
                    let whole = Numbers::of(v.clone());
                    let t = whole.compare(op, &Numbers::Same(bound, v.len()));
                    let m = Numbers::Same(bound, v.len()).compare(op, &whole);
                    for (i, x) in v.iter().enumerate() {
                        prop_assert_eq!(t.at(i), expected(op, *x, bound));
                        prop_assert_eq!(m.at(i), expected(op, bound, *x));
                    }
                }
                // As a store returns them: those of the known rows only. Twice, once without ranges and once with.
                let known = Bits::collect(n, |i| !a[i].is_nan());
                let stored = a.iter().copied().filter(|x| !x.is_nan()).collect();
                let dense = Numbers::all(Rc::new(NumberColumn::of_known(stored, known)));
                for _ in 0..2 {
                    let t = dense.compare(op, &Numbers::Same(bound, n));
                    for (i, x) in a.iter().enumerate() {
                        prop_assert_eq!(t.at(i), expected(op, *x, bound));
                        prop_assert_eq!(dense.at(i).to_bits(), x.to_bits());
                    }
                }
                prop_assert!(dense.slice(from..n).cut().iter().zip(&a[from..]).all(|(x, y)| x.to_bits() == y.to_bits()));
                prop_assert!(dense.values().iter().zip(&a).all(|(x, y)| x.to_bits() == y.to_bits()));
                let t = dense.slice(from..n).compare(op, &Numbers::Same(bound, n - from));
                for i in 0..n - from {
                    prop_assert_eq!(t.at(i), expected(op, a[from + i], bound));
                }
                let part = Numbers::of(a.clone()).slice(from..n);
                let t = part.compare(op, &Numbers::Same(bound, n - from));
                let both = part.compare(op, &Numbers::of(b.clone()).slice(from..n));
                for i in 0..n - from {
                    prop_assert_eq!(t.at(i), expected(op, a[from + i], bound));
                    prop_assert_eq!(both.at(i), expected(op, a[from + i], b[from + i]));
                }
            }
        }
    }
}
