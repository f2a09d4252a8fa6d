//! Samples at the log's own times to values at frame times. A gap in the samples stays a gap.

/// Samples further apart than this are not of one motion, s.
pub const MAX_GAP_S: f64 = 0.25;

/// Linear between the two samples around each frame, unknown outside the samples and where they are further apart
/// than `max_gap_s`. `times` ascend; so do `frames`.
pub fn linear(times: &[f64], values: &[f64], frames: &[f64], max_gap_s: f64) -> Vec<f64> {
    frames
        .iter()
        .map(|&t| {
            let next = times.partition_point(|&s| s < t);
            if times.get(next) == Some(&t) {
                return values[next];
            }
            let (Some(before), true) = (next.checked_sub(1), next < times.len()) else { return f64::NAN };
            let gap = times[next] - times[before];
            if gap > max_gap_s {
                return f64::NAN;
            }
            values[before] + (values[next] - values[before]) * (t - times[before]) / gap
        })
        .collect()
}

/// The index of the last sample at or before each frame, while it is not older than `max_age_s`: for states, which
/// hold until the next message says otherwise.
pub fn latest(times: &[f64], frames: &[f64], max_age_s: f64) -> Vec<Option<usize>> {
    frames
        .iter()
        .map(|&t| {
            let last = times.partition_point(|&s| s <= t).checked_sub(1)?;
            (t - times[last] <= max_age_s).then_some(last)
        })
        .collect()
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
    fn a_state_holds_until_it_is_too_old() {
        assert_eq!(
            latest(&[1.0, 2.0], &[0.9, 1.0, 1.9, 2.5, 4.0], 1.0),
            [None, Some(0), Some(0), Some(1), None]
        );
    }
}
