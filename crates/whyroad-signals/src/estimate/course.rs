//! Headings that a log lacks, from its positions: a vehicle heads where it drives, or away from it in reverse. Radar
//! tracks and many lists of objects have none, and ingest sets headings that contradict the positions to unknown.
//!
//! Between two stated headings that are near in time the heading turns evenly. Elsewhere it is the direction of a line
//! fitted to the positions around the row; who stands heads where it drove before, or where it then drives. A vehicle
//! that never moves has no heading.

use super::bicycle::on_wheels;
use crate::geometry::wrap;
use std::ops::Range;
use whyroad_model::scene::Motion;
use whyroad_model::{Drive, ObjectClass};

/// Length of the path to which a line is fitted, m: of a car's tightest turn (a radius of 6 m) half a radian, whose
/// chord has the direction of its middle.
const CHORD_M: f64 = 3.0;
/// Rows farther away than this in time are not used, s: slower than 1 m/s a vehicle counts as standing.
const REACH_S: f64 = 1.5;
/// Rows apart by more than this do not belong to one path, s.
const GAP_S: f64 = 1.0;
/// Stated headings apart by at most this are joined evenly, s.
const BETWEEN_S: f64 = 1.0;
/// Nobody reverses faster, m/s.
const FORWARD_MPS: f64 = 7.0;
/// Cosine of the angle between heading and way above which front and rear are swapped (150 deg).
const SWAPPED_COS: f64 = -0.866;
/// A stated speed along the heading below this tells no direction, m/s.
const MOVING_MPS: f64 = 0.5;

/// Drives or rides where it heads; what the source does not name mostly does, too, if it moves on for meters.
fn drives(class: ObjectClass) -> bool {
    on_wheels(class) || matches!(class, ObjectClass::EBike | ObjectClass::Unknown)
}

/// The drive with the headings that its vehicles lack; `None` if they lack none.
pub(super) fn with_headings(drive: &Drive, seconds: &[f64]) -> Option<Drive> {
    let of_ego = drive.ego.as_ref().and_then(|ego| fill(&ego.motion, seconds));
    let of_tracks: Vec<Option<Vec<f64>>> = drive
        .tracks
        .iter()
        .map(|t| {
            if !drives(t.class) || !lacks(&t.motion) {
                return None;
            }
            let own: Vec<f64> = t.frames.iter().map(|&f| seconds[f as usize]).collect();
            fill(&t.motion, &own)
        })
        .collect();
    if of_ego.is_none() && of_tracks.iter().all(Option::is_none) {
        return None;
    }
    let mut out = drive.clone();
    if let (Some(ego), Some(heading)) = (&mut out.ego, of_ego) {
        ego.motion.heading = heading;
    }
    for (track, heading) in out.tracks.iter_mut().zip(of_tracks) {
        if let Some(heading) = heading {
            track.motion.heading = heading;
        }
    }
    Some(out)
}

fn is_placed(m: &Motion, row: usize) -> bool {
    m.x[row].is_finite() && m.y[row].is_finite()
}

fn lacks(m: &Motion) -> bool {
    (0..m.len()).any(|i| m.heading[i].is_nan() && is_placed(m, i))
}

/// The headings of a motion, completed; `None` if none can be added.
fn fill(m: &Motion, seconds: &[f64]) -> Option<Vec<f64>> {
    if !lacks(m) {
        return None;
    }
    let mut out = m.heading.clone();
    // Ingest recognizes swapped ends only once they have shown: the rows before are as wrong.
    for i in 0..m.len() {
        let opposes = |(course, speed): (f64, f64)| {
            speed >= FORWARD_MPS && wrap(course - m.heading[i]).cos() < SWAPPED_COS
        };
        if m.heading[i].is_finite() && course(m, seconds, i).is_some_and(opposes) {
            out[i] = f64::NAN;
        }
    }
    let stated: Vec<usize> = (0..m.len()).filter(|&i| out[i].is_finite()).collect();
    for pair in stated.windows(2) {
        join_evenly(&mut out, seconds, pair[0]..pair[1]);
    }
    let mut start = 0;
    while let Some(from) = (start..m.len()).find(|&i| out[i].is_nan()) {
        let end = (from..m.len()).find(|&i| out[i].is_finite()).unwrap_or(m.len());
        follow(m, seconds, &mut out, from..end);
        start = end;
    }
    out.iter().zip(&m.heading).any(|(a, b)| a.is_finite() && a.to_bits() != b.to_bits()).then_some(out)
}

