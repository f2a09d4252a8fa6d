//! States of one object, with standard deviations, from its measurements: a fixed-interval smoother with the motion
//! model of its class, with standstills detected and held, and rows without a measurement bridged. A quantity that the
//! log states exactly is kept, except the heading of a stationary vehicle in a log with noisy positions: it is the mean
//! of the standstill, as its position is.

use super::bicycle::{ACCEL, Bicycle, HEADING, SPEED, X, Y, YAW_RATE};
use super::kalman::{Filter, Observation, Smoothed};
use super::matrix::diagonal;
use super::noise::{LogNoise, Rows};
use super::standing::{GREATEST_SPEED_MPS, mean, stands, stays};
use super::walker::{TURN, WALKER};
use crate::geometry::{unwrap, wrap};
use crate::series::slope;
use std::ops::Range;

/// Motion model of an object, by its class.
#[derive(Clone, Copy, Debug)]
pub enum MotionModel {
    /// Vehicles: along their heading.
    Bicycle(Bicycle),
    /// People, two-wheelers pushed or ridden slowly, small objects: any direction, at constant velocity.
    ConstantVelocity,
}

/// Standard deviations, one per row; zero is exact, NaN unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deviations {
    /// Of a coordinate, m.
    pub position: Vec<f64>,
    /// rad.
    pub heading: Vec<f64>,
    /// m/s.
    pub speed: Vec<f64>,
    /// m/s2.
    pub accel: Vec<f64>,
    /// rad/s.
    pub yaw_rate: Vec<f64>,
}

impl Deviations {
    /// `n` rows without any deviation.
    pub fn exact(n: usize) -> Self {
        let v = || vec![0.0; n];
        Self { position: v(), heading: v(), speed: v(), accel: v(), yaw_rate: v() }
    }
}

/// Accuracy of lateral motion in a row, standard deviations; zero is exact.
#[derive(Clone, Copy, Debug, Default)]
pub struct Aside {
    /// Of a coordinate, m.
    pub place_m: f64,
    /// Of the speed across the direction of motion, m/s.
    pub speed_mps: f64,
}

impl Aside {
    /// In `row`, for an object that moves at `speed` m/s along its heading.
    pub fn new(sd: &Deviations, row: usize, speed: f64) -> Self {
        let across = stated(speed) * stated(sd.heading[row]);
        Self { place_m: stated(sd.position[row]), speed_mps: across }
    }
}

/// The deviation, or zero if it is unknown.
pub fn stated(deviation: f64) -> f64 {
    if deviation.is_finite() { deviation } else { 0.0 }
}

/// Estimated states, one per row.
#[derive(Clone, Debug, Default)]
pub struct States {
    /// m.
    pub x: Vec<f64>,
    /// m.
    pub y: Vec<f64>,
    /// rad, (-pi, pi].
    pub heading: Vec<f64>,
    /// m/s.
    pub vx: Vec<f64>,
    /// m/s.
    pub vy: Vec<f64>,
    /// m/s2 along the heading.
    pub accel: Vec<f64>,
    /// rad/s.
    pub yaw_rate: Vec<f64>,
    /// Their standard deviations.
    pub sd: Deviations,
}

/// Minimum standard deviation of a heading as the direction of motion, rad: boxes and paths differ.
const LEAST_HEADING_SD_RAD: f64 = 0.035;
/// Headings of a stationary vehicle differ by less than this from their mean, rad; a corrected one by more.
const JITTER_RAD: f64 = 0.1;
/// Reach of the slopes where a quantity is exact, s.
const SLOPE_REACH_S: f64 = 0.2;
/// Standard deviation of the speed at standstill, m/s.
const STANDING_SD_MPS: f64 = 0.03;

