//! Row operations for margins: comparisons, agreement with the truth, moving extremes.

use crate::comparison::{MARGIN_LIMIT, compare};
use crate::fast::numbers::Numbers;
use crate::fast::truth::Truth;
use crate::language::syntax::CompareOp;
use std::ops::Range;
use whyroad_model::Tri;

/// Margins of a comparison on these rows, as [`compare`] defines them.
pub fn compared(
    op: CompareOp,
    left: &Numbers<'_>,
    right: &Numbers<'_>,
    scale: f64,
    rows: Range<usize>,
) -> Vec<f64> {
    let (a, b) = (left.slice(rows.clone()), right.slice(rows));
    // One loop per operator: so that rows need no check of it.
    match op {
        CompareOp::Less | CompareOp::LessOrEqual => each(&a, &b, |x, y| of_difference(x, y, y - x, scale)),
        CompareOp::Greater | CompareOp::GreaterOrEqual => {
            each(&a, &b, |x, y| of_difference(x, y, x - y, scale))
        }
        CompareOp::Equal | CompareOp::NotEqual => each(&a, &b, |x, y| compare(op, x, y, scale).1),
    }
}

fn of_difference(x: f64, y: f64, raw: f64, scale: f64) -> f64 {
    let raw = if raw.is_nan() { 0.0 } else { raw };
    let margin = (raw / scale).clamp(-MARGIN_LIMIT, MARGIN_LIMIT);
    if x.is_nan() || y.is_nan() { f64::NAN } else { margin }
}

fn each(a: &Numbers<'_>, b: &Numbers<'_>, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    match (a, b) {
        (_, Numbers::Same(y, _)) => a.cut().iter().map(|x| f(*x, *y)).collect(),
        (Numbers::Same(x, _), _) => b.cut().iter().map(|y| f(*x, *y)).collect(),
        _ => a.cut().iter().zip(b.cut().iter()).map(|(x, y)| f(*x, *y)).collect(),
    }
}

/// Adjusts margins to agree with the truth of the same number of rows from the first one on.
pub fn settle(margins: &mut [f64], truth: &Truth, first: usize) {
    for (k, margins) in margins.chunks_mut(64).enumerate() {
        let at = first + 64 * k;
        let (yes, known) = (truth.yes.word_at(at), truth.known.word_at(at));
        // Mostly all rows are of one truth: then no row is asked for its own.
        let all = u64::MAX >> (64 - margins.len());
        match (yes & all, known & all) {
            (0, k) if k == all => {
                margins.iter_mut().for_each(|m| *m = settled(Tri::False, *m));
                continue;
            }
            (y, k) if y == all && k == all => {
                margins.iter_mut().for_each(|m| *m = settled(Tri::True, *m));
                continue;
            }
            _ => {}
        }
        for (i, margin) in margins.iter_mut().enumerate() {
            let [is_true, is_known] = [yes, known].map(|word| word >> i & 1 == 1);
            *margin = settled(is_known.then_some(is_true).into(), *margin);
        }
    }
}

/// A margin adjusted to agree with its truth: NaN where unknown; `max` and `min` turn one that could not be
/// computed into 0.
pub fn settled(truth: Tri, margin: f64) -> f64 {
    match truth {
        Tri::Unknown => f64::NAN,
        Tri::True => margin.max(0.0),
        Tri::False => margin.min(0.0),
    }
}

/// The greatest known value in each of these windows, which begin one row after another and only ever move forward;
/// minus infinity where none is known.
pub fn greatest_ahead(values: &[f64], ends: &[usize]) -> Vec<f64> {
    // Mostly all windows but the last ones are of one width.
    let width = ends.first().copied().unwrap_or(0);
    let even = ends.iter().enumerate().take_while(|(i, end)| **end - i == width).count();
    let mut out = if width > 0 { greatest_of(values, width, even) } else { Vec::new() };
    let done = out.len();
    let rest = ends.iter().enumerate().skip(done).map(|(i, end)| (i, *end));
    out.extend(sliding(values, rest, f64::NEG_INFINITY, |x, y| x > y));
    out
}