/// Turns evenly between two stated headings.
fn join_evenly(heading: &mut [f64], seconds: &[f64], rows: Range<usize>) {
    let (a, b) = (rows.start, rows.end);
    let took = seconds[b] - seconds[a];
    if took > BETWEEN_S {
        return;
    }
    let turn = wrap(heading[b] - heading[a]);
    for i in a + 1..b {
        heading[i] = wrap(heading[a] + turn * (seconds[i] - seconds[a]) / took);
    }
}

/// Sets the rows of a part without headings to the direction of motion. `rows` lies between rows with headings.
fn follow(m: &Motion, seconds: &[f64], heading: &mut [f64], rows: Range<usize>) {
    let courses: Vec<Option<(f64, f64)>> = rows.clone().map(|i| course(m, seconds, i)).collect();
    let is_fast = courses.iter().flatten().any(|(_, speed)| *speed >= FORWARD_MPS);
    // What the rows beside it say of the way it drives.
    let opposes = |stated: f64, course: Option<&(f64, f64)>| {
        course.is_some_and(|(course, _)| wrap(course - stated).cos() < 0.0)
    };
    let before = rows.start.checked_sub(1).map(|i| heading[i]).filter(|h| h.is_finite());
    let behind = heading.get(rows.end).copied().filter(|h| h.is_finite());
    let in_reverse = !is_fast
        && match (before, behind) {
            (Some(h), _) => opposes(h, courses.iter().flatten().next()),
            (None, Some(h)) => opposes(h, courses.iter().flatten().next_back()),
            (None, None) => false,
        };
    for (i, course) in rows.clone().zip(&courses) {
        let Some((course, _)) = course else { continue };
        let backwards = match m.forward.get(i) {
            Some(v) if v.abs() >= MOVING_MPS => *v < 0.0 && !is_fast,
            _ => in_reverse,
        };
        heading[i] = if backwards { wrap(course + std::f64::consts::PI) } else { *course };
    }
    // Who stands heads where it drove, or where it then drives.
    let mut last = before;
    for i in rows.clone() {
        last = Some(heading[i]).filter(|h| h.is_finite()).or(last);
        heading[i] = last.filter(|_| is_placed(m, i)).unwrap_or(f64::NAN);
    }
    let mut next = behind;
    for i in rows.rev() {
        next = Some(heading[i]).filter(|h| h.is_finite()).or(next);
        heading[i] = next.filter(|_| is_placed(m, i)).unwrap_or(f64::NAN);
    }
}