/// Smooths consecutive rows without a long gap; rows without a position are bridged.
pub fn smooth(rows: Rows<'_>, model: MotionModel, noise: &LogNoise) -> States {
    let n = rows.times.len();
    let measured = (0..n).filter(|&i| rows.x[i].is_finite()).count();
    if measured == 0 {
        return States::unknown(n);
    }
    let lasts = rows.times[n - 1] - rows.times[0];
    let step = if measured > 1 { (lasts / (measured - 1) as f64).max(0.02) } else { 0.1 };
    let variances = Variances {
        position: noise.position.variance(step),
        heading: noise.heading.variance(step),
        velocity: noise.velocity.variance(step),
    };
    let known_headings = rows.heading.iter().filter(|h| h.is_finite()).count();
    let bicycle = match model {
        MotionModel::Bicycle(bicycle) if 2 * known_headings > measured => Some(bicycle),
        _ => None,
    };
    let (mut out, stands) = if stands_all_along(rows, noise, &variances) {
        (standing(rows, &variances, measured), std::iter::once(0..n).collect())
    } else {
        let moving = Variances {
            position: noise.position.variance_in_maneuvers(step),
            heading: noise.heading.variance_in_maneuvers(step),
            velocity: noise.velocity.variance_in_maneuvers(step),
        };
        match bicycle {
            Some(bicycle) => as_vehicle(rows, bicycle, &moving, variances.position),
            None => (as_walker(rows, &moving, variances.position), Vec::new()),
        }
    };
    let deviations = out.sd.heading.clone();
    keep_exact(rows, noise, &mut out);
    // People turn on the spot, vehicles do not; estimated headings do not jitter, measured ones do.
    if bicycle.is_some() && noise.heading.is_negligible() && !noise.position.is_negligible() {
        stands.into_iter().for_each(|stand| out.hold_heading(stand, &deviations));
    }
    out
}

/// Variances of single measurements.
#[derive(Clone, Copy)]
struct Variances {
    position: f64,
    heading: f64,
    velocity: f64,
}

fn at(values: &[f64], row: usize) -> f64 {
    values.get(row).copied().unwrap_or(f64::NAN)
}

/// True when no row shows that the object moved.
fn stands_all_along(rows: Rows<'_>, noise: &LogNoise, variances: &Variances) -> bool {
    let n = rows.times.len();
    if n < 5 || rows.times[n - 1] - rows.times[0] < 0.4 {
        return false;
    }
    let all = 0..n;
    let parts = [all.clone(), 0..2 * n / 3, n / 3..n];
    if parts.iter().any(|p| !stays(rows.times, rows.x, rows.y, variances.position, p.clone())) {
        return false;
    }
    let Some((mx, my)) = mean(rows.x, rows.y, all.clone()) else { return false };
    let known = || all.clone().filter(|&i| rows.x[i].is_finite() && rows.y[i].is_finite());
    let count = known().count() as f64;
    let spread = known().map(|i| (rows.x[i] - mx).powi(2) + (rows.y[i] - my).powi(2)).sum::<f64>() / count;
    if spread.sqrt() > 2.0 * noise.position.deviation() * 2f64.sqrt() + 0.05 {
        return false;
    }
    let (mut sum, mut speeds) = ((0.0, 0.0), 0.0);
    for i in all {
        if let Some((vx, vy)) = rows.velocity(i) {
            sum = (sum.0 + vx, sum.1 + vy);
            speeds += 1.0;
        }
    }
    speeds == 0.0 || f64::hypot(sum.0, sum.1) / speeds <= 0.1 + 3.0 * (variances.velocity / speeds).sqrt()
}

/// Mean of the known headings, rad; NaN if there is none. That of equal ones has their bits.
fn mean_direction(headings: &[f64]) -> f64 {
    if let [first, others @ ..] = headings
        && others.iter().all(|h| h == first)
    {
        return *first;
    }
    let known = headings.iter().filter(|h| h.is_finite());
    let (sin, cos) = known.fold((0.0, 0.0), |(s, c), h| (s + h.sin(), c + h.cos()));
    if (sin, cos) == (0.0, 0.0) { f64::NAN } else { sin.atan2(cos) }
}

