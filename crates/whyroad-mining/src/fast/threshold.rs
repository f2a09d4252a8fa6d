//! Comparisons of numbers that have standard deviations (`crate::deviation` defines them), on the stretches of a
//! column.

use super::compare::within_noise;
use super::layout::Segment;
use super::numbers::Numbers;
use super::truth::Truth;
use crate::deviation::ROWS_ACROSS;
use crate::language::syntax::CompareOp;

/// Truth of a comparison; each stretch is compared by itself.
pub(super) fn crossed(
    op: CompareOp,
    (a, b): (&Numbers<'_>, &Numbers<'_>),
    noise: &Numbers<'_>,
    segments: &[Segment],
) -> Truth {
    // Few rows are within noise of the other side: these keep the value of the previous row for a time.
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
        // The last row that contradicted the row before it, and how many in succession did.
        let (mut last, mut across) = (rows.start, 0);
        for i in near.positions(rows.start + 1..rows.end.max(rows.start + 1)) {
            let before = yes.get(i - 1);
            if !known.get(i - 1) || yes.get(i) == before {
                across = 0;
                continue;
            }
            across = if last + 1 == i { across + 1 } else { 1 };
            last = i;
            if across == ROWS_ACROSS {
                across = 0;
            } else if before {
                yes.set_range(i..i + 1);
            } else {
                yes.clear_range(i..i + 1);
            }
        }
    }
    Truth { yes: yes.into(), known }
}
