//! Comparisons of numbers that have standard deviations (`crate::deviation` defines them), on the stretches of a
//! column.

use super::compare::{both_known, compare_columns, within_noise};
use super::layout::Segment;
use super::numbers::Numbers;
use super::truth::Truth;
use crate::language::syntax::CompareOp;

/// Truth of a comparison; each stretch is compared by itself.
pub(super) fn crossed(
    op: CompareOp,
    (a, b): (&Numbers<'_>, &Numbers<'_>),
    noise: &Numbers<'_>,
    segments: &[Segment],
) -> Truth {
    let n = noise.len();
    let (a, b, noise) = (a.cut(), b.cut(), noise.cut());
    let (a, b) = (&a[..n], &b[..n]);
    let known = both_known(a, b);
    let mut yes = compare_columns(op, a, b);
    yes.and_with(&known);
    // Few rows are within noise of the other side: these keep the value of the previous row.
    let near = within_noise(a, b, &noise);
    for segment in segments {
        let rows = segment.range();
        for i in near.positions(rows.start + 1..rows.end.max(rows.start + 1)) {
            match (known.get(i - 1), yes.get(i - 1)) {
                (true, true) => yes.set_range(i..i + 1),
                (true, false) => yes.clear_range(i..i + 1),
                (false, _) => {}
            }
        }
    }
    Truth::new(yes, known)
}
