//! The ego's own motion: speed, acceleration, jerk, yaw rate, curvature, standstill. Frame: world for heading,
//! the ego's own axes for the rest (x forward, y left).

use crate::estimate::{Aside, Deviations, stated};
use crate::geometry::{OrientedBox, P2, p2, unwrap, wrap};
use crate::series::{below_with_hysteresis, slope};
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::id;
use whyroad_model::scene::Ego;

/// Half width of the window in which derivatives are fitted, s.
pub const DERIVATIVE_REACH_S: f64 = 0.2;
/// Standstill is set below this speed, m/s.
pub const STANDSTILL_SET_MPS: f64 = 0.3;
/// Standstill is released above this speed, m/s.
pub const STANDSTILL_RELEASE_MPS: f64 = 0.5;
/// Curvature is unknown below this speed, m/s.
const CURVATURE_LEAST_SPEED_MPS: f64 = 0.5;

/// The ego's motion by frame, each vector as long as the drive; NaN is unknown.
#[derive(Clone, Debug)]
pub struct EgoMotion {
    /// Box center, m, world.
    pub position: Vec<P2>,
    /// Height of the box center, m.
    pub z: Vec<f64>,
    /// rad, (-pi, pi].
    pub heading: Vec<f64>,
    /// Velocity over ground, m/s, world.
    pub velocity: Vec<P2>,
    /// m/s.
    pub speed: Vec<f64>,
    /// m/s along the heading.
    pub forward_speed: Vec<f64>,
    /// m/s2 along the heading.
    pub accel: Vec<f64>,
    /// rad/s.
    pub yaw_rate: Vec<f64>,
    /// Speed under 0.3 m/s, until above 0.5 m/s.
    pub standstill: Vec<Tri>,
    /// Box length, m.
    pub length: f64,
    /// Box width, m.
    pub width: f64,
    /// Standard deviations of the states; `None` where they are exact.
    pub sd: Option<Deviations>,
    footprints: Vec<OrientedBox>,
}

/// `given` if any of its values is known, else the slope of `values`.
pub(crate) fn given_or_slope(given: &[f64], times: &[f64], values: &[f64]) -> Vec<f64> {
    if given.iter().any(|v| !v.is_nan()) { given.to_vec() } else { slope(times, values, DERIVATIVE_REACH_S) }
}

/// Maximum speed and distance between two known positions, m/s and m. Derivation walks along the driven path in steps
/// of a meter or less: an outlier on another continent would make it walk there.
const LEAP_MPS: f64 = 150.0;
const LEAP_M: f64 = 500.0;
/// Maximum length of the driven path, m.
const LONGEST_PATH_M: f64 = 1_000_000.0;
/// Number of known positions after which a path is reliable; before that, a leap shows that the first ones were wrong.
const SETTLED: usize = 10;

/// The positions, unknown where they are a leap away from the previous ones, or beyond the longest path; the first few
/// are unknown where the next ones are a leap away.
fn without_leaps(mut positions: Vec<P2>, times: &[f64]) -> Vec<P2> {
    let unknown = p2(f64::NAN, f64::NAN);
    let (mut last, mut settled, mut length) = (None::<usize>, 0, 0.0);
    for i in 0..positions.len() {
        if !positions[i].is_finite() {
            continue;
        }
        let step = last.map_or(0.0, |l| (positions[i] - positions[l]).norm());
        let waited = last.map_or(0.0, |l| (times[i] - times[l]).abs());
        let leaps = step > LEAP_M + LEAP_MPS * waited;
        if (leaps && settled > SETTLED) || (!leaps && length + step > LONGEST_PATH_M) {
            positions[i] = unknown;
            continue;
        }
        if leaps {
            positions[..i].fill(unknown);
            (settled, length) = (0, 0.0);
        } else {
            length += step;
        }
        (last, settled) = (Some(i), settled + 1);
    }
    positions
}

impl EgoMotion {
    /// From the scene table; `times` in seconds.
    pub fn new(ego: &Ego, times: &[f64]) -> Self {
        let m = &ego.motion;
        let rows = 0..m.len();
        let speed: Vec<f64> = rows.clone().map(|i| m.speed(i)).collect();
        let forward: Vec<f64> = rows.clone().map(|i| m.forward_speed(i)).collect();
        let heading: Vec<f64> = m.heading.iter().map(|&h| if h.is_nan() { h } else { wrap(h) }).collect();
        let position = without_leaps(rows.clone().map(|i| p2(m.x[i], m.y[i])).collect(), times);
        let boxes =
            rows.clone().map(|i| OrientedBox::new(position[i], heading[i], ego.length_m, ego.width_m));
        Self {
            footprints: boxes.collect(),
            position,
            z: m.z.clone(),
            velocity: rows.map(|i| p2(m.vx[i], m.vy[i])).collect(),
            accel: given_or_slope(&m.accel, times, &forward),
            yaw_rate: given_or_slope(&m.yaw_rate, times, &unwrap(&heading)),
            standstill: below_with_hysteresis(&speed, STANDSTILL_SET_MPS, STANDSTILL_RELEASE_MPS),
            heading,
            speed,
            forward_speed: forward,
            length: ego.length_m,
            width: ego.width_m,
            sd: None,
        }
    }

