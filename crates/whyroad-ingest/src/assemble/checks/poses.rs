//! Poses of the ego to which it cannot have moved: a step backwards while it drives forwards, or a leap ahead.
//! Converters that repeat or extrapolate the end of a log make the former (three scenes of nuScenes in ScenarioNet
//! pickles), localization the latter; without this, all poses behind a leap would be steps back from it.

use super::{MAX_ACCEL_MPS2, warning};
use whyroad_model::Diagnostic;
use whyroad_model::scene::{Drive, Motion};

/// Minimum speed before the step, m/s, and minimum length of the step, m.
const DRIVES_MPS: f64 = 1.0;
const STEP_M: f64 = 0.1;
/// After a step, poses are unknown for as long as they are behind the place that it can reach by braking at 1 g, at
/// most this time: poses that stay displaced are a correction of the localization, s.
const DISPLACED_S: f64 = 1.0;
const BRAKING_MPS2: f64 = 9.81;
/// A leap ahead, beyond what it can reach by speeding up at 1 g, m.
const LEAP_M: f64 = 1.0;
/// Error of a pose, m.
const POSE_M: f64 = 0.05;

/// Sets impossible poses of the ego to unknown, and the velocities beside them that were computed from them.
pub(super) fn steps_back(drive: &mut Drive) -> Option<Diagnostic> {
    let start = *drive.times.first()?;
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(start)).collect();
    let m = &mut drive.ego.as_mut()?.motion;
    let rows = impossible(&seconds, m);
    for i in spoiled(&rows, &seconds, m) {
        (m.vx[i], m.vy[i]) = (f64::NAN, f64::NAN);
        m.accel.get_mut(i).into_iter().for_each(|a| *a = f64::NAN);
    }
    for &i in &rows {
        for column in [
            &mut m.x,
            &mut m.y,
            &mut m.z,
            &mut m.heading,
            &mut m.vx,
            &mut m.vy,
            &mut m.accel,
            &mut m.yaw_rate,
            &mut m.forward,
        ] {
            column.get_mut(i).into_iter().for_each(|v| *v = f64::NAN);
        }
    }
    let at = seconds[*rows.first()?];
    let n = rows.len();
    Some(warning(
        "ingest.pose.impossible",
        format!("行程开始后 {at:.1} s，自车在前进中跳到不可能到达之处；{n} 行位姿不可能，记为未知"),
        format!(
            "{at:.1} s after its start the ego jumps to where it cannot have driven; {n} poses are impossible and are set \
             to unknown"
        ),
    ))
}

/// Rows right before or behind impossible ones whose stated velocity is none that the ego can have had: sources that
/// compute it as the difference of two poses compute it from an impossible one.
fn spoiled(rows: &[usize], seconds: &[f64], m: &Motion) -> Vec<usize> {
    let n = m.len().min(seconds.len());
    let is_impossible = |i: usize| rows.binary_search(&i).is_ok();
    let is_possible = |i: usize| i < n && !is_impossible(i);
    let before = |i: usize| i.checked_sub(1);
    let is_beside =
        |i: &usize| is_possible(*i) && (is_impossible(i + 1) || before(*i).is_some_and(is_impossible));
    let has_spoiled = |&i: &usize| {
        // The speed between this row and the one on its other side.
        let Some(other) = [Some(i + 1), before(i)].into_iter().flatten().find(|&j| is_possible(j)) else {
            return false;
        };
        let (from, to) = (i.min(other), i.max(other));
        let (sin, cos) = m.heading[i].sin_cos();
        let along = |x: f64, y: f64| x * cos + y * sin;
        let dt = seconds[to] - seconds[from];
        let speed = along(m.x[to] - m.x[from], m.y[to] - m.y[from]) / dt;
        (along(m.vx[i], m.vy[i]) - speed).abs() > MAX_ACCEL_MPS2 * dt
    };
    (0..n).filter(is_beside).filter(has_spoiled).collect()
}

/// Where a pose is, of where the ego can be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Displaced {
    Not,
    Behind,
    Ahead,
}

/// The rows, each decided from earlier ones only.
fn impossible(seconds: &[f64], m: &Motion) -> Vec<usize> {
    let mut out = Vec::new();
    // The last possible row, and the speed along the heading there.
    let mut last: Option<(usize, Option<f64>)> = None;
    let mut displaced = Displaced::Not;
    for i in (0..m.len().min(seconds.len())).filter(|&i| m.x[i].is_finite() && m.y[i].is_finite()) {
        let Some((from, speed)) = last else {
            last = Some((i, None));
            continue;
        };
        let dt = seconds[i] - seconds[from];
        let (sin, cos) = m.heading[from].sin_cos();
        let along = (m.x[i] - m.x[from]) * cos + (m.y[i] - m.y[from]) * sin;
        let reach = 0.5 * BRAKING_MPS2 * dt * dt;
        let drives = speed.filter(|v| *v >= DRIVES_MPS && dt > 0.0 && dt <= DISPLACED_S);
        displaced = drives.map_or(Displaced::Not, |v| {
            let off = along - v * dt;
            let is_behind = match displaced {
                Displaced::Behind => off < -(POSE_M + reach),
                _ => along <= -STEP_M && -off / (dt * dt) > MAX_ACCEL_MPS2,
            };
            let is_ahead = off > reach + if displaced == Displaced::Ahead { POSE_M } else { LEAP_M };
            match (is_behind, is_ahead) {
                (true, _) => Displaced::Behind,
                (_, true) => Displaced::Ahead,
                _ => Displaced::Not,
            }
        });
        if displaced != Displaced::Not {
            out.push(i);
        } else {
            // Over a gap the mean speed is not that of its end.
            last = Some((i, Some(along / dt).filter(|_| i == from + 1)));
        }
    }
    out
}