/// Direction of motion in a row, rad, and speed, m/s, of a line fitted to the rows around it; `None` while it stands or
/// has no position.
fn course(m: &Motion, seconds: &[f64], row: usize) -> Option<(f64, f64)> {
    if !is_placed(m, row) {
        return None;
    }
    let joins = |from: usize, to: usize| is_placed(m, to) && (seconds[to] - seconds[from]).abs() <= GAP_S;
    let (mut a, mut b) = (row, row);
    while (m.x[b] - m.x[a]).hypot(m.y[b] - m.y[a]) < CHORD_M {
        let earlier = a.checked_sub(1).filter(|&k| joins(a, k) && seconds[row] - seconds[k] <= REACH_S);
        let later =
            Some(b + 1).filter(|&k| k < m.len() && joins(b, k) && seconds[k] - seconds[row] <= REACH_S);
        match (earlier, later) {
            (Some(k), Some(l)) if seconds[row] - seconds[k] > seconds[l] - seconds[row] => b = l,
            (Some(k), _) => a = k,
            (None, Some(l)) => b = l,
            (None, None) => return None,
        }
    }
    let n = (b - a + 1) as f64;
    let middle = seconds[a..=b].iter().sum::<f64>() / n;
    let slope = |v: &[f64]| {
        let (mut sum, mut weight) = (0.0, 0.0);
        for i in a..=b {
            let dt = seconds[i] - middle;
            sum += dt * (v[i] - v[row]);
            weight += dt * dt;
        }
        sum / weight
    };
    let (vx, vy) = (slope(&m.x), slope(&m.y));
    let speed = vx.hypot(vy);
    (speed.is_finite() && speed > 0.0).then(|| (vy.atan2(vx), speed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn seconds(n: usize) -> Vec<f64> {
        (0..n).map(|i| i as f64 / 10.0).collect()
    }

    fn along(places: impl Iterator<Item = (f64, f64)>) -> Motion {
        let (x, y): (Vec<f64>, Vec<f64>) = places.unzip();
        let n = x.len();
        Motion { x, y, ..Motion::unknown(n) }
    }

    /// A quarter of a circle of 10 m to the left at 5 m/s after 2 s straight on: the heading is the tangent.
    #[test]
    fn a_vehicle_heads_along_its_path() {
        let place = |i: usize| {
            let s = i as f64 / 10.0 * 5.0 - 10.0;
            if s < 0.0 { (s, 0.0) } else { (10.0 * (s / 10.0).sin(), 10.0 - 10.0 * (s / 10.0).cos()) }
        };
        let m = along((0..50).map(place));
        let heading = fill(&m, &seconds(50)).unwrap();
        for (i, h) in heading.iter().enumerate() {
            let s = i as f64 / 10.0 * 5.0 - 10.0;
            let want = (s / 10.0).max(0.0);
            // At the last row the line is that of the 3.5 m before, whose middle is 1.75 m back: 0.175 rad.
            let most = if i > 46 { 0.176 } else { 0.04 };
            assert!(wrap(h - want).abs() < most, "row {i}: {h} for {want}");
        }
    }

    /// Stands for 3 s, drives north, stands: the heading is north throughout. Who never moves has none.
    #[test]
    fn who_stands_heads_where_it_drives() {
        let y = |i: usize| (i as f64 - 30.0).clamp(0.0, 40.0) * 0.8;
        let m = along((0..120).map(|i| (5.0, y(i))));
        let heading = fill(&m, &seconds(120)).unwrap();
        assert!(heading.iter().all(|h| (h - FRAC_PI_2).abs() < 1e-9), "{heading:?}");
        assert!(fill(&along((0..50).map(|_| (5.0, 3.0))), &seconds(50)).is_none());
        // Noise of 0.3 m on who stands is no way.
        let noisy = along((0..50).map(|i| (0.3 * (i as f64 * 1.7).sin(), 0.3 * (i as f64 * 2.3).cos())));
        assert!(fill(&noisy, &seconds(50)).is_none());
    }

    /// A car whose heading is stated (east) until it backs out to the west at 2 m/s; one that states a negative speed.
    #[test]
    fn in_reverse_a_vehicle_heads_away_from_its_way() {
        let mut m = along((0..60).map(|i| (-0.2 * (i as f64 - 20.0).max(0.0), 0.0)));
        m.heading[..20].fill(0.0);
        let heading = fill(&m, &seconds(60)).unwrap();
        assert!(heading.iter().all(|h| h.abs() < 1e-9), "{heading:?}");
        let mut m = along((0..60).map(|i| (-0.2 * i as f64, 0.0)));
        m.forward = vec![-2.0; 60];
        assert!(fill(&m, &seconds(60)).unwrap().iter().all(|h| h.abs() < 1e-9));
        // At 10 m/s nobody reverses, and a stated heading that says so is none.
        let mut m = along((0..60).map(|i| (-(i as f64), 0.0)));
        m.heading[0] = 0.0;
        assert!(fill(&m, &seconds(60)).unwrap().iter().all(|h| (h.abs() - PI).abs() < 1e-9));
    }

    #[test]
    fn a_short_gap_is_turned_through_evenly_and_complete_headings_stay() {
        let mut m = along((0..10).map(|i| (0.5 * i as f64, 0.0)));
        m.heading = vec![3.0, f64::NAN, f64::NAN, -3.0, -3.0, -3.0, -3.0, -3.0, -3.0, -3.0];
        let step = (2.0 * PI - 6.0) / 3.0;
        let heading = fill(&m, &seconds(10)).unwrap();
        assert!((heading[1] - (3.0 + step)).abs() < 1e-9, "{heading:?}");
        assert!((wrap(heading[2] - (3.0 + 2.0 * step))).abs() < 1e-9, "{heading:?}");
        m.heading = vec![0.0; 10];
        assert!(fill(&m, &seconds(10)).is_none());
    }
}
