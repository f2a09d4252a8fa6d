//! Numbers a row, and how they are compared: 64 rows make a word of truth. A column that is compared with a
//! constant first gets the range of each 64 rows (signals change slowly), so that most words are settled
//! without looking at their rows again, however many rules ask.

use super::bits::Bits;
use super::truth::Truth;
use crate::language::syntax::CompareOp;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::ops::Range;
use std::rc::Rc;

/// A column of numbers; NaN is unknown.
#[derive(Debug)]
pub struct NumberColumn<'a> {
    values: Cow<'a, [f64]>,
    known: OnceCell<Rc<Bits>>,
    /// Least and greatest known value of each 64 rows; infinity and minus infinity where none is known.
    ranges: OnceCell<Vec<(f64, f64)>>,
}

/// A number a row.
#[derive(Clone, Debug)]
pub enum Numbers<'a> {
    /// The same in so many rows.
    Same(f64, usize),
    /// Some rows of a column.
    Column(Rc<NumberColumn<'a>>, Range<usize>),
}

impl<'a> Numbers<'a> {
    /// All rows of a column.
    pub fn of(values: impl Into<Cow<'a, [f64]>>) -> Self {
        let values = values.into();
        let n = values.len();
        let column = NumberColumn { values, known: OnceCell::new(), ranges: OnceCell::new() };
        Self::Column(Rc::new(column), 0..n)
    }

    /// All rows of a column of which it is known already what is known.
    pub fn with_known(values: impl Into<Cow<'a, [f64]>>, known: Option<Rc<Bits>>) -> Self {
        let numbers = Self::of(values);
        if let (Self::Column(column, rows), Some(known)) = (&numbers, known)
            && known.len() == rows.len()
        {
            let _ = column.known.set(known);
        }
        numbers
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
            Self::Column(column, rows) => column.values[rows.start + row],
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
            Self::Column(column, rows) => Cow::Borrowed(&column.values[rows.clone()]),
        }
    }

    /// Which rows are known.
    pub fn known(&self) -> Rc<Bits> {
        match self {
            Self::Same(x, n) => Rc::new(if x.is_nan() { Bits::zeros(*n) } else { Bits::ones(*n) }),
            Self::Column(column, rows) => match self.whole() {
                Some(_) => column.known().clone(),
                None => Rc::new(pack_all(&column.values[rows.clone()], |x| !x.is_nan())),
            },
        }
    }

    fn whole(&self) -> Option<&NumberColumn<'a>> {
        match self {
            Self::Column(column, rows) if *rows == (0..column.values.len()) => Some(column),
            _ => None,
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
            (Numbers::Same(a, _), _) => other.compare_with(mirrored(op), *a),
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
        let yes = match self.whole() {
            Some(column) => column.compare(op, bound, &known),
            None => {
                let yes = compare_slice(op, &self.values(), bound);
                yes.map2(&known, |y, k| y & k)
            }
        };
        Truth { yes: Rc::new(yes), known }
    }
}

impl NumberColumn<'_> {
    fn known(&self) -> &Rc<Bits> {
        self.known.get_or_init(|| Rc::new(pack_all(&self.values, |x| !x.is_nan())))
    }

    fn compare(&self, op: CompareOp, bound: f64, known: &Bits) -> Bits {
        let ranges = self.ranges.get_or_init(|| self.values.chunks(64).map(range).collect());
        let words = self.values.chunks(64).zip(ranges).zip(known.words());
        let each = words.map(|((rows, range), known)| match settled(op, *range, bound) {
            Some(true) => *known,
            Some(false) => 0,
            None => compare_word(op, rows, bound) & known,
        });
        Bits::of_words(each.collect(), self.values.len())
    }
}

/// What a comparison says for all values of a range, where it says the same for all.
fn settled(op: CompareOp, (least, greatest): (f64, f64), bound: f64) -> Option<bool> {
    if least > greatest {
        return Some(false);
    }
    match op {
        CompareOp::Less if greatest < bound => Some(true),
        CompareOp::Less if least >= bound => Some(false),
        CompareOp::LessOrEqual if greatest <= bound => Some(true),
        CompareOp::LessOrEqual if least > bound => Some(false),
        CompareOp::Greater if least > bound => Some(true),
        CompareOp::Greater if greatest <= bound => Some(false),
        CompareOp::GreaterOrEqual if least >= bound => Some(true),
        CompareOp::GreaterOrEqual if greatest < bound => Some(false),
        CompareOp::Equal if bound < least || bound > greatest => Some(false),
        CompareOp::NotEqual if bound < least || bound > greatest => Some(true),
        _ => None,
    }
}

