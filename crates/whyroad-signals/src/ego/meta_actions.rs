//! Meta actions of the ego in every frame (LABELING.md 5, after AR1 table 5). The names are from AR1, the thresholds
//! are ours: AR1 does not state any.

use crate::ego::motion::EgoMotion;
use crate::series::{absorb_short_runs, smooth};
use crate::table::TableBuilder;
use whyroad_model::Tri;
use whyroad_model::catalog::{
    id,
    value::{EgoMetaLateral, EgoMetaLongitudinal},
};

/// Below this |acceleration| the speed is maintained, m/s2.
const MAINTAIN_MPS2: f64 = 0.4;
/// Minimum |acceleration| that is strong, m/s2.
const STRONG_MPS2: f64 = 2.0;
/// Forward speed below which the ego reverses, m/s.
const REVERSE_MPS: f64 = -0.3;
/// Below this |yaw rate| the ego goes straight: 2 deg/s.
const STRAIGHT_RADPS: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Minimum |yaw rate| of sharp steering: 15 deg/s.
const SHARP_RADPS: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Half width of the mean of acceleration and yaw rate, s.
const MEAN_REACH_S: f64 = 0.3;
/// Shorter runs are merged with the run before, s; one that the end of the record cuts off only with one of its side.
const LEAST_RUN_S: f64 = 0.5;

/// Which way an action changes the motion: speed up, slow down, to the left, to the right, or neither.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Neither,
    Plus,
    Minus,
    /// Standing or reversing.
    Own,
}

fn along_side(action: EgoMetaLongitudinal) -> Side {
    match action {
        EgoMetaLongitudinal::Stop | EgoMetaLongitudinal::Reverse => Side::Own,
        EgoMetaLongitudinal::StrongDecelerate | EgoMetaLongitudinal::GentleDecelerate => Side::Minus,
        EgoMetaLongitudinal::MaintainSpeed => Side::Neither,
        EgoMetaLongitudinal::GentleAccelerate | EgoMetaLongitudinal::StrongAccelerate => Side::Plus,
    }
}

fn across_side(action: EgoMetaLateral) -> Side {
    match action {
        EgoMetaLateral::GoStraight => Side::Neither,
        EgoMetaLateral::SteerLeft | EgoMetaLateral::SharpSteerLeft => Side::Plus,
        EgoMetaLateral::SteerRight | EgoMetaLateral::SharpSteerRight => Side::Minus,
        EgoMetaLateral::ReverseLeft | EgoMetaLateral::ReverseRight => Side::Own,
    }
}

/// True for two actions of one side; standing and reversing are alike only to themselves.
fn alike<T: Copy + PartialEq>(side: impl Fn(T) -> Side) -> impl Fn(T, T) -> bool {
    move |a, b| a == b || (side(a) == side(b) && side(a) != Side::Own)
}

fn longitudinal(standstill: Tri, forward_speed: f64, accel: f64) -> Option<EgoMetaLongitudinal> {
    if standstill.known()? {
        return Some(EgoMetaLongitudinal::Stop);
    }
    if forward_speed < REVERSE_MPS {
        return Some(EgoMetaLongitudinal::Reverse);
    }
    Some(match accel {
        a if a.is_nan() => return None,
        a if a <= -STRONG_MPS2 => EgoMetaLongitudinal::StrongDecelerate,
        a if a <= -MAINTAIN_MPS2 => EgoMetaLongitudinal::GentleDecelerate,
        a if a < MAINTAIN_MPS2 => EgoMetaLongitudinal::MaintainSpeed,
        a if a < STRONG_MPS2 => EgoMetaLongitudinal::GentleAccelerate,
        _ => EgoMetaLongitudinal::StrongAccelerate,
    })
}

fn lateral(standstill: Tri, forward_speed: f64, yaw_rate: f64) -> Option<EgoMetaLateral> {
    if standstill.known()? {
        return Some(EgoMetaLateral::GoStraight);
    }
    if yaw_rate.is_nan() {
        return None;
    }
    if yaw_rate.abs() < STRAIGHT_RADPS {
        return Some(EgoMetaLateral::GoStraight);
    }
    if forward_speed < REVERSE_MPS {
        // Reversing with a clockwise turn moves the rear to the ego's left.
        return Some(if yaw_rate < 0.0 { EgoMetaLateral::ReverseLeft } else { EgoMetaLateral::ReverseRight });
    }
    Some(match (yaw_rate > 0.0, yaw_rate.abs() >= SHARP_RADPS) {
        (true, false) => EgoMetaLateral::SteerLeft,
        (false, false) => EgoMetaLateral::SteerRight,
        (true, true) => EgoMetaLateral::SharpSteerLeft,
        (false, true) => EgoMetaLateral::SharpSteerRight,
    })
}

/// Makes the actions at the end unknown whose frame's own acceleration is of the opposite side: the mean over the time
/// before lags behind it.
fn forget_contradicted(along: &mut [Option<EgoMetaLongitudinal>], accel: &[f64]) {
    let own = |a: f64| match a {
        a if a <= -MAINTAIN_MPS2 => Side::Minus,
        a if a >= MAINTAIN_MPS2 => Side::Plus,
        _ => Side::Neither,
    };
    for (action, a) in along.iter_mut().zip(accel).rev() {
        match (action.map(along_side), own(*a)) {
            (Some(Side::Plus), Side::Minus) | (Some(Side::Minus), Side::Plus) => *action = None,
            _ => break,
        }
    }
}

/// The ego's meta actions (LABELING.md 5), one value per frame of the drive; `None` in a frame is unknown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MetaActions {
    /// Values of `ego.meta_longitudinal`.
    pub longitudinal: Vec<Option<EgoMetaLongitudinal>>,
    /// Values of `ego.meta_lateral`.
    pub lateral: Vec<Option<EgoMetaLateral>>,
}

impl MetaActions {
    /// Of the ego's motion; `times` in s by frame.
    pub fn new(ego: &EgoMotion, times: &[f64]) -> Self {
        let accel = smooth(times, &ego.accel, MEAN_REACH_S);
        let yaw_rate = smooth(times, &ego.yaw_rate, MEAN_REACH_S);
        let frames = 0..ego.len();
        let mut along: Vec<_> =
            frames.clone().map(|i| longitudinal(ego.standstill[i], ego.forward_speed[i], accel[i])).collect();
        let mut across: Vec<_> =
            frames.map(|i| lateral(ego.standstill[i], ego.forward_speed[i], yaw_rate[i])).collect();
        absorb_short_runs(times, &mut along, LEAST_RUN_S, alike(along_side));
        absorb_short_runs(times, &mut across, LEAST_RUN_S, alike(across_side));
        forget_contradicted(&mut along, &ego.accel);
        Self { longitudinal: along, lateral: across }
    }

    /// Writes `ego.meta_longitudinal` and `ego.meta_lateral`.
    pub(crate) fn write(&self, table: &mut TableBuilder<'_>) {
        table.category(id::EGO_META_LONGITUDINAL, self.longitudinal.iter().copied());
        table.category(id::EGO_META_LATERAL, self.lateral.iter().copied());
    }
}
