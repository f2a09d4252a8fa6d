//! From times, as messages have them, to frames, as scene and signal tables have them.

use whyroad_model::Nanos;

/// The frame nearest to `time`; one past the last frame for a time after it, as ends of ranges are.
pub(crate) fn frame_at(times: &[Nanos], time: Nanos) -> usize {
    let after = times.partition_point(|t| *t < time);
    let Some(before) = after.checked_sub(1) else { return 0 };
    match times.get(after) {
        Some(t) if (t.0 - time.0) < (time.0 - times[before].0) => after,
        Some(_) => before,
        // The end of the last frame's range is one past it.
        None => {
            if time > times[before] {
                after
            } else {
                before
            }
        }
    }
}
