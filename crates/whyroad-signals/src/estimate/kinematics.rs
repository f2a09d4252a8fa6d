//! Motion from positions, for logs with positions and without velocities. Real timestamps, never across a gap.
//!
//! Velocity and yaw rate are the slope, at the frame itself, of a parabola fitted by least squares to the rows within
//! two frames on either side; acceleration is the curvature of one over three frames on either side (a local quadratic
//! regression, Savitzky and Golay 1964, for uneven spacing). So motion at constant velocity or constant acceleration is
//! exact, also at the first and last row (where the window is one-sided), there is no delay, and 1 cm of noise in the
//! positions leaves about 0.03 m/s and 0.2 m/s2. Independent of input formats.

use crate::geometry::{unwrap, wrap};
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Maximum time between rows of one motion, s.
pub const MAX_GAP_S: f64 = 0.25;
/// Rows either side of the frame in the fit for velocity and yaw rate.
const VELOCITY_REACH: usize = 2;
/// Rows either side of the frame in the fit for acceleration: wider, because noise grows with the second derivative.
const ACCELERATION_REACH: usize = 3;
/// A heading that changes by more than this between two rows was re-labeled (front and rear swapped), rad.
const MAX_HEADING_STEP_RAD: f64 = FRAC_PI_2;

/// Motion from positions; one value per row, NaN where a row has too few neighbors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derived {
    /// m/s along x.
    pub vx: Vec<f64>,
    /// m/s along y.
    pub vy: Vec<f64>,
    /// m/s2 along the heading.
    pub accel: Vec<f64>,
    /// rad/s, counter-clockwise.
    pub yaw_rate: Vec<f64>,
}

/// Motion of one object. `times_s` ascend, relative to any origin; `breaks(i)` is true if row `i` does not continue row
/// `i - 1` for a reason other than a gap in time (a jump of the source).
pub fn derive(
    times_s: &[f64],
    x: &[f64],
    y: &[f64],
    heading: &[f64],
    breaks: impl Fn(usize) -> bool,
) -> Derived {
    let n = times_s.len();
    let nan = || vec![f64::NAN; n];
    let mut out = Derived { vx: nan(), vy: nan(), accel: nan(), yaw_rate: nan() };
    let unknown = |i: usize| x[i].is_nan() || y[i].is_nan();
    for run in runs(times_s, |i| unknown(i) || unknown(i - 1) || breaks(i)) {
        for i in run.clone() {
            let near = window(&run, i, VELOCITY_REACH);
            out.vx[i] = fit(times_s, x, near.clone(), i).slope;
            out.vy[i] = fit(times_s, y, near, i).slope;
            let wide = window(&run, i, ACCELERATION_REACH);
            let (ax, ay) = (fit(times_s, x, wide.clone(), i).bend, fit(times_s, y, wide, i).bend);
            let (s, c) = heading[i].sin_cos();
            out.accel[i] = ax * c + ay * s;
        }
    }
    let turned = |i: usize| {
        let step = wrap(heading[i] - heading[i - 1]).abs();
        step.is_nan() || step > MAX_HEADING_STEP_RAD
    };
    for run in runs(times_s, |i| turned(i) || breaks(i)) {
        let steady = unwrap(&heading[run.clone()]);
        let local_times = &times_s[run.clone()];
        let whole = 0..steady.len();
        for i in whole.clone() {
            out.yaw_rate[run.start + i] =
                fit(local_times, &steady, window(&whole, i, VELOCITY_REACH), i).slope;
        }
    }
    out
}

/// Acceleration along the heading (m/s2) from velocities in the log: their slope over two frames either side.
pub fn acceleration(times_s: &[f64], vx: &[f64], vy: &[f64], heading: &[f64]) -> Vec<f64> {
    let slopes = derive(times_s, vx, vy, heading, |_| false);
    heading
        .iter()
        .enumerate()
        .map(|(i, h)| {
            let (s, c) = h.sin_cos();
            slopes.vx[i] * c + slopes.vy[i] * s
        })
        .collect()
}

/// Maximal ranges of rows that belong together: no gap in time, and no break.
fn runs(times_s: &[f64], breaks: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let n = times_s.len();
    let mut runs = Vec::new();
    let mut start = 0;
    for i in 1..=n {
        if i == n || times_s[i] - times_s[i - 1] > MAX_GAP_S || breaks(i) {
            runs.push(start..i);
            start = i;
        }
    }
    runs.retain(|r| !r.is_empty());
    runs
}

/// `2 * reach + 1` rows around `i`, shifted inwards at the run's ends so that the fit keeps its number of rows.
fn window(run: &Range<usize>, i: usize, reach: usize) -> Range<usize> {
    let size = (2 * reach + 1).min(run.len());
    let start = i.saturating_sub(reach).clamp(run.start, run.end - size);
    start..start + size
}

/// First and second derivative at the row.
struct Fit {
    slope: f64,
    bend: f64,
}

/// Least-squares parabola through the rows of `window`, differentiated at row `at`. Two rows give a line.
fn fit(t: &[f64], v: &[f64], window: Range<usize>, at: usize) -> Fit {
    let none = Fit { slope: f64::NAN, bend: f64::NAN };
    if window.len() < 2 {
        return none;
    }
    // Values are relative to the row itself: far from the origin of a city frame the sums would lose digits.
    let rows = window.clone().map(|k| (t[k] - t[at], v[k] - v[at]));
    if window.len() == 2 {
        let (a, b) = (window.start, window.start + 1);
        return Fit { slope: (v[b] - v[a]) / (t[b] - t[a]), bend: f64::NAN };
    }
    let (mut s0, mut s1, mut s2, mut s3, mut s4) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut r0, mut r1, mut r2) = (0.0, 0.0, 0.0);
    for (dt, dv) in rows {
        let dt2 = dt * dt;
        s0 += 1.0;
        s1 += dt;
        s2 += dt2;
        s3 += dt2 * dt;
        s4 += dt2 * dt2;
        r0 += dv;
        r1 += dv * dt;
        r2 += dv * dt2;
    }
    // Cramer's rule on the normal equations of v = a + b dt + c dt^2.
    let det = s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
    let b = s0 * (r1 * s4 - r2 * s3) - r0 * (s1 * s4 - s2 * s3) + s2 * (s1 * r2 - s2 * r1);
    let c = s0 * (s2 * r2 - s3 * r1) - s1 * (s1 * r2 - s2 * r1) + r0 * (s1 * s3 - s2 * s2);
    if det == 0.0 { none } else { Fit { slope: b / det, bend: 2.0 * c / det } }
}

#[cfg(test)]
mod tests;
