//! States of the ego and the objects, estimated from the measurements in the log: the step before all signals.
//!
//! The lake contains only measurements; velocities, accelerations and yaw rates that a log does not have are unknown in
//! it, and measurements may be noisy, late or lost. [`estimated`] computes states with standard deviations from the
//! given drive only: on a drive cut at the keyframe ([`Drive::until`]) it is causal, on a whole drive it may use both
//! sides of a row. Code that reads motion calls it first: [`crate::derive`] and [`crate::meta_actions`] call it
//! themselves and take drives as stored in the lake; so do `whyroad_engine::states` and the engine's `estimated` for
//! pictures and summaries. An estimated drive must not be estimated again.
//!
//! An object whose measurements are exact and complete keeps them; missing values (`vx`, `vy`, `accel`, `yaw_rate` of
//! [`Motion`]) are completed row by row from neighboring rows. Any other object is smoothed. In a drive cut between two
//! measurements, rows that depend on the later one are missing at the end (`known_at` in the scene tables); they are
//! predicted until the next measurement is due. The method is described in docs/explanation/estimates.md. Not here:
//! signals, and everything that needs a map.
#![allow(
    clippy::needless_range_loop,
    reason = "rows of several columns and components of matrices go by index"
)]

mod bicycle;
mod course;
mod derived;
mod deviation;
mod estimated;
mod join;
mod jumps;
mod kalman;
mod kinematics;
mod matrix;
mod noise;
mod objects;
mod samples;
#[cfg(test)]
mod simulated;
mod sizes;
mod smoother;
mod standing;
mod walker;
mod walking;

pub use derived::add_derived;
pub(crate) use estimated::estimated_at_the_end;
pub use estimated::{DriveNoise, Estimated, estimated, noise};
pub(crate) use sizes::{footprint, usual_size, with_possible_sizes};

pub use noise::{LogNoise, Noise};
pub use objects::Joined;
pub use smoother::Deviations;
pub(crate) use smoother::{Aside, stated};

use crate::geometry::wrap;
use std::borrow::Cow;
use whyroad_model::scene::Motion;
use whyroad_model::{Drive, ObjectClass};

/// A lateral step of more than this in 0.1 s is a jump (simulators change lanes this way), not a motion, m.
pub(crate) const MAX_SIDE_STEP_M: f64 = 1.0;

/// The drive with its estimated states. Borrowed when there is nothing to estimate: when the log states everything
/// exactly, or has no pose of the ego, so that positions are relative to a moving car and do not determine velocities
/// over ground.
pub fn estimate(drive: &Drive) -> Cow<'_, Drive> {
    estimated(drive).drive
}

/// True when every row has all motion values.
fn is_stated(m: &Motion) -> bool {
    m.forward.is_empty()
        && [&m.vx, &m.vy, &m.accel, &m.yaw_rate].iter().all(|v| v.iter().all(|x| !x.is_nan()))
}

/// Completes the unknown values of one object's motion; `seconds` ascend, one per row, as `lengths`.
fn complete_motion(m: &mut Motion, seconds: &[f64], lengths: &[f64], class: ObjectClass) {
    let on_wheels =
        !matches!(class, ObjectClass::Pedestrian | ObjectClass::WheeledPedestrian | ObjectClass::Animal);
    let jumps = if on_wheels { sideways_jumps(m, seconds, lengths) } else { vec![false; m.len()] };
    let derived = kinematics::derive(seconds, &m.x, &m.y, &m.heading, |row| jumps[row]);
    let stated = m.forward.iter().chain(m.vx.iter().filter(|_| m.forward.is_empty())).any(|v| !v.is_nan());
    for row in 0..m.len() {
        let forward = m.forward.get(row).copied().unwrap_or(f64::NAN);
        if m.vx[row].is_nan() || m.vy[row].is_nan() {
            (m.vx[row], m.vy[row]) = (derived.vx[row], derived.vy[row]);
            if !forward.is_nan() {
                // The log states the speed along the heading; the lateral part comes from the positions, if they show
                // one.
                let (s, c) = m.heading[row].sin_cos();
                let sideways = Some(m.vy[row] * c - m.vx[row] * s).filter(|v| !v.is_nan()).unwrap_or(0.0);
                (m.vx[row], m.vy[row]) = (forward * c - sideways * s, forward * s + sideways * c);
            }
        }
    }
    // The first derivative of a stated velocity is less noisy than the second derivative of the positions.
    let accel =
        if stated { kinematics::acceleration(seconds, &m.vx, &m.vy, &m.heading) } else { derived.accel };
    fill(&mut m.accel, &accel);
    fill(&mut m.yaw_rate, &derived.yaw_rate);
    forget_impossible(class, m);
}

/// Fills unknown values of `stated` with those of `estimated`.
fn fill(stated: &mut [f64], estimated: &[f64]) {
    stated.iter_mut().zip(estimated).filter(|(s, _)| s.is_nan()).for_each(|(s, e)| *s = *e);
}

/// Impossible speeds come from an identity switch or a bad box: the position is kept, the motion is unknown.
fn forget_impossible(class: ObjectClass, m: &mut Motion) {
    let limit = class.max_speed_mps();
    // Mostly the square shows that it is not, by more than rounding errors.
    let certain = limit * limit * (1.0 - 1e-9);
    let is_possible = |vx: f64, vy: f64| vx * vx + vy * vy < certain;
    let is_impossible = |row: &usize| !is_possible(m.vx[*row], m.vy[*row]) && m.speed(*row) > limit;
    for row in (0..m.len()).filter(is_impossible).collect::<Vec<_>>() {
        m.vx[row] = f64::NAN;
        m.vy[row] = f64::NAN;
        m.accel[row] = f64::NAN;
    }
}

/// By row: true when the front bumper moved sideways, since the row before, faster than any vehicle can.
fn sideways_jumps(m: &Motion, seconds: &[f64], lengths: &[f64]) -> Vec<bool> {
    let front = |i: usize| {
        let (s, c) = m.heading[i].sin_cos();
        let half = lengths.get(i).copied().unwrap_or(f64::NAN) / 2.0;
        (m.x[i] + half * c, m.y[i] + half * s)
    };
    let mut out = Vec::with_capacity(m.len());
    let mut before = None;
    for row in 0..m.len() {
        let b = front(row);
        let jumps = |a: (f64, f64)| {
            let dt = seconds[row] - seconds[row - 1];
            let most = MAX_SIDE_STEP_M * (dt / 0.1).max(1.0);
            let moved = (b.0 - a.0, b.1 - a.1);
            // Mostly it moved by less than that in any direction, by more than rounding errors.
            if dt > kinematics::MAX_GAP_S || moved.0.abs() + moved.1.abs() < most * (1.0 - 1e-9) {
                return false;
            }
            let middle = m.heading[row - 1] + wrap(m.heading[row] - m.heading[row - 1]) / 2.0;
            let side = moved.1 * middle.cos() - moved.0 * middle.sin();
            dt <= kinematics::MAX_GAP_S && side.abs() > most
        };
        out.push(before.is_some_and(jumps));
        before = Some(b);
    }
    out
}

#[cfg(test)]
mod tests;