fn standing(rows: Rows<'_>, variances: &Variances, measured: usize) -> States {
    let n = rows.times.len();
    let (x, y) = mean(rows.x, rows.y, 0..n).unwrap_or((f64::NAN, f64::NAN));
    let heading = mean_direction(rows.heading);
    let of_mean = |v: f64| vec![(v / measured as f64).sqrt(); n];
    let same = |v: f64| vec![v; n];
    States {
        x: same(x),
        y: same(y),
        heading: same(heading),
        vx: same(0.0),
        vy: same(0.0),
        accel: same(0.0),
        yaw_rate: same(0.0),
        sd: Deviations {
            position: of_mean(variances.position),
            heading: of_mean(variances.heading),
            speed: same(STANDING_SD_MPS),
            accel: same(STANDING_SD_MPS),
            yaw_rate: same(0.005),
        },
    }
}

/// Velocity over about the first second, by a line through the measurements; zero if there is only one row.
fn first_velocity(rows: Rows<'_>) -> (f64, f64) {
    let known: Vec<usize> = (0..rows.times.len()).filter(|&i| rows.x[i].is_finite()).take(10).collect();
    let (Some(&a), Some(&b)) = (known.first(), known.last()) else { return (0.0, 0.0) };
    if let Some(velocity) = rows.velocity(a) {
        return velocity;
    }
    let mean_time = known.iter().map(|&i| rows.times[i]).sum::<f64>() / known.len() as f64;
    let spread: f64 = known.iter().map(|&i| (rows.times[i] - mean_time).powi(2)).sum();
    if a == b || spread <= 0.0 {
        return (0.0, 0.0);
    }
    let line = |v: &[f64]| known.iter().map(|&i| (rows.times[i] - mean_time) * v[i]).sum::<f64>() / spread;
    (line(rows.x), line(rows.y))
}