/// Least and greatest known value of up to 64 rows. Eight at a time: the comparisons skip NaN, and a
/// compiler turns them into vector instructions.
fn range(rows: &[f64]) -> (f64, f64) {
    let (mut least, mut greatest) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
    let (eights, rest) = rows.as_chunks::<8>();
    for eight in eights {
        for k in 0..8 {
            least[k] = if eight[k] < least[k] { eight[k] } else { least[k] };
            greatest[k] = if eight[k] > greatest[k] { eight[k] } else { greatest[k] };
        }
    }
    for (k, x) in rest.iter().enumerate() {
        least[k] = if *x < least[k] { *x } else { least[k] };
        greatest[k] = if *x > greatest[k] { *x } else { greatest[k] };
    }
    let least = least.into_iter().fold(f64::INFINITY, f64::min);
    (least, greatest.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

fn holds(op: CompareOp, a: f64, b: f64) -> bool {
    match op {
        CompareOp::Less => a < b,
        CompareOp::LessOrEqual => a <= b,
        CompareOp::Greater => a > b,
        CompareOp::GreaterOrEqual => a >= b,
        CompareOp::Equal => a == b,
        CompareOp::NotEqual => a != b,
    }
}

fn mirrored(op: CompareOp) -> CompareOp {
    match op {
        CompareOp::Less => CompareOp::Greater,
        CompareOp::LessOrEqual => CompareOp::GreaterOrEqual,
        CompareOp::Greater => CompareOp::Less,
        CompareOp::GreaterOrEqual => CompareOp::LessOrEqual,
        same @ (CompareOp::Equal | CompareOp::NotEqual) => same,
    }
}

/// Up to 64 rows to a word.
fn compare_word(op: CompareOp, rows: &[f64], b: f64) -> u64 {
    // One loop an operator: the operator is no longer asked for in each row.
    match op {
        CompareOp::Less => pack(rows, |a| a < b),
        CompareOp::LessOrEqual => pack(rows, |a| a <= b),
        CompareOp::Greater => pack(rows, |a| a > b),
        CompareOp::GreaterOrEqual => pack(rows, |a| a >= b),
        CompareOp::Equal => pack(rows, |a| a == b),
        CompareOp::NotEqual => pack(rows, |a| a != b),
    }
}

fn compare_slice(op: CompareOp, rows: &[f64], b: f64) -> Bits {
    Bits::of_words(rows.chunks(64).map(|w| compare_word(op, w, b)).collect(), rows.len())
}

fn compare_columns(op: CompareOp, a: &[f64], b: &[f64]) -> Bits {
    let words = a.chunks(64).zip(b.chunks(64)).map(|(a, b)| match op {
        CompareOp::Less => pack2(a, b, |a, b| a < b),
        CompareOp::LessOrEqual => pack2(a, b, |a, b| a <= b),
        CompareOp::Greater => pack2(a, b, |a, b| a > b),
        CompareOp::GreaterOrEqual => pack2(a, b, |a, b| a >= b),
        CompareOp::Equal => pack2(a, b, |a, b| a == b),
        CompareOp::NotEqual => pack2(a, b, |a, b| a != b),
    });
    Bits::of_words(words.collect(), a.len())
}

/// A bit an item.
pub fn pack_all<T: Copy>(items: &[T], f: impl Fn(T) -> bool + Copy) -> Bits {
    Bits::of_words(items.chunks(64).map(|w| pack(w, f)).collect(), items.len())
}

fn pack<T: Copy>(items: &[T], f: impl Fn(T) -> bool) -> u64 {
    let mut flags = [0u8; 64];
    for (flag, item) in flags.iter_mut().zip(items) {
        *flag = u8::from(f(*item));
    }
    gathered(&flags)
}

fn pack2(a: &[f64], b: &[f64], f: impl Fn(f64, f64) -> bool) -> u64 {
    let mut flags = [0u8; 64];
    for ((flag, a), b) in flags.iter_mut().zip(a).zip(b) {
        *flag = u8::from(f(*a, *b));
    }
    gathered(&flags)
}

/// 64 bytes of 0 or 1 to 64 bits. The product moves byte i of eight to bit 56 + i, with no carry between them.
fn gathered(flags: &[u8; 64]) -> u64 {
    let (eights, _) = flags.as_chunks::<8>();
    let byte = |eight: &[u8; 8]| u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    eights.iter().enumerate().fold(0, |word, (i, eight)| word | byte(eight) << (8 * i))
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
            // Stretches of equal values, so that whole words are settled by their range.
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
