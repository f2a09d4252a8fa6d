//! A thumbnail of a task's keyframe for lists: the road, the objects, the ego. It shows one moment of the drive and
//! nothing after it. Drawn once, with the task's draft.

use crate::problem::Answer;
use crate::store::Tx;
use crate::values;
use std::fmt::Write as _;
use whyroad_model::scene::Track;
use whyroad_model::{Drive, Nanos, TrackId};

/// Half the length and width of the shown area, m: along and across the ego's heading.
const HALF_M: [f64; 2] = [30.0, 16.5];
/// The shown area extends less behind the ego than ahead: the ego is this far left of the center, m.
const SHIFT_M: f64 = 16.0;
/// Margin around the target, m, and maximum enlargement of the shown area to include it.
const ROOM_M: f64 = 6.0;
const MOST_LARGER: f64 = 3.0;
/// Objects are measured at least this often, s: at 2 Hz in the logs with the lowest rate.
const MEASURED_EVERY_S: f64 = 0.6;
/// Maximum number of objects and of lines: a thumbnail has a few kilobytes.
const MOST_OBJECTS: usize = 40;
const MOST_LINES: usize = 60;

/// The thumbnail of `drive` at `at`, or at the last frame before it at which the ego's pose is known, with the ego
/// driving to the right. The drive is cut at `at`.
pub fn draw(drive: &Drive, at: Nanos, target: Option<&TrackId>) -> String {
    let Some(ego) = &drive.ego else { return String::new() };
    let m = &ego.motion;
    let pose = |frame: usize| {
        let value = |values: &[f64]| values.get(frame).copied().filter(|v| v.is_finite());
        Some((frame, value(&m.x)?, value(&m.y)?, value(&m.heading)?))
    };
    let frames = drive.times.partition_point(|t| *t <= at);
    let Some((frame, x, y, heading)) = (0..frames).rev().find_map(pose) else { return String::new() };
    let (sin, cos) = heading.sin_cos();
    // In the ego's frame, with y pointing down as on a screen.
    let from_ego = |px: f64, py: f64| {
        let (dx, dy) = (px - x, py - y);
        (dx * cos + dy * sin, dx * sin - dy * cos)
    };
    let is_sparse = drive.tracks.iter().any(|track| !track.known_at.is_empty());
    let row_of = |track: &Track| match track.frames.binary_search(&(frame as u32)) {
        Ok(row) => Some(row),
        // Between two measurements, of which the second is later: it is where it was seen last. The target always is;
        // another object of a log that measures all of them frame by frame is gone.
        Err(next) if target == Some(&track.id) => next.checked_sub(1),
        Err(next) if next == track.frames.len() && is_sparse => next.checked_sub(1).filter(|row| {
            let seen = drive.times[track.frames[*row] as usize];
            drive.times[frame].seconds_since(seen) < MEASURED_EVERY_S
        }),
        Err(_) => None,
    };
    let larger = drive.tracks.iter().find(|track| target == Some(&track.id)).and_then(|track| {
        let row = row_of(track)?;
        Some(larger_for(from_ego(*track.motion.x.get(row)?, *track.motion.y.get(row)?)))
    });
    let larger = larger.unwrap_or(1.0);
    let (half, shift) = (HALF_M.map(|m| m * larger), SHIFT_M * larger);
    let place = |px: f64, py: f64| {
        let (dx, dy) = from_ego(px, py);
        (dx - shift, dy)
    };
    let inside = |(px, py): (f64, f64), room: f64| px.abs() <= half[0] + room && py.abs() <= half[1] + room;
    let crosses = |a: (f64, f64), b: (f64, f64)| may_cross(half, a, b);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} {} {} {}\"><rect x=\"-99\" y=\"-99\" width=\"198\" height=\"198\" fill=\"#7d868c\" fill-opacity=\".16\"/>",
        -half[0],
        -half[1],
        2.0 * half[0],
        2.0 * half[1],
    );
    let mut lines = 0;
    for lane in drive.map.iter().flat_map(|map| &map.lanes) {
        // A map without sides has the middle of its lanes.
        let bare = lane.left.is_empty() && lane.right.is_empty();
        for line in if bare { [&lane.center, &lane.right] } else { [&lane.left, &lane.right] } {
            let points: Vec<(f64, f64)> = line.iter().map(|p| place(p.x, p.y)).collect();
            if lines >= MOST_LINES || !points.windows(2).any(|w| crosses(w[0], w[1])) {
                continue;
            }
            lines += 1;
            out.push_str("<polyline fill=\"none\" stroke=\"#7d868c\" stroke-width=\".5\" points=\"");
            let near = |i: usize| points.get(i).is_some_and(|b| i > 0 && crosses(points[i - 1], *b));
            for (_, (px, py)) in points.iter().enumerate().filter(|(i, _)| near(*i) || near(i + 1)) {
                let _ = write!(out, "{px:.1},{py:.1} ");
            }
            out.push_str("\"/>");
        }
    }
    let mut objects = 0;
    for track in &drive.tracks {
        let Some(row) = row_of(track) else { continue };
        let value =
            |values: &[f64], usual: f64| values.get(row).copied().filter(|v| v.is_finite()).unwrap_or(usual);
        let (tx, ty) = (value(&track.motion.x, f64::NAN), value(&track.motion.y, f64::NAN));
        if !(tx.is_finite() && inside(place(tx, ty), 3.0)) || objects >= MOST_OBJECTS {
            continue;
        }
        objects += 1;
        let is_target = target == Some(&track.id);
        let color = if is_target {
            "#d9480f"
        } else if track.class.is_vru() {
            "#c2462f"
        } else if track.class.is_vehicle() {
            "#4a8a5c"
        } else {
            "#7a8288"
        };
        let turn = heading - value(&track.motion.heading, heading);
        let size = (value(&track.length_m, 1.0).max(0.8), value(&track.width_m, 0.8).max(0.8));
        boxed(&mut out, place(tx, ty), turn, size, color);
        if is_target {
            let (px, py) = place(tx, ty);
            let _ = write!(
                out,
                "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"{:.1}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{larger:.1}\"/>",
                4.5 * larger
            );
        }
    }
    boxed(&mut out, (-shift, 0.0), 0.0, (ego.length_m.max(1.0), ego.width_m.max(1.0)), "#2f7fd0");
    out.push_str("</svg>");
    out
}

