//! Standstills of an object: its smoothed speed does not exceed its noise, and its measurements do not drift. With
//! exact positions hardly any moving object counts as stationary; with noisy ones no stationary object moves by noise
//! alone.

use std::ops::Range;

/// Minimum duration of a standstill, s.
const LEAST_S: f64 = 0.8;
/// Speed that counts as zero even in an exact log, m/s.
const LEAST_SPEED_MPS: f64 = 0.1;
/// Speed that never counts as zero, however noisy it is, m/s.
pub const GREATEST_SPEED_MPS: f64 = 0.7;
/// Standard deviations of the speed within which it counts as zero.
const DEVIATIONS: f64 = 2.5;
/// Maximum drift during a standstill beyond the noise, m/s.
const DRIFT_MPS: f64 = 0.05;

/// Ranges of rows in which the object is stationary. `speed` and `speed_sd` are smoothed, `x` and `y` measured (NaN is
/// unknown), `variance` is that of one measured coordinate, as white noise.
pub fn stands(
    times: &[f64],
    speed: &[f64],
    speed_sd: &[f64],
    x: &[f64],
    y: &[f64],
    variance: f64,
) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    for factor in [DEVIATIONS, DEVIATIONS / 2.0] {
        let slow =
            |i: usize| speed[i].abs() < (factor * speed_sd[i]).clamp(LEAST_SPEED_MPS, GREATEST_SPEED_MPS);
        let mut start = 0;
        while start < times.len() {
            let mut end = start;
            while end < times.len() && slow(end) {
                end += 1;
            }
            let range = start..end;
            start = end + 1;
            let overlaps = out.iter().any(|r: &Range<usize>| r.start < range.end && range.start < r.end);
            if range.len() >= 2
                && !overlaps
                && times[range.end - 1] - times[range.start] >= LEAST_S
                && stays(times, x, y, variance, range.clone())
            {
                out.push(range);
            }
        }
    }
    out.sort_by_key(|r| r.start);
    out
}

/// True when the mean position of the first third of the rows equals that of the last third, except for noise.
pub fn stays(times: &[f64], x: &[f64], y: &[f64], variance: f64, rows: Range<usize>) -> bool {
    let third = (rows.len() / 3).max(1);
    let (first, last) = (rows.start..rows.start + third, rows.end - third..rows.end);
    let (Some(a), Some(b)) = (mean(x, y, first.clone()), mean(x, y, last.clone())) else { return false };
    let spread = 2.0 * variance / third as f64;
    let apart = times[last.start] - times[first.start];
    (b.0 - a.0).hypot(b.1 - a.1) <= 3.0 * spread.sqrt() + DRIFT_MPS * apart
}

/// Mean of the known positions in these rows.
pub fn mean(x: &[f64], y: &[f64], rows: Range<usize>) -> Option<(f64, f64)> {
    let known = rows.filter(|&i| x[i].is_finite() && y[i].is_finite());
    let (sx, sy, n) = known.fold((0.0, 0.0, 0.0), |(sx, sy, n), i| (sx + x[i], sy + y[i], n + 1.0));
    (n > 0.0).then(|| (sx / n, sy / n))
}
