//! Series over real timestamps: slopes, means, hysteresis, removal of short runs. Gaps are kept: no window extends over
//! a pause in the recording.

use whyroad_model::{Drive, Tri};

/// Maximum time between two neighboring samples: 2.5 nominal frames.
pub const GAP_S: f64 = 0.25;

/// Rows `[first, last]` around `row` within `reach` seconds, not across gaps or unknown values.
fn window(times: &[f64], values: &[f64], row: usize, reach: f64) -> (usize, usize) {
    // A tolerance: 10 Hz logs have jitter (0.100196 s), and the second neighbor still belongs to 0.2 s.
    let reach = reach + 0.02;
    let joined =
        |a: usize, b: usize| times[b] - times[a] <= GAP_S && !values[a].is_nan() && !values[b].is_nan();
    let (mut first, mut last) = (row, row);
    while first > 0 && times[row] - times[first - 1] <= reach && joined(first - 1, first) {
        first -= 1;
    }
    while last + 1 < times.len() && times[last + 1] - times[row] <= reach && joined(last, last + 1) {
        last += 1;
    }
    (first, last)
}

/// Least-squares slope of `values` over `times` (s) within `reach` seconds of each row; NaN where fewer than two
/// values are known there. Near an end the window is one-sided.
pub fn slope(times: &[f64], values: &[f64], reach: f64) -> Vec<f64> {
    (0..times.len())
        .map(|row| {
            if values[row].is_nan() {
                return f64::NAN;
            }
            let (first, last) = window(times, values, row, reach);
            let n = (last - first + 1) as f64;
            if n < 2.0 {
                return f64::NAN;
            }
            let mean_t = times[first..=last].iter().sum::<f64>() / n;
            let mean_v = values[first..=last].iter().sum::<f64>() / n;
            let (mut num, mut den) = (0.0, 0.0);
            for i in first..=last {
                num += (times[i] - mean_t) * (values[i] - mean_v);
                den += (times[i] - mean_t).powi(2);
            }
            num / den
        })
        .collect()
}

/// Mean of `values` within `reach` seconds of each row; NaN where the row itself is unknown.
pub fn smooth(times: &[f64], values: &[f64], reach: f64) -> Vec<f64> {
    (0..times.len())
        .map(|row| {
            if values[row].is_nan() {
                return f64::NAN;
            }
            let (first, last) = window(times, values, row, reach);
            values[first..=last].iter().sum::<f64>() / (last - first + 1) as f64
        })
        .collect()
}

/// True from below `set` until above `release` (`set < release`). Unknown values give unknown and reset the state; a
/// first value between the two counts as released.
pub fn below_with_hysteresis(values: &[f64], set: f64, release: f64) -> Vec<Tri> {
    let mut state = false;
    values
        .iter()
        .map(|&v| {
            if v.is_nan() {
                state = false;
                return Tri::Unknown;
            }
            state = if state { v <= release } else { v < set };
            Tri::from(state)
        })
        .collect()
}

/// Merges runs shorter than `least` seconds into the run before them (the first run into the one after). `None` rows
/// are borders and are kept. The last run before a border or the end may go on where nothing is known: it is merged
/// only with one that is `alike`.
pub fn absorb_short_runs<T: Copy + PartialEq>(
    times: &[f64],
    values: &mut [Option<T>],
    least: f64,
    alike: impl Fn(T, T) -> bool,
) {
    let n = values.len();
    let mut start = 0;
    while start < n {
        let mut end = start + 1;
        while end < n && values[end] == values[start] {
            end += 1;
        }
        // A run lasts until the next one starts; the last one until its own last frame.
        let until = times.get(end).copied().unwrap_or(times[n - 1]);
        if values[start].is_some() && until - times[start] < least - 1e-6 {
            let before = start.checked_sub(1).and_then(|i| values[i]);
            let after = values.get(end).copied().flatten();
            let differs = |before: T| values[start].is_some_and(|own| !alike(before, own));
            let is_cut_off = after.is_none() && before.is_some_and(differs);
            if let Some(fill) = before.or(after).filter(|_| !is_cut_off) {
                values[start..end].fill(Some(fill));
                // Merged forward, the run may have joined the next one: the joined run is checked.
                if before.is_none() {
                    continue;
                }
            }
        }
        start = end;
    }
}

/// Seconds since the first frame.
pub fn seconds(drive: &Drive) -> Vec<f64> {
    let start = drive.times.first().copied().unwrap_or_default();
    drive.times.iter().map(|t| t.seconds_since(start)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_divided_by_the_real_time() {
        // v = 3 t on jittered stamps (0.100196 s as in AV2): slope 3 everywhere.
        let times: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.100_196 + 0.001 * f64::from(i % 3)).collect();
        let values: Vec<f64> = times.iter().map(|t| 3.0 * t).collect();
        assert!(slope(&times, &values, 0.2).iter().all(|s| (s - 3.0).abs() < 1e-9));
    }

    #[test]
    fn no_slope_over_a_gap() {
        let times = [0.0, 0.1, 0.2, 3.2, 3.3];
        let values = [0.0, 0.0, 0.0, 90.0, 90.0];
        assert!(slope(&times, &values, 0.2).iter().all(|s| s.abs() < 1e-12));
        let lonely = slope(&[0.0, 5.0], &[1.0, 2.0], 0.2);
        assert!(lonely[0].is_nan() && lonely[1].is_nan());
    }

    #[test]
    fn standstill_holds_between_its_thresholds() {
        use Tri::{False, True, Unknown};
        let v = [0.4, 0.29, 0.4, 0.5, 0.51, 0.4, f64::NAN, 0.4];
        assert_eq!(
            below_with_hysteresis(&v, 0.3, 0.5),
            [False, True, True, True, False, False, Unknown, False]
        );
    }

    #[test]
    fn short_runs_join_their_neighbor() {
        let times: Vec<f64> = (0..12).map(|i| f64::from(i) * 0.1).collect();
        let mut v: Vec<Option<u8>> = [1, 1, 2, 2, 2, 2, 2, 2, 3, 2, 2, 2].map(Some).to_vec();
        absorb_short_runs(&times, &mut v, 0.3, |_, _| false);
        assert_eq!(v, vec![Some(2); 12]);
    }

    #[test]
    fn a_run_that_the_end_cuts_off_joins_only_one_that_is_alike() {
        let times: Vec<f64> = (0..9).map(|i| f64::from(i) * 0.1).collect();
        let runs = [Some(1), Some(1), Some(1), Some(9), None, Some(1), Some(1), Some(1), Some(3)];
        let alike = |a: i32, b: i32| (a - b).abs() <= 2;
        let mut v = runs;
        absorb_short_runs(&times, &mut v, 0.3, alike);
        assert_eq!(v, [Some(1), Some(1), Some(1), Some(9), None, Some(1), Some(1), Some(1), Some(1)]);
    }
}
