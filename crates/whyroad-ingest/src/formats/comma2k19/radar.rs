//! The car's own radar: returns by slot to tracks in the local frame.

use super::motion::EGO_LENGTH_M;
use super::recording::RadarRow;
use crate::report::RowCount;
use std::collections::BTreeMap;
use whyroad_model::scene::{Motion, Track};
use whyroad_model::{ObjectClass, TrackId};

/// The radar reports each slot 20 times a second; a return is used for a frame at most this far from it, s.
const MAX_OFFSET_S: f64 = 0.05;
/// A slot that was silent for longer holds another target, s.
const MAX_SILENCE_S: f64 = 0.25;

/// Tracks at `frames`, and how the returns were used; `None` without radar.
///
/// Position: the ego's box center, half its length forward, then the return. Velocity: the ego's along its heading plus
/// the relative speed; a radar of this kind does not see sideways motion, so the heading is taken as the ego's (or
/// against it).
pub(super) fn tracks(rows: &[RadarRow], frames: &[f64], ego: &Motion) -> (Vec<Track>, Option<RowCount>) {
    if rows.is_empty() {
        return (Vec::new(), None);
    }
    let mut count = RowCount { read: rows.len(), ..RowCount::new("radar") };
    let mut by_slot: BTreeMap<u32, Vec<&RadarRow>> = BTreeMap::new();
    for row in rows {
        if [row.forward_m, row.left_m, row.relative_speed_mps].iter().all(|v| v.is_finite()) {
            by_slot.entry(row.slot).or_default().push(row);
        } else {
            count.drop_rows("invalid", 1);
        }
    }
    let mut tracks = Vec::new();
    for (slot, rows) in by_slot {
        let mut part = 0;
        let mut start = 0;
        for i in 1..=rows.len() {
            let ends = i == rows.len() || rows[i].is_new || rows[i].time - rows[i - 1].time > MAX_SILENCE_S;
            if ends {
                let track = track(&rows[start..i], format!("radar_{slot}_{part:04}"), frames, ego);
                count.keep("track", track.frames.len());
                count.set_aside("between_frames", i - start - track.frames.len());
                if !track.frames.is_empty() {
                    tracks.push(track);
                }
                part += 1;
                start = i;
            }
        }
    }
    tracks.sort_by(|a, b| a.id.cmp(&b.id));
    (tracks, Some(count))
}

/// One target's rows, the nearest to each frame; each row serves one frame.
fn track(rows: &[&RadarRow], id: String, frames: &[f64], ego: &Motion) -> Track {
    let mut out = Track {
        id: TrackId::from(id),
        class: ObjectClass::Unknown,
        source_class: "radar return".into(),
        ..Track::default()
    };
    let mut used = None;
    for (frame, &t) in frames.iter().enumerate() {
        let next = rows.partition_point(|r| r.time < t);
        let nearest = [next.checked_sub(1), (next < rows.len()).then_some(next)]
            .into_iter()
            .flatten()
            .min_by(|&a, &b| (rows[a].time - t).abs().total_cmp(&(rows[b].time - t).abs()));
        let Some(k) = nearest.filter(|&k| (rows[k].time - t).abs() <= MAX_OFFSET_S && used != Some(k)) else {
            continue;
        };
        if ego.x[frame].is_nan() || ego.heading[frame].is_nan() {
            continue;
        }
        used = Some(k);
        out.frames.push(frame as u32);
        place(rows[k], frame, ego, &mut out.motion);
        for size in [&mut out.length_m, &mut out.width_m, &mut out.height_m] {
            size.push(0.0);
        }
        out.interior_points.push(f64::NAN);
    }
    out
}

fn place(row: &RadarRow, frame: usize, ego: &Motion, out: &mut Motion) {
    let heading = ego.heading[frame];
    let (s, c) = heading.sin_cos();
    let forward = EGO_LENGTH_M / 2.0 + row.forward_m;
    let speed = ego.forward_speed(frame) + row.relative_speed_mps;
    out.x.push(ego.x[frame] + c * forward - s * row.left_m);
    out.y.push(ego.y[frame] + s * forward + c * row.left_m);
    out.z.push(ego.z[frame]);
    out.heading.push(if speed < 0.0 {
        crate::assemble::angles::wrap_angle(heading + std::f64::consts::PI)
    } else {
        heading
    });
    out.vx.push(c * speed);
    out.vy.push(s * speed);
    out.accel.push(f64::NAN);
    out.yaw_rate.push(f64::NAN);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Geometry by hand: the ego stands at (10, 20) facing north, 5 m/s; a return 30 m ahead of the bumper, 2 m to the
    /// left, closing at 1 m/s.
    #[test]
    fn a_return_is_ahead_of_the_bumper_and_left_is_left() {
        let n = 3;
        let ego = Motion {
            x: vec![10.0; n],
            y: vec![20.0; n],
            z: vec![0.0; n],
            heading: vec![std::f64::consts::FRAC_PI_2; n],
            vx: vec![0.0; n],
            vy: vec![5.0; n],
            accel: vec![0.0; n],
            yaw_rate: vec![0.0; n],
            forward: vec![],
        };
        let row = |time, is_new| RadarRow {
            time,
            forward_m: 30.0,
            left_m: 2.0,
            relative_speed_mps: -1.0,
            slot: 7,
            is_new,
        };
        let rows = [row(0.0, false), row(0.05, false), row(0.1, false), row(0.2, true)];
        let (tracks, count) = tracks(&rows, &[0.0, 0.1, 0.2], &ego);
        assert_eq!(tracks.len(), 2, "new_track starts another track");
        let t = &tracks[0];
        assert_eq!(t.frames, [0, 1]);
        assert!(
            (t.motion.x[0] - 8.0).abs() < 1e-9
                && (t.motion.y[0] - (20.0 + EGO_LENGTH_M / 2.0 + 30.0)).abs() < 1e-9
        );
        assert!((t.motion.vy[0] - 4.0).abs() < 1e-9);
        assert!(count.unwrap().adds_up());
    }
}