/// The greatest known of `width` values from each of the first `n` on: of two first, then of four, and so on.
fn greatest_of(values: &[f64], width: usize, n: usize) -> Vec<f64> {
    let reach = &values[..values.len().min(n + width)];
    let known = reach.iter().map(|x| if x.is_nan() { f64::NEG_INFINITY } else { *x });
    picked(known.collect(), width, n, |x, y| if x > y { x } else { y })
}

/// Of all windows of one width that hold a row, the best one as judged by its worst known row; minus infinity where no
/// window holds the row. There are `windows` of them, the first one beginning with the first value, each one row after
/// the other.
pub fn best_of_even(values: &[f64], width: usize, windows: usize, rows: Range<usize>) -> Vec<f64> {
    let known = values.iter().map(|x| if x.is_nan() { f64::INFINITY } else { *x });
    let worst = picked(known.collect(), width, windows, |x, y| if x < y { x } else { y });
    // The windows that hold a row begin with one of the `width` rows up to it.
    let from = rows.start as i64 - (width as i64 - 1);
    let begun = (from..rows.end as i64).map(|k| usize::try_from(k).ok().and_then(|k| worst.get(k)).copied());
    let begun = begun.map(|w| w.unwrap_or(f64::NEG_INFINITY)).collect();
    picked(begun, width, rows.len(), |x, y| if x > y { x } else { y })
}

/// The one that is picked out of `width` values from each of the first `n` on: out of two first, then of four, and so
/// on.
fn picked(mut of_some: Vec<f64>, width: usize, n: usize, pick: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut some = 1;
    while 2 * some <= width {
        let ahead = of_some.get(some..).unwrap_or_default();
        of_some = of_some.iter().zip(ahead).map(|(x, y)| pick(*x, *y)).collect();
        some *= 2;
    }
    let ahead = of_some.get(width - some..).unwrap_or_default();
    of_some.iter().zip(ahead).take(n).map(|(x, y)| pick(*x, *y)).collect()
}

/// Extreme of the known values in each of these windows, which only ever move forward; `none` where nothing is known.
pub fn sliding(
    values: &[f64],
    windows: impl Iterator<Item = (usize, usize)>,
    none: f64,
    better: impl Fn(f64, f64) -> bool,
) -> Vec<f64> {
    // Those that can still become the extreme, the best one first; those before `head` are over.
    let mut candidates: Vec<usize> = Vec::new();
    let (mut head, mut taken) = (0, 0);
    windows
        .map(|(start, end)| {
            for (i, x) in values.iter().enumerate().take(end).skip(taken) {
                if !x.is_nan() {
                    while candidates.len() > head && !better(values[candidates[candidates.len() - 1]], *x) {
                        candidates.pop();
                    }
                    candidates.push(i);
                }
            }
            taken = taken.max(end);
            while candidates.get(head).is_some_and(|&k| k < start) {
                head += 1;
            }
            candidates.get(head).map_or(none, |&k| values[k])
        })
        .collect()
}

/// In each of some rows, the margin of the object that is needed last to reach a number.
pub enum Deciding {
    /// For no object.
    None(usize),
    /// For one object: the greatest margin so far, or [`LEAST`].
    First(Vec<f64>),
    /// For this number of objects: all margins.
    Nth(usize, Vec<Vec<f64>>),
}

/// Less than all numbers in the order of `total_cmp`: NaN with a sign.
const LEAST: f64 = -f64::NAN;

impl Deciding {
    /// No margin so far in this number of rows.
    pub fn new(count: usize, rows: usize) -> Self {
        match count {
            0 => Self::None(rows),
            1 => Self::First(vec![LEAST; rows]),
            _ => Self::Nth(count, vec![Vec::new(); rows]),
        }
    }

    /// Adds the margin of an object in a row; NaN is none.
    pub fn add(&mut self, row: usize, margin: f64) {
        match self {
            _ if margin.is_nan() => {}
            Self::None(_) => {}
            Self::First(best) => {
                if best[row].total_cmp(&margin).is_lt() {
                    best[row] = margin;
                }
            }
            Self::Nth(_, all) => all[row].push(margin),
        }
    }