/// The states, and the rows in which the vehicle is stationary. `of_mean` is the variance of a coordinate where
/// positions are averaged.
fn as_vehicle(
    rows: Rows<'_>,
    model: Bicycle,
    variances: &Variances,
    of_mean: f64,
) -> (States, Vec<Range<usize>>) {
    let n = rows.times.len();
    let start = (0..n).find(|&i| rows.x[i].is_finite()).unwrap_or(0);
    let heading = rows.heading.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    let (vx, vy) = first_velocity(rows);
    let speed = vx * heading.cos() + vy * heading.sin();
    let direction = variances.heading.max(LEAST_HEADING_SD_RAD.powi(2));
    let first = (
        [rows.x[start], rows.y[start], heading, speed, 0.0, 0.0],
        diagonal([25.0, 25.0, 0.5, 25.0, 0.1, 4.0]),
    );
    let see = |held: &[Range<usize>], row: usize, seen: &mut Vec<Observation>| {
        let mut see = |index, value: f64, variance| {
            if value.is_finite() {
                seen.push(Observation { index, value, variance });
            }
        };
        see(X, rows.x[row], variances.position);
        see(Y, rows.y[row], variances.position);
        see(HEADING, rows.heading[row], direction);
        see(SPEED, rows.forward_speed(row), variances.velocity);
        if held.iter().any(|r| r.contains(&row)) {
            see(SPEED, 0.0, 1e-4);
            see(YAW_RATE, 0.0, 1e-5);
            see(ACCEL, 0.0, 1e-2);
        }
    };
    let mut filter = Filter::new(&model, rows.times, first, |row, seen| see(&[], row, seen));
    let column = |s: &Smoothed<6>, k: usize| s.states.iter().map(|v| v[k]).collect::<Vec<_>>();
    let deviation = |s: &Smoothed<6>, k: usize| s.variances.iter().map(|v| v[k].sqrt()).collect::<Vec<_>>();
    // Where it seems to stand, it will be filtered once more: only its speed is needed before that.
    let is_slow = |state: &[f64; 6]| state[SPEED].abs() < GREATEST_SPEED_MPS;
    let mut smoothed = if filter.filtered().any(is_slow) { None } else { Some(filter.smoothed()) };
    let (speed, sd) = match &smoothed {
        Some(all) => (column(all, SPEED), deviation(all, SPEED)),
        None => {
            let (speed, variance) = filter.smoothed_component(SPEED);
            (speed, variance.into_iter().map(f64::sqrt).collect())
        }
    };
    let stands = stands(rows.times, &speed, &sd, rows.x, rows.y, of_mean);
    let held: Vec<Range<usize>> = stands.iter().map(|r| within(r, n)).collect();
    if let Some(first) = held.first() {
        filter.filter_from(first.start, |row, seen| see(&held, row, seen));
        smoothed = None;
    }
    let smoothed = smoothed.unwrap_or_else(|| filter.smoothed());
    let mut out = States {
        x: column(&smoothed, X),
        y: column(&smoothed, Y),
        heading: column(&smoothed, HEADING).into_iter().map(wrap).collect(),
        vx: Vec::with_capacity(n),
        vy: Vec::with_capacity(n),
        accel: column(&smoothed, ACCEL),
        yaw_rate: column(&smoothed, YAW_RATE),
        sd: Deviations {
            position: smoothed.variances.iter().map(|v| (0.5 * (v[X] + v[Y])).sqrt()).collect(),
            heading: deviation(&smoothed, HEADING),
            speed: deviation(&smoothed, SPEED),
            accel: deviation(&smoothed, ACCEL),
            yaw_rate: deviation(&smoothed, YAW_RATE),
        },
    };
    for s in &smoothed.states {
        let (sin, cos) = s[HEADING].sin_cos();
        let aside = model.rear_to_center_m * s[YAW_RATE];
        out.vx.push(s[SPEED] * cos - aside * sin);
        out.vy.push(s[SPEED] * sin + aside * cos);
    }
    held.iter().for_each(|stand| out.hold(stand.clone()));
    (out, held)
}

/// A standstill without its first and last row, which may belong to the motion around it.
fn within(stand: &Range<usize>, n: usize) -> Range<usize> {
    let start = if stand.start == 0 { 0 } else { stand.start + 1 };
    start..if stand.end == n { n } else { (stand.end - 1).max(start) }
}

