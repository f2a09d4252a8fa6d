//! Where the rows of a pair of objects are.

use whyroad_model::pair::{PairSpan, PairTable};
use whyroad_model::signal::TargetSpan;
use whyroad_model::{FrameRange, SignalTable};

/// The pair table and the span of these two, in this order; `None` where the drive has no pairs, or not this one.
pub(crate) fn span<'t>(
    table: &'t SignalTable,
    first: &TargetSpan,
    second: &TargetSpan,
) -> Option<(&'t PairTable, &'t PairSpan)> {
    let pairs = table.pairs.as_ref()?;
    let index = |of: &TargetSpan| table.targets.iter().position(|t| t.id == of.id);
    Some((pairs, &pairs.spans[pairs.find(index(first)?, index(second)?)?]))
}

/// Frames of a pair: those in which both are observed; where the drive has a table of pairs, from the first to the last
/// in which they are near.
pub(super) fn frames(table: &SignalTable, first: &TargetSpan, second: &TargetSpan) -> FrameRange {
    match (&table.pairs, span(table, first, second)) {
        (_, Some((_, span))) => span.frames,
        (Some(_), None) => FrameRange::default(),
        (None, None) => first.frames.intersect(second.frames),
    }
}