    /// Adds the margins of an object in these rows, beginning with row `first`.
    pub fn add_all(&mut self, first: usize, margins: &[f64]) {
        match self {
            Self::First(best) => {
                for (best, margin) in best[first..].iter_mut().zip(margins) {
                    let is_greater = !margin.is_nan() && best.total_cmp(margin).is_lt();
                    *best = if is_greater { *margin } else { *best };
                }
            }
            _ => margins.iter().enumerate().for_each(|(k, margin)| self.add(first + k, *margin)),
        }
    }

    /// The margin of each row; the least one where there are too few objects.
    pub fn finish(self) -> Vec<f64> {
        let or_least = |margin: f64| if margin.is_nan() { -MARGIN_LIMIT } else { margin };
        match self {
            Self::None(rows) => vec![MARGIN_LIMIT; rows],
            Self::First(best) => best.into_iter().map(or_least).collect(),
            Self::Nth(count, all) => {
                let nth = |mut margins: Vec<f64>| {
                    if margins.len() < count {
                        return -MARGIN_LIMIT;
                    }
                    *margins.select_nth_unstable_by(count - 1, |a, b| b.total_cmp(a)).1
                };
                all.into_iter().map(nth).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_deciding_margin_is_that_of_sorted_ones(
            margins in prop::collection::vec((0usize..4, prop_oneof![
                4 => -9.0f64..9.0, 1 => Just(f64::NAN), 1 => Just(0.0), 1 => Just(-0.0),
                1 => Just(f64::NEG_INFINITY),
            ]), 0..60),
            count in 0usize..5,
        ) {
            let mut deciding = Deciding::new(count, 4);
            margins.iter().for_each(|(row, m)| deciding.add(*row, *m));
            let expected = |row: usize| {
                let mut own: Vec<f64> =
                    margins.iter().filter(|(r, m)| *r == row && !m.is_nan()).map(|(_, m)| *m).collect();
                own.sort_by(|a, b| b.total_cmp(a));
                match count.checked_sub(1) {
                    None => MARGIN_LIMIT,
                    Some(last) => own.get(last).copied().unwrap_or(-MARGIN_LIMIT),
                }
            };
            let bits = |all: Vec<f64>| all.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            let mut at_once = Deciding::new(count, 4);
            margins.iter().for_each(|(row, m)| at_once.add_all(*row, &[*m]));
            prop_assert_eq!(bits(at_once.finish()), bits((0..4).map(expected).collect()));
            prop_assert_eq!(bits(deciding.finish()), bits((0..4).map(expected).collect()));
        }

        #[test]
        fn the_greatest_ahead_is_the_greatest_of_each_window(
            values in prop::collection::vec(prop_oneof![3 => -9.0f64..9.0, 1 => Just(f64::NAN)], 1..200),
            width in 1usize..20,
            wider in 0usize..300,
        ) {
            let n = values.len();
            // From some row on the windows are a little wider, and none goes on behind the end.
            let ends: Vec<usize> = (0..n).map(|i| (i + width + usize::from(i >= wider)).min(n)).collect();
            let expected: Vec<f64> = ends.iter().enumerate().map(|(i, end)| {
                values[i..*end].iter().copied().filter(|x| !x.is_nan()).fold(f64::NEG_INFINITY, f64::max)
            }).collect();
            prop_assert_eq!(greatest_ahead(&values, &ends), expected);
            // Windows of one width that are whole.
            let windows = (n + 1).saturating_sub(width);
            let worst = |k: usize| {
                values[k..k + width].iter().copied().filter(|x| !x.is_nan()).fold(f64::INFINITY, f64::min)
            };
            let from = wider % n;
            let best = |i: usize| {
                let holding = (0..windows).filter(|k| *k <= i && i < k + width);
                holding.map(worst).fold(f64::NEG_INFINITY, f64::max)
            };
            let expected: Vec<f64> = (from..n).map(best).collect();
            if windows > 0 {
                prop_assert_eq!(best_of_even(&values, width, windows, from..n), expected);
            }
        }
    }
}
