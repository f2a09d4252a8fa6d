//! Comparisons of numbers that have standard deviations (`crate::deviation` defines them), on the stretches of a
//! column.

use super::compare::within_noise;
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
    // Few rows are within noise of the other side: these keep the value of the previous row.
    let near = match (a, b) {
        (_, Numbers::Same(bound, _)) => a.within_noise_of(*bound, noise),
        (Numbers::Same(bound, _), _) => b.within_noise_of(*bound, noise),
        _ => None,
    };
    let near = near.unwrap_or_else(|| within_noise(&a.cut(), &b.cut(), &noise.cut()));
    let truth = a.compare(op, b);
    if near.none() {
        return truth;
    }
    let (mut yes, known) = ((*truth.yes).clone(), truth.known);
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
    Truth { yes: yes.into(), known }
}
