//! Deviation of the ego from its usual line, and abrupt steering.

use crate::behavior::ego_offset::unrolled;
use crate::ego::motion::DERIVATIVE_REACH_S;
use crate::estimate::stated;
use crate::road::own_shift::{OnWay, most_shifted};
use crate::series::slope;
use crate::table::TableBuilder;
use crate::target::interaction::Interaction;
use whyroad_model::Tri;
use whyroad_model::catalog::id;

/// The usual line is the median over this time, s.
const MEDIAN_OVER_S: f64 = 5.0;
/// ... with at least this much of it known, s.
const MEDIAN_LEAST_S: f64 = 1.0;
/// The ego's own steering is measured from 5 s before to this long after, s, in steps of
const AFTER_S: f64 = 2.0;
/// this, s.
const STEP_S: f64 = 0.5;
/// Minimum lateral acceleration beyond the road's that is an emergency, m/s2.
const SWERVE_MPS2: f64 = 3.0;
/// Minimum rate of it that is one, m/s3, with a deviation of
const SWERVE_MPS3: f64 = 5.0;
/// this much, m.
const DEVIATION_M: f64 = 0.3;
/// Minimum speed for swerving, m/s.
const LEAST_MPS: f64 = 3.0;
/// The road's curvature is measured over this distance on either side, m.
const CURVATURE_REACH_M: f64 = 5.0;

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (values[(n - 1) / 2] + values[n / 2]) / 2.0
}

/// Offset minus the median of the earlier frames in the last [`MEDIAN_OVER_S`]; NaN until enough is known.
fn deviations(times: &[f64], offset: &[f64]) -> Vec<f64> {
    let mut first = 0;
    (0..times.len())
        .map(|i| {
            if offset[i].is_nan() {
                first = i + 1;
                return f64::NAN;
            }
            while times[i] - times[first] > MEDIAN_OVER_S + 0.02 {
                first += 1;
            }
            if times[i] - times[first] < MEDIAN_LEAST_S - 1e-6 {
                return f64::NAN;
            }
            offset[i] - median(&mut offset[first..i].to_vec())
        })
        .collect()
}

/// The deviations from the line of the lane, limited to the part that the ego's own steering caused: where lines wander
/// or lanes fork, an ego that drives straight on does not deviate.
fn steered(scene: &Interaction<'_>, deviations: Vec<f64>) -> Vec<f64> {
    let (ego, times, path) = (scene.around.ego, scene.times, scene.around.path);
    let place = |i: usize| OnWay { position: ego.position[i], direction: path.ego_heading[i] };
    let steps = |seconds: f64| (seconds / STEP_S) as usize;
    let at = |i: usize, seconds: f64| {
        let row = times.partition_point(|t| *t < times[i] + seconds - 1e-6);
        (row < times.len() && (times[row] - times[i] - seconds).abs() < STEP_S).then_some(row)
    };
    let own = |i: usize, sign: f64| {
        let before = (2..=steps(MEDIAN_OVER_S)).filter_map(|k| at(i, -(k as f64) * STEP_S));
        let after = (0..=steps(AFTER_S)).filter_map(|k| at(i, k as f64 * STEP_S));
        most_shifted(&before.map(place).collect::<Vec<_>>(), &after.map(place).collect::<Vec<_>>(), sign)
    };
    let limited =
        |(i, d): (usize, f64)| if d.is_nan() { d } else { d.signum() * d.abs().min(own(i, d.signum())) };
    deviations.into_iter().enumerate().map(limited).collect()
}

/// Writes `ego.lateral_deviation`, `swerve`.
pub fn write(scene: &Interaction<'_>, table: &mut TableBuilder<'_>) {
    let (ego, times) = (scene.around.ego, scene.times);
    let Some(lanes) = scene.around.lanes else { return };
    let deviation = steered(scene, deviations(times, &unrolled(scene)));
    let beyond_road = |i: usize| {
        let v = ego.forward_speed[i];
        lanes.at(i).map_or(f64::NAN, |on| {
            v * (ego.yaw_rate[i] - v * on.corridor.line.curvature_at(on.s, CURVATURE_REACH_M))
        })
    };
    let lateral: Vec<f64> = (0..ego.len()).map(beyond_road).collect();
    let rate = slope(times, &lateral, DERIVATIVE_REACH_S);
    let swerves = |i: usize| {
        if ego.forward_speed[i] < LEAST_MPS {
            return Tri::False;
        }
        if lateral[i].is_nan() {
            return Tri::Unknown;
        }
        // Beyond its noise; with such a large deviation the rate over 0.4 s is not usable.
        let noise = ego.sd.as_ref().map_or(0.0, |sd| ego.forward_speed[i].abs() * stated(sd.yaw_rate[i]));
        let jerks = rate[i].abs() - 2.0 * noise / DERIVATIVE_REACH_S >= SWERVE_MPS3
            && deviation[i].abs() - ego.place_sd(i) >= DEVIATION_M;
        Tri::from(lateral[i].abs() - noise >= SWERVE_MPS2 || jerks)
    };
    table.flag(id::EGO_SWERVE, (0..ego.len()).map(swerves).collect());
    table.number(id::EGO_LATERAL_DEVIATION, deviation);
}
