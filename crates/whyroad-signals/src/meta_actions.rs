//! Meta actions of the ego on every frame (LABELING.md 5, after AR1 table 5). The names are theirs, the
//! thresholds ours: AR1 does not print any.

use crate::ego_motion::EgoMotion;
use crate::series::{absorb_short_runs, smooth};
use crate::table::TableBuilder;
use whyroad_model::Tri;

/// Below this |acceleration| the speed is maintained, m/s2.
const MAINTAIN_MPS2: f64 = 0.4;
/// From this |acceleration| on it is strong, m/s2.
const STRONG_MPS2: f64 = 2.0;
/// Forward speed below which the ego reverses, m/s.
const REVERSE_MPS: f64 = -0.3;
/// Below this |yaw rate| the ego goes straight: 2 deg/s.
const STRAIGHT_RADPS: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// From this |yaw rate| on it steers sharply: 15 deg/s.
const SHARP_RADPS: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Half width of the mean over acceleration and yaw rate, s.
const MEAN_REACH_S: f64 = 0.3;
/// Runs shorter than this join the one before, s.
const LEAST_RUN_S: f64 = 0.5;

// Indices into the catalogue's values of ego.meta_longitudinal and ego.meta_lateral; a test holds them to the names.
const STOP: u16 = 0;
const REVERSE: u16 = 1;
const STRONG_DECELERATE: u16 = 2;
const GENTLE_DECELERATE: u16 = 3;
const MAINTAIN: u16 = 4;
const GENTLE_ACCELERATE: u16 = 5;
const STRONG_ACCELERATE: u16 = 6;

const GO_STRAIGHT: u16 = 0;
const STEER_LEFT: u16 = 1;
const STEER_RIGHT: u16 = 2;
const SHARP_LEFT: u16 = 3;
const SHARP_RIGHT: u16 = 4;
const REVERSE_LEFT: u16 = 5;
const REVERSE_RIGHT: u16 = 6;

fn longitudinal(standstill: Tri, forward_speed: f64, accel: f64) -> Option<u16> {
    if standstill.known()? {
        return Some(STOP);
    }
    if forward_speed < REVERSE_MPS {
        return Some(REVERSE);
    }
    Some(match accel {
        a if a.is_nan() => return None,
        a if a <= -STRONG_MPS2 => STRONG_DECELERATE,
        a if a <= -MAINTAIN_MPS2 => GENTLE_DECELERATE,
        a if a < MAINTAIN_MPS2 => MAINTAIN,
        a if a < STRONG_MPS2 => GENTLE_ACCELERATE,
        _ => STRONG_ACCELERATE,
    })
}

fn lateral(standstill: Tri, forward_speed: f64, yaw_rate: f64) -> Option<u16> {
    if standstill.known()? {
        return Some(GO_STRAIGHT);
    }
    if yaw_rate.is_nan() {
        return None;
    }
    if yaw_rate.abs() < STRAIGHT_RADPS {
        return Some(GO_STRAIGHT);
    }
    if forward_speed < REVERSE_MPS {
        // Backing with a clockwise turn moves the tail to the ego's left.
        return Some(if yaw_rate < 0.0 { REVERSE_LEFT } else { REVERSE_RIGHT });
    }
    Some(match (yaw_rate > 0.0, yaw_rate.abs() >= SHARP_RADPS) {
        (true, false) => STEER_LEFT,
        (false, false) => STEER_RIGHT,
        (true, true) => SHARP_LEFT,
        (false, true) => SHARP_RIGHT,
    })
}

/// Writes `ego.meta_longitudinal` and `ego.meta_lateral`.
pub fn write(ego: &EgoMotion, times: &[f64], table: &mut TableBuilder<'_>) {
    let accel = smooth(times, &ego.accel, MEAN_REACH_S);
    let yaw_rate = smooth(times, &ego.yaw_rate, MEAN_REACH_S);
    let frames = 0..ego.len();
    let mut along: Vec<Option<u16>> =
        frames.clone().map(|i| longitudinal(ego.standstill[i], ego.forward_speed[i], accel[i])).collect();
    let mut across: Vec<Option<u16>> =
        frames.map(|i| lateral(ego.standstill[i], ego.forward_speed[i], yaw_rate[i])).collect();
    absorb_short_runs(times, &mut along, LEAST_RUN_S);
    absorb_short_runs(times, &mut across, LEAST_RUN_S);
    table.category("ego.meta_longitudinal", along);
    table.category("ego.meta_lateral", across);
}
