//! Headings to which nothing can have turned: sources that average angles linearly step over pi. The place goes on, the
//! heading jumps for a few rows and comes back.

use super::warning;
use crate::assemble::angles::wrap_angle;
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

/// Sets impossible headings of the ego, of vehicles and of bicycles to unknown.
pub(super) fn jumps(drive: &mut Drive) -> Option<Diagnostic> {
    let start = *drive.times.first()?;
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let (mut rows, mut objects) = (0, 0);
    let mut forget = |m: &mut Motion, seconds: &[f64]| {
        let found = impossible(seconds, m);
        rows += found.len();
        objects += usize::from(!found.is_empty());
        for i in found {
            m.heading[i] = f64::NAN;
            m.yaw_rate.get_mut(i).into_iter().for_each(|v| *v = f64::NAN);
        }
    };
    if let Some(ego) = &mut drive.ego {
        forget(&mut ego.motion, &seconds);
    }
    for track in drive.tracks.iter_mut().filter(|t| t.class.is_vehicle() || CYCLES.contains(&t.class)) {
        let own: Vec<f64> = track.frames.iter().map(|&f| seconds[f as usize]).collect();
        forget(&mut track.motion, &own);
    }
    (rows > 0).then(|| {
        warning(
            "ingest.heading.impossible",
            format!("{objects} 个目标（含自车）的 {rows} 行航向不可能：位置连续而航向跳变；这些航向记为未知"),
            format!(
                "{rows} headings of {objects} objects (the ego included) are impossible: they jump while the place goes \
                 on; they are set to unknown"
            ),
        )
        .with_hint(Bilingual::new(
            "常因航向经过 ±180 度时线性插值造成：插值时取较短的一侧",
            "mostly from interpolating across 180 degrees: interpolate angles the shorter way round",
        ))
    })
}
