//! Headings that cannot be. Sources that average angles linearly step over pi: the place goes on, the heading jumps for
//! a few rows and comes back. Detectors take the rear of a vehicle for its front: it drives fast, and backwards.

use super::warning;
use crate::assemble::angles::wrap_angle;
use std::f64::consts::PI;
use whyroad_model::scene::{Drive, Motion};
use whyroad_model::{Bilingual, Diagnostic, ObjectClass};

/// A step of the heading above this within [`STEP_S`] is impossible, rad: over 3 rad/s, three times what a car on dry
/// asphalt reaches at walking pace.
const JUMP_RAD: f64 = 1.0;
const STEP_S: f64 = 0.35;
/// The object moves at least this fast, m/s, and its course differs from the heading before by at most this, rad.
const MOVING_MPS: f64 = 2.0;
const COURSE_RAD: f64 = 0.8;
/// Later than this after the last possible heading, the new one is taken, s.
const ACCEPTED_S: f64 = 1.0;

/// Nobody reverses as fast, m/s, over this time, s, with the heading at least this far from the way, rad (150 deg).
const NO_REVERSE_MPS: f64 = 6.0;
const REVERSE_SPAN_S: f64 = 0.5;
const OPPOSITE_RAD: f64 = PI - PI / 6.0;
/// A heading that steps by more than this has front and rear swapped, rad.
const SWAPPED_RAD: f64 = 2.0 * PI / 3.0;

/// On two light wheels; people on foot may turn on the spot.
const CYCLES: [ObjectClass; 3] = [ObjectClass::Bicycle, ObjectClass::Bicyclist, ObjectClass::EBike];

/// Rows whose heading is impossible, each decided from earlier ones only.
fn impossible(seconds: &[f64], m: &Motion) -> Vec<usize> {
    let mut out = Vec::new();
    // The last possible row, and the row before.
    let (mut sound, mut before): (Option<usize>, Option<usize>) = (None, None);
    for i in 0..m.len().min(seconds.len()) {
        if ![m.x[i], m.y[i], m.heading[i]].iter().all(|v| v.is_finite()) {
            continue;
        }
        let has_jumped = sound.zip(before).is_some_and(|(last, before)| {
            let dt = seconds[i] - seconds[before];
            let (dx, dy) = (m.x[i] - m.x[before], m.y[i] - m.y[before]);
            let course = wrap_angle(dy.atan2(dx) - m.heading[last]).abs();
            dt > 0.0
                && dt <= STEP_S
                && seconds[i] - seconds[last] <= ACCEPTED_S
                && dx.hypot(dy) / dt >= MOVING_MPS
                && course <= COURSE_RAD
                && wrap_angle(m.heading[i] - m.heading[last]).abs() > JUMP_RAD
        });
        if has_jumped {
            out.push(i);
        } else {
            sound = Some(i);
        }
        before = Some(i);
    }
    out
}

/// Rows in which front and rear are swapped: from the row that shows it, decided from earlier ones, until the heading
/// steps back.
fn swapped(seconds: &[f64], m: &Motion) -> Vec<usize> {
    let mut out = Vec::new();
    let (mut is_swapped, mut before) = (false, f64::NAN);
    for i in 0..m.len().min(seconds.len()) {
        if ![m.x[i], m.y[i], m.heading[i]].iter().all(|v| v.is_finite()) {
            continue;
        }
        if wrap_angle(m.heading[i] - before).abs() > SWAPPED_RAD {
            is_swapped = false;
        }
        before = m.heading[i];
        let span = (0..i).rev().find(|&k| seconds[i] - seconds[k] >= REVERSE_SPAN_S - 1e-3);
        let reverses = span.is_some_and(|k| {
            let (dt, dx, dy) = (seconds[i] - seconds[k], m.x[i] - m.x[k], m.y[i] - m.y[k]);
            dt <= 2.0 * REVERSE_SPAN_S
                && dx.hypot(dy) >= NO_REVERSE_MPS * dt
                && wrap_angle(dy.atan2(dx) - m.heading[i]).abs() >= OPPOSITE_RAD
        });
        is_swapped |= reverses;
        if is_swapped {
            out.push(i);
        }
    }
    out
}

/// Sets headings that point backwards to unknown.
pub(super) fn backwards(drive: &mut Drive) -> Option<Diagnostic> {
    let (rows, objects) = forget(drive, swapped);
    (rows > 0).then(|| {
        warning(
            "ingest.heading.backwards",
            format!("{objects} 个目标（或自车）的 {rows} 行航向与快速行驶的方向相反；这些航向记为未知，改由位置估计"),
            format!(
                "{rows} headings of {objects} vehicles point backwards while they drive fast; they are set to unknown and \
                 estimated from the positions"
            ),
        )
        .with_hint(Bilingual::new(
            "检测器把车尾当作车头时会这样；自车则多为航向约定相反：请在来源中加 180 度",
            "detectors do so that take the rear for the front; of the ego it is mostly the convention of the heading: add \
             180 degrees at the source",
        ))
    })
}

/// Sets the headings in the rows that `find` names to unknown, of the ego, vehicles and bicycles; how many rows, and of
/// how many objects.
fn forget(drive: &mut Drive, find: impl Fn(&[f64], &Motion) -> Vec<usize>) -> (usize, usize) {
    let Some(start) = drive.times.first().copied() else { return (0, 0) };
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let (mut rows, mut objects) = (0, 0);
    let mut in_motion = |m: &mut Motion, seconds: &[f64]| {
        let found = find(seconds, m);
        rows += found.len();
        objects += usize::from(!found.is_empty());
        for i in found {
            m.heading[i] = f64::NAN;
            m.yaw_rate.get_mut(i).into_iter().for_each(|v| *v = f64::NAN);
            // Backwards along what was no heading.
            m.forward.get_mut(i).into_iter().filter(|v| **v < 0.0).for_each(|v| *v = f64::NAN);
        }
    };
    if let Some(ego) = &mut drive.ego {
        in_motion(&mut ego.motion, &seconds);
    }
    for track in drive.tracks.iter_mut().filter(|t| t.class.is_vehicle() || CYCLES.contains(&t.class)) {
        let own: Vec<f64> = track.frames.iter().map(|&f| seconds[f as usize]).collect();
        in_motion(&mut track.motion, &own);
    }
    (rows, objects)
}

/// Sets impossible headings of the ego, of vehicles and of bicycles to unknown.
pub(super) fn jumps(drive: &mut Drive) -> Option<Diagnostic> {
    let (rows, objects) = forget(drive, impossible);
    (rows > 0).then(|| {
        warning(
            "ingest.heading.impossible",
            format!("{objects} 个目标（或自车）的 {rows} 行航向不可能：位置连续而航向跳变；这些航向记为未知"),
            format!(
                "{rows} headings of {objects} objects are impossible: they jump while the place goes on; they are set to \
                 unknown and estimated"
            ),
        )
        .with_hint(Bilingual::new(
            "常因航向经过 ±180 度时线性插值造成：插值时取较短的一侧",
            "mostly from interpolating across 180 degrees: interpolate angles the shorter way round",
        ))
    })
}