fn as_walker(rows: Rows<'_>, variances: &Variances, of_mean: f64) -> States {
    let n = rows.times.len();
    let velocity = first_velocity(rows);
    let unknown = (f64::NAN, f64::NAN);
    let (vx, vy): (Vec<f64>, Vec<f64>) = (0..n).map(|i| rows.velocity(i).unwrap_or(unknown)).unzip();
    let see =
        |place: &[f64], rate: &[f64], held: &[Range<usize>], row: usize, seen: &mut Vec<Observation>| {
            let mut see = |index, value: f64, variance| {
                if value.is_finite() {
                    seen.push(Observation { index, value, variance });
                }
            };
            see(0, place[row], variances.position);
            see(1, at(rate, row), variances.velocity);
            if held.iter().any(|r| r.contains(&row)) {
                see(1, 0.0, 1e-4);
            }
        };
    let axis = |place: &[f64], rate: &[f64], v0: f64| {
        let p0 = place.iter().copied().find(|p| p.is_finite()).unwrap_or(0.0);
        let first = ([p0, v0], diagonal([25.0, 9.0]));
        Filter::new(&WALKER, rows.times, first, |row, seen| see(place, rate, &[], row, seen))
    };
    let (mut along_x, mut along_y) = (axis(rows.x, &vx, velocity.0), axis(rows.y, &vy, velocity.1));
    let (mut sx, mut sy) = (along_x.smoothed(), along_y.smoothed());
    let speed: Vec<f64> = (0..n).map(|i| sx.states[i][1].hypot(sy.states[i][1])).collect();
    let speed_sd: Vec<f64> = sx.variances.iter().map(|v| v[1].sqrt()).collect();
    let stands = stands(rows.times, &speed, &speed_sd, rows.x, rows.y, of_mean);
    let held: Vec<Range<usize>> = stands.iter().map(|r| within(r, n)).collect();
    if let Some(first) = held.first() {
        along_x.filter_from(first.start, |row, seen| see(rows.x, &vx, &held, row, seen));
        along_y.filter_from(first.start, |row, seen| see(rows.y, &vy, &held, row, seen));
        (sx, sy) = (along_x.smoothed(), along_y.smoothed());
    }
    let (heading, yaw_rate, heading_sd, yaw_rate_sd) = turning(rows, variances);
    let vx: Vec<f64> = sx.states.iter().map(|s| s[1]).collect();
    let vy: Vec<f64> = sy.states.iter().map(|s| s[1]).collect();
    let forward: Vec<f64> = (0..n).map(|i| vx[i] * heading[i].cos() + vy[i] * heading[i].sin()).collect();
    let speed_sd: Vec<f64> = sx.variances.iter().map(|v| v[1].sqrt()).collect();
    let mut out = States {
        x: sx.states.iter().map(|s| s[0]).collect(),
        y: sy.states.iter().map(|s| s[0]).collect(),
        accel: slope(rows.times, &forward, SLOPE_REACH_S),
        heading,
        vx,
        vy,
        yaw_rate,
        sd: Deviations {
            position: sx.variances.iter().map(|v| v[0].sqrt()).collect(),
            heading: heading_sd,
            accel: speed_sd.iter().map(|s| 2.0 * s).collect(),
            speed: speed_sd,
            yaw_rate: yaw_rate_sd,
        },
    };
    held.into_iter().for_each(|stand| out.hold(stand));
    out
}

/// Heading and yaw rate with their deviations; unknown where no heading was measured.
fn turning(rows: Rows<'_>, variances: &Variances) -> (Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>) {
    let n = rows.times.len();
    let Some(h0) = rows.heading.iter().copied().find(|h| h.is_finite()) else {
        let nan = || vec![f64::NAN; n];
        return (nan(), nan(), nan(), nan());
    };
    let steady = unwrap(rows.heading);
    let s = Filter::new(&TURN, rows.times, ([h0, 0.0], diagonal([1.0, 0.5])), |row, seen| {
        if steady[row].is_finite() {
            seen.push(Observation { index: 0, value: steady[row], variance: variances.heading });
        }
    });
    let s = s.smoothed();
    (
        s.states.iter().map(|v| wrap(v[0])).collect(),
        s.states.iter().map(|v| v[1]).collect(),
        s.variances.iter().map(|v| v[0].sqrt()).collect(),
        s.variances.iter().map(|v| v[1].sqrt()).collect(),
    )
}