/// Enlargement of the shown area for a target `ahead` and `aside` of the ego, m; 1 for an unknown one.
fn larger_for((ahead, aside): (f64, f64)) -> f64 {
    let front = (ahead + ROOM_M) / (HALF_M[0] + SHIFT_M);
    let back = (ROOM_M - ahead) / (HALF_M[0] - SHIFT_M);
    let side = (aside.abs() + ROOM_M) / HALF_M[1];
    // `max` ignores NaN.
    [front, back, side].into_iter().fold(1.0, f64::max).min(MOST_LARGER)
}

/// True when a part of a line may be in the thumbnail with the half size `half`: its bounding box is.
fn may_cross(half: [f64; 2], a: (f64, f64), b: (f64, f64)) -> bool {
    a.0.min(b.0) <= half[0] && a.0.max(b.0) >= -half[0] && a.1.min(b.1) <= half[1] && a.1.max(b.1) >= -half[1]
}

fn boxed(out: &mut String, at: (f64, f64), turn: f64, size: (f64, f64), color: &str) {
    let _ = write!(
        out,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\" transform=\"rotate({:.0} {:.1} {:.1})\"/>",
        at.0 - size.0 / 2.0,
        at.1 - size.1 / 2.0,
        size.0,
        size.1,
        turn.to_degrees(),
        at.0,
        at.1,
    );
}

/// Stores the thumbnail of a task; does nothing if there is none.
pub fn put(tx: &mut dyn Tx, task: &str, svg: &str) -> Answer<()> {
    if !svg.is_empty() {
        tx.run(
            "INSERT INTO thumbnails (task_id, svg) VALUES ($1, $2) ON CONFLICT (task_id) DO NOTHING",
            values![task, svg],
        )?;
    }
    Ok(())
}

/// The thumbnail of a task.
pub fn get(tx: &mut dyn Tx, task: &str) -> Answer<Option<String>> {
    tx.row("SELECT svg FROM thumbnails WHERE task_id = $1", values![task])?.map(|r| r.text("svg")).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use whyroad_model::road_map::{Lane, Point3, RoadMap};
    use whyroad_model::scene::{Ego, Motion};

    #[test]
    fn a_target_far_ahead_is_inside() {
        assert_eq!(larger_for((20.0, 3.0)), 1.0);
        // 49.5 m ahead: the shown area extends to 46 m ahead of the ego, and (49.5 + 6) / 46 times as far after
        // enlargement.
        assert!((larger_for((49.5, 6.3)) - 55.5 / 46.0).abs() < 1e-9);
        assert!((larger_for((0.0, -18.0)) - 24.0 / 16.5).abs() < 1e-9);
        assert_eq!(larger_for((400.0, 0.0)), MOST_LARGER);
        assert_eq!(larger_for((f64::NAN, f64::NAN)), 1.0);
    }

    /// Ten frames a second of objects that are measured twice a second (nuScenes): at the keyframe, 0.4 s after the
    /// last measurement, they are where they were then. The map has centers of lanes only.
    #[test]
    fn objects_that_are_measured_at_a_lower_rate_are_shown() {
        let time = |frame: i64| Nanos(frame * 100_000_000);
        let line = |x: f64, y: f64| Motion {
            x: vec![x; 15],
            y: vec![y; 15],
            heading: vec![0.0; 15],
            ..Motion::unknown(15)
        };
        let track = |id: &str, known_at: Vec<Nanos>| Track {
            id: id.into(),
            frames: (0..15).collect(),
            motion: line(12.0, 3.0),
            length_m: vec![4.0; 15],
            width_m: vec![2.0; 15],
            known_at,
            ..Track::default()
        };
        let lane = Lane {
            center: vec![Point3::default(), Point3 { x: 20.0, ..Point3::default() }],
            ..Lane::default()
        };
        let shown = |known_at: Vec<Nanos>, gone: u32| {
            let mut object = track("a", known_at);
            object.frames.truncate(gone as usize);
            let drive = Drive {
                ego: Some(Ego { motion: line(0.0, 0.0), ..Ego::default() }),
                times: (0..15).map(time).collect(),
                tracks: vec![object],
                map: Some(RoadMap { lanes: vec![lane.clone()], ..RoadMap::default() }),
                ..Drive::default()
            };
            let svg = draw(&drive.until(time(9)), time(9), None);
            // The background, the ego and the object.
            (svg.matches("<rect").count(), svg.matches("<polyline").count())
        };
        let measured = || (0..15i64).map(|frame| time((frame + 4) / 5 * 5)).collect::<Vec<_>>();
        assert_eq!(shown(measured(), 15), (3, 1));
        // Measured in each frame, and not seen any more for 0.4 s.
        assert_eq!(shown(Vec::new(), 6), (2, 1));
    }

    #[test]
    fn a_drive_without_an_ego_has_no_picture() {
        let drive = Drive { ego: None, times: vec![Nanos(0)], ..Drive::default() };
        assert_eq!(draw(&drive, Nanos(0), None), "");
    }
}