    /// Standard deviation of a coordinate in `frame`, m; zero where it is exact.
    pub fn place_sd(&self, frame: usize) -> f64 {
        self.sd.as_ref().map_or(0.0, |sd| stated(sd.position[frame]))
    }

    /// Accuracy of its lateral motion, by frame; empty where it is exact.
    pub fn asides(&self) -> Vec<Aside> {
        let of = |sd: &Deviations| (0..self.len()).map(|i| Aside::new(sd, i, self.speed[i])).collect();
        self.sd.as_ref().map_or_else(Vec::new, of)
    }

    /// Distance from the box center to the front bumper, m; 0 where the length is unknown.
    pub fn front(&self) -> f64 {
        if self.length.is_finite() { self.length / 2.0 } else { 0.0 }
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// The footprint in `frame`.
    pub fn footprint(&self, frame: usize) -> OrientedBox {
        self.footprints[frame]
    }

    /// True when position and heading of `frame` are known.
    pub fn is_known(&self, frame: usize) -> bool {
        self.position[frame].is_finite() && self.heading[frame].is_finite()
    }
}

/// Writes the ego's kinematic signals.
pub fn write(ego: &EgoMotion, times: &[f64], table: &mut TableBuilder<'_>) {
    let frames = 0..ego.len();
    let curvature = |i: usize| {
        if ego.forward_speed[i].abs() < CURVATURE_LEAST_SPEED_MPS {
            f64::NAN
        } else {
            ego.yaw_rate[i] / ego.forward_speed[i]
        }
    };
    table.number(id::EGO_SPEED, ego.speed.clone());
    table.number(id::EGO_FORWARD_SPEED, ego.forward_speed.clone());
    table.number(id::EGO_ACCEL, ego.accel.clone());
    table.number(id::EGO_JERK, slope(times, &ego.accel, DERIVATIVE_REACH_S));
    table.number(id::EGO_YAW_RATE, ego.yaw_rate.clone());
    table.number(id::EGO_HEADING, ego.heading.clone());
    table.number(id::EGO_CURVATURE, frames.clone().map(curvature).collect());
    table.number(id::EGO_LATERAL_ACCEL, frames.map(|i| ego.forward_speed[i] * ego.yaw_rate[i]).collect());
    table.flag(id::EGO_STANDSTILL, ego.standstill.clone());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Which positions of a drive along x at 10 Hz remain known.
    fn known(x: &[f64]) -> Vec<bool> {
        let times: Vec<f64> = (0..x.len()).map(|i| i as f64 * 0.1).collect();
        let positions = x.iter().map(|x| p2(*x, 0.0)).collect();
        without_leaps(positions, &times).iter().map(|p| p.is_finite()).collect()
    }

    #[test]
    fn a_leap_is_unknown_and_what_follows_it_where_it_was_stays() {
        let mut x: Vec<f64> = (0..60).map(f64::from).collect();
        assert!(known(&x).iter().all(|k| *k), "10 m/s");
        x[30] = 1e9;
        assert_eq!(known(&x).iter().position(|k| !k), Some(30));
        assert_eq!(known(&x).iter().filter(|k| !**k).count(), 1);
        // It does not come back: nothing is invented there.
        x[30..].fill(1e9);
        assert_eq!(known(&x).iter().filter(|k| **k).count(), 30);
        // A receiver that reports the origin before it has a fix.
        let mut late: Vec<f64> = (0..60).map(|i| 4e6 + f64::from(i)).collect();
        late[..3].fill(0.0);
        assert_eq!(known(&late).iter().position(|k| *k), Some(3));
        // A minute without positions at 40 m/s is no leap.
        let mut gap: Vec<f64> = (0..700).map(|i| 4.0 * f64::from(i)).collect();
        gap[20..620].fill(f64::NAN);
        assert!(known(&gap)[620..].iter().all(|k| *k));
    }

    #[test]
    fn a_path_that_never_ends_is_cut() {
        let x: Vec<f64> = (0..10_000).map(|i| 500.0 * f64::from(i)).collect();
        assert_eq!(known(&x).iter().filter(|k| **k).count(), 2001, "1000 km in steps of 500 m");
    }
}
