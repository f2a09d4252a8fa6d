//! Comparisons of numbers that have standard deviations (`crate::deviation` defines them), on the stretches of a
//! column.

use super::bits::Bits;
use super::compare::holds;
use super::layout::Segment;
use super::numbers::Numbers;
use super::truth::Truth;
use crate::deviation::stated;
use crate::language::syntax::CompareOp;

/// Truth of a comparison; each stretch is compared by itself.
pub(super) fn crossed(
    op: CompareOp,
    (a, b): (&Numbers<'_>, &Numbers<'_>),
    noise: &[f64],
    segments: &[Segment],
) -> Truth {
    let (a, b) = (a.cut(), b.cut());
    let n = noise.len();
    let (mut yes, mut known) = (vec![false; n], vec![false; n]);
    for segment in segments {
        let mut before = None;
        for i in segment.range() {
            if a[i].is_nan() || b[i].is_nan() {
                before = None;
                continue;
            }
            let within = (a[i] - b[i]).abs() <= stated(noise[i]) && stated(noise[i]) > 0.0;
            let now = match before {
                Some(held) if within => held,
                _ => holds(op, a[i], b[i]),
            };
            (yes[i], known[i], before) = (now, true, Some(now));
        }
    }
    Truth::new(Bits::collect(n, |i| yes[i]), Bits::collect(n, |i| known[i]))
}
