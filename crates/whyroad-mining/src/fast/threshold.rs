//! Comparisons of numbers that have standard deviations (`crate::deviation` defines them), on the stretches of a
//! column.

use super::bits::Bits;
use super::compare::{is_within_noise, within_noise, within_noise_word};
use super::layout::Segment;
use super::numbers::Numbers;
use super::truth::Truth;
use crate::deviation::{ROWS_ACROSS, of_sum, stated};
use crate::language::syntax::CompareOp;
use std::ops::Range;

/// Standard deviations of a number.
#[derive(Clone, Debug)]
pub(super) enum Noise<'a> {
    /// One per row.
    One(Numbers<'a>),
    /// Those of a sum of two numbers, which have these. A root is slow, and a comparison needs few of them.
    Sum(Numbers<'a>, Numbers<'a>),
}

impl<'a> Noise<'a> {
    /// One per row.
    pub fn numbers(self) -> Numbers<'a> {
        match self {
            Self::One(noise) => noise,
            Self::Sum(a, b) => a.zip(&b, of_sum),
        }
    }
}

/// Rows where two numbers differ by no more than their noise, as [`within_noise`] defines it: by the ranges of 64 rows
/// each first, which decide most. `None` where not all rows of a column are asked: then ranges do not pay off.
fn near_by_ranges(a: &Numbers<'_>, b: &Numbers<'_>, noise: &Noise<'_>) -> Option<Bits> {
    let n = a.len();
    let (a, b) = (a.ranged()?, b.ranged()?);
    let (of_a, of_b) = match noise {
        Noise::One(noise) => (noise.ranged()?, None),
        Noise::Sum(of_a, of_b) => (of_a.ranged()?, Some(of_b.ranged()?)),
    };
    let (mut room, mut bounds) = ([[0.0; 64]; 4], [0.0; 64]);
    let word = |k: usize| {
        let ((a_least, a_greatest), (b_least, b_greatest)) = (a.range(k), b.range(k));
        // Differences are rounded, too, but a greater one never to less.
        let apart = (a_least - b_greatest).max(b_least - a_greatest);
        let most = match &of_b {
            None => of_a.greatest_size(k),
            Some(of_b) => at_most(of_a.greatest_size(k), of_b.greatest_size(k)),
        };
        if most == 0.0 || apart > most {
            return 0;
        }
        let rows = k * 64..(k * 64 + 64).min(n);
        let [in_a, in_b, in_of_a, in_of_b] = &mut room;
        let (a, b) = (a.rows(rows.clone(), in_a), b.rows(rows.clone(), in_b));
        let of_a = of_a.rows(rows.clone(), in_of_a);
        let Some(of_b) = &of_b else { return within_noise_word(a, b, of_a) };
        let of_b = of_b.rows(rows, in_of_b);
        // Only where the sum of the two is enough, the root is taken.
        bounds.iter_mut().zip(of_a.iter().zip(of_b)).for_each(|(bound, (x, y))| {
            *bound = at_most(stated(*x), stated(*y));
        });
        let (mut near, mut left) = (0, within_noise_word(a, b, &bounds[..a.len()]));
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            near |= u64::from(is_within_noise(a[i], b[i], of_sum(of_a[i], of_b[i]))) << i;
            left &= left - 1;
        }
        near
    };
    Some(Bits::of_words((0..n.div_ceil(64)).map(word).collect(), n))
}

/// A bound for the root of the sum of the squares of two numbers that are not negative, rounding included.
fn at_most(a: f64, b: f64) -> f64 {
    (a + b) * (1.0 + 1e-12)
}

/// Truth of a comparison; each stretch is compared by itself.
pub(super) fn crossed(
    op: CompareOp,
    (a, b): (&Numbers<'_>, &Numbers<'_>),
    noise: Noise<'_>,
    segments: &[Segment],
) -> Truth {
    // Few rows are within noise of the other side: these keep the value of the previous row for a time.
    let near = near_by_ranges(a, b, &noise)
        .unwrap_or_else(|| within_noise(&a.cut(), &b.cut(), &noise.numbers().cut()));
    let truth = a.compare(op, b);
    if near.none() {
        return truth;
    }
    let (mut yes, known) = ((*truth.yes).clone(), truth.known);
    let set = |yes: &mut Bits, rows: Range<usize>, value: bool| {
        if value { yes.set_range(rows) } else { yes.clear_range(rows) }
    };
    for segment in segments {
        let rows = segment.range();
        // Rows in succession that contradict the answer before them, and have kept it so far.
        let mut across = rows.start..rows.start;
        // A row beyond noise after them either proves them right, or they were noise.
        let prove = |yes: &mut Bits, across: &Range<usize>| {
            let next = across.end;
            if !across.is_empty() && next < rows.end && known.get(next) && yes.get(next) != yes.get(next - 1)
            {
                let value = yes.get(next);
                set(yes, across.clone(), value);
            }
        };
        for i in near.positions(rows.start + 1..rows.end.max(rows.start + 1)) {
            if across.end != i {
                prove(&mut yes, &across);
                across = i..i;
            }
            let before = yes.get(i - 1);
            if !known.get(i - 1) || yes.get(i) == before {
                across = i + 1..i + 1;
                continue;
            }
            across.end = i + 1;
            if across.len() == ROWS_ACROSS {
                set(&mut yes, across, !before);
                across = i + 1..i + 1;
            } else {
                set(&mut yes, i..i + 1, before);
            }
        }
        prove(&mut yes, &across);
    }
    Truth { yes: yes.into(), known }
}
