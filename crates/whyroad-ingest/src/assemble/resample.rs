//! Samples at the log's own times to values at frame times. A gap in the samples stays a gap.

use whyroad_model::Nanos;

/// Samples further apart than this do not belong to one motion, s.
pub const MAX_GAP_S: f64 = 0.25;

/// A sample this near to a frame belongs to that frame, s: sums of tenths are not exact.
const SAME_S: f64 = 1e-6;

/// Where a frame lies among the samples.
enum Among {
    /// At this one.
    At(usize),
    /// Between this one and the next.
    After(usize),
    Outside,
}

/// `times` ascend.
fn among(times: &[f64], t: f64) -> Among {
    let next = times.partition_point(|&s| s < t - SAME_S);
    match next.checked_sub(1) {
        _ if times.get(next).is_some_and(|s| (s - t).abs() <= SAME_S) => Among::At(next),
        Some(before) if next < times.len() => Among::After(before),
        _ => Among::Outside,
    }
}

/// Linear between the two samples around each frame, unknown outside the samples and where they are further apart
/// than `max_gap_s`. `times` ascend; so do `frames`.
pub fn linear(times: &[f64], values: &[f64], frames: &[f64], max_gap_s: f64) -> Vec<f64> {
    frames
        .iter()
        .map(|&t| match among(times, t) {
            Among::At(i) => values[i],
            Among::After(i) if times[i + 1] - times[i] <= max_gap_s => {
                values[i] + (values[i + 1] - values[i]) * (t - times[i]) / (times[i + 1] - times[i])
            }
            _ => f64::NAN,
        })
        .collect()
}

/// How much later than its frame the latest sample is from which [`linear`] makes each value; empty when none is later.
/// [`crate::assemble::finish`] converts it to times.
pub(crate) fn lags(times: &[f64], frames: &[f64]) -> Vec<Nanos> {
    let lag = |&t: &f64| match among(times, t) {
        Among::After(i) => Nanos(((times[i + 1] - t) * 1e9).round() as i64),
        _ => Nanos(0),
    };
    let lags: Vec<Nanos> = frames.iter().map(lag).collect();
    if lags.iter().any(|l| l.0 > 0) { lags } else { Vec::new() }
}

/// The index of the last sample at or before each frame, while it is not older than `max_age_s`: for states, which are
/// valid until the next message changes them.
pub fn latest(times: &[f64], frames: &[f64], max_age_s: f64) -> Vec<Option<usize>> {
    frames
        .iter()
        .map(|&t| {
            let last = times.partition_point(|&s| s <= t).checked_sub(1)?;
            (t - times[last] <= max_age_s).then_some(last)
        })
        .collect()
}

/// The sample of greatest magnitude since the previous frame, at most `frame_s` ago: for events shorter than a frame.
pub fn greatest(times: &[f64], values: &[f64], frames: &[f64], frame_s: f64) -> Vec<f64> {
    let within = |t: f64| {
        let from = times.partition_point(|s| *s <= t - frame_s + SAME_S);
        let to = times.partition_point(|s| *s <= t + SAME_S);
        let known = values[from..to.max(from)].iter().copied().filter(|v| v.is_finite());
        known.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
    };
    frames.iter().map(|&t| within(t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_samples_and_never_across_a_gap() {
        let v = linear(&[0.0, 0.1, 0.5], &[0.0, 1.0, 5.0], &[-0.1, 0.0, 0.05, 0.3, 0.5, 0.6], 0.25);
        assert!(v[0].is_nan() && v[3].is_nan() && v[5].is_nan());
        assert_eq!((v[1], v[2], v[4]), (0.0, 0.5, 5.0));
    }

    #[test]
    fn a_value_between_samples_is_known_with_the_later_one() {
        assert_eq!(
            lags(&[0.0, 0.1, 0.5], &[0.0, 0.05, 0.1, 0.3]),
            [0, 50_000_000, 0, 200_000_000].map(Nanos)
        );
        // 3 * 0.1 is not 0.3.
        assert!(lags(&[0.0, 0.3], &[0.0, 3.0 * 0.1]).is_empty());
    }

    #[test]
    fn what_is_shorter_than_a_frame_is_kept() {
        let (times, values) = ([0.0, 0.02, 0.04, 0.1, 0.3], [0.1, -5.0, 4.0, 0.2, f64::NAN]);
        let v = greatest(&times, &values, &[0.0, 0.1, 0.2, 0.3], 0.1);
        assert_eq!(v[..2], [0.1, -5.0]);
        assert!(v[2].is_nan() && v[3].is_nan(), "nothing was measured");
    }

    #[test]
    fn a_state_holds_until_it_is_too_old() {
        assert_eq!(
            latest(&[1.0, 2.0], &[0.9, 1.0, 1.9, 2.5, 4.0], 1.0),
            [None, Some(0), Some(0), Some(1), None]
        );
    }
}