/// Exactly stated values are kept, and values that depend only on them are computed from them exactly.
fn keep_exact(rows: Rows<'_>, noise: &LogNoise, out: &mut States) {
    let n = rows.times.len();
    if noise.position.is_negligible() {
        for i in (0..n).filter(|&i| rows.x[i].is_finite() && rows.y[i].is_finite()) {
            (out.x[i], out.y[i], out.sd.position[i]) = (rows.x[i], rows.y[i], 0.0);
        }
    }
    if noise.heading.is_negligible() {
        for i in (0..n).filter(|&i| rows.heading[i].is_finite()) {
            (out.heading[i], out.sd.heading[i]) = (rows.heading[i], 0.0);
        }
        if rows.heading.iter().all(|h| h.is_finite()) {
            out.yaw_rate = slope(rows.times, &unwrap(rows.heading), SLOPE_REACH_S);
            out.sd.yaw_rate = vec![0.0; n];
        }
    }
    let known = (0..n).filter(|&i| rows.velocity(i).is_some()).count();
    if noise.velocity.is_negligible() && known > 0 {
        for i in 0..n {
            let forward = at(rows.forward, i);
            if at(rows.vx, i).is_finite() && at(rows.vy, i).is_finite() {
                (out.vx[i], out.vy[i]) = (rows.vx[i], rows.vy[i]);
            } else if forward.is_finite() && out.heading[i].is_finite() {
                // The positions show the lateral part.
                let (sin, cos) = out.heading[i].sin_cos();
                let aside = out.vy[i] * cos - out.vx[i] * sin;
                (out.vx[i], out.vy[i]) = (forward * cos - aside * sin, forward * sin + aside * cos);
            } else {
                continue;
            }
            out.sd.speed[i] = 0.0;
        }
        if known == n {
            let forward = |i: usize| out.vx[i] * out.heading[i].cos() + out.vy[i] * out.heading[i].sin();
            let forward: Vec<f64> = (0..n).map(forward).collect();
            out.accel = slope(rows.times, &forward, SLOPE_REACH_S);
            out.sd.accel = vec![0.0; n];
        }
    }
}

impl Rows<'_> {
    /// Stated speed along the heading, m/s; NaN if none is stated.
    fn forward_speed(&self, row: usize) -> f64 {
        let (vx, vy, h) = (at(self.vx, row), at(self.vy, row), self.heading[row]);
        // Most logs state no velocity; then the direction is not computed.
        let along = if vx.is_nan() || vy.is_nan() { f64::NAN } else { vx * h.cos() + vy * h.sin() };
        if along.is_finite() { along } else { at(self.forward, row) }
    }

    /// Stated velocity, m/s.
    fn velocity(&self, row: usize) -> Option<(f64, f64)> {
        let (vx, vy) = (at(self.vx, row), at(self.vy, row));
        if vx.is_finite() && vy.is_finite() {
            return Some((vx, vy));
        }
        let (forward, h) = (at(self.forward, row), self.heading[row]);
        (forward.is_finite() && h.is_finite()).then(|| (forward * h.cos(), forward * h.sin()))
    }
}

impl States {
    fn unknown(n: usize) -> Self {
        let v = || vec![f64::NAN; n];
        Self {
            x: v(),
            y: v(),
            heading: v(),
            vx: v(),
            vy: v(),
            accel: v(),
            yaw_rate: v(),
            sd: Deviations { position: v(), heading: v(), speed: v(), accel: v(), yaw_rate: v() },
        }
    }

    /// Sets these rows to standstill.
    fn hold(&mut self, rows: Range<usize>) {
        let Some((x, y)) = mean(&self.x, &self.y, rows.clone()) else { return };
        for i in rows {
            (self.x[i], self.y[i]) = (x, y);
            (self.vx[i], self.vy[i], self.accel[i], self.yaw_rate[i]) = (0.0, 0.0, 0.0, 0.0);
            (self.sd.speed[i], self.sd.accel[i]) = (STANDING_SD_MPS, STANDING_SD_MPS);
        }
    }

    /// Sets the heading of a vehicle in the rows of a standstill to their mean: what it turns there is jitter, unless
    /// it turns too much for that. `deviations` are those of the estimated headings.
    fn hold_heading(&mut self, stand: Range<usize>, deviations: &[f64]) {
        let headings = &mut self.heading[stand.clone()];
        let mean = mean_direction(headings);
        if mean.is_finite() && headings.iter().all(|h| wrap(h - mean).abs() < JITTER_RAD) {
            headings.fill(mean);
            self.yaw_rate[stand.clone()].fill(0.0);
            self.sd.heading[stand.clone()].copy_from_slice(&deviations[stand]);
        }
    }
}

#[cfg(test)]
mod tests;
