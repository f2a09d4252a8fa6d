//! `egomotion`: poses of the rig (rear axle, on the ground) in the rig's own frame at the clip's start, about 100 Hz.
//! Times are microseconds from the clip's start; the first ones may be negative.

use crate::assemble::resample::{MAX_GAP_S, lags, linear};
use crate::assemble::se3::{self, Se3, unit};
use crate::encodings::columns::Columns;
use crate::report::RowCount;
use whyroad_model::Nanos;
use whyroad_model::scene::Motion;

/// Step of the frames, us.
pub(super) const FRAME_US: i64 = 100_000;
/// Times beyond this (11 days) are not those of a clip, us.
const MAX_TIME_US: i64 = 1_000_000_000_000;
/// Velocities that differ from the positions' by more than this in the median are not used, m/s.
const MAX_VELOCITY_ERROR_MPS: f64 = 1.0;

/// Poses by ascending time.
pub(super) struct PoseTrack {
    /// us.
    pub times: Vec<i64>,
    poses: Vec<Se3>,
    /// Velocity of the rig's origin in the frame of the poses, m/s; empty where the table has none.
    velocities: Vec<[f64; 2]>,
}

/// Reads the poses; the counts say what was lost.
pub(super) fn read(table: &Columns) -> Result<(PoseTrack, RowCount), String> {
    let times = table.integers("timestamp")?;
    let [qw, qx, qy, qz, x, y, z] = ["qw", "qx", "qy", "qz", "x", "y", "z"].map(|name| table.numbers(name));
    let (qw, qx, qy, qz, x, y, z) = (qw?, qx?, qy?, qz?, x?, y?, z?);
    let has_velocity = table.has("vx") && table.has("vy");
    let velocity = if has_velocity { Some((table.numbers("vx")?, table.numbers("vy")?)) } else { None };
    let mut count = RowCount { read: times.len(), ..RowCount::new("egomotion") };
    let mut rows = Vec::with_capacity(times.len());
    for (i, time) in times.iter().enumerate() {
        let position = [x[i], y[i], z[i]];
        let plausible = time.filter(|t| (-MAX_TIME_US..=MAX_TIME_US).contains(t));
        match (plausible, unit([qw[i], qx[i], qy[i], qz[i]])) {
            (Some(time), Some(q)) if position.iter().all(|v| v.is_finite()) => {
                let v = velocity.as_ref().map_or([f64::NAN; 2], |(vx, vy)| [vx[i], vy[i]]);
                rows.push((time, Se3 { q, t: position }, v));
            }
            _ => count.drop_rows("invalid", 1),
        }
    }
    rows.sort_by_key(|r| r.0);
    let before = rows.len();
    rows.dedup_by_key(|r| r.0);
    count.drop_rows("duplicate", before - rows.len());
    count.keep("pose", rows.len());
    let velocities = if has_velocity { rows.iter().map(|r| r.2).collect() } else { Vec::new() };
    let (times, poses) = rows.into_iter().map(|(time, pose, _)| (time, pose)).unzip();
    Ok((PoseTrack { times, poses, velocities }, count))
}

impl PoseTrack {
    /// Of a vehicle that stands at these times (us).
    pub fn standing(times: &[i64]) -> Self {
        let pose = Se3 { q: [1.0, 0.0, 0.0, 0.0], t: [0.0; 3] };
        Self { times: times.to_vec(), poses: vec![pose; times.len()], velocities: Vec::new() }
    }

    /// The pose at `time` (us): the log's own, or between its two neighbors. `None` outside the log and inside a gap.
    pub fn at(&self, time: i64) -> Option<Se3> {
        let next = self.times.partition_point(|&t| t < time);
        if self.times.get(next) == Some(&time) {
            return Some(self.poses[next]);
        }
        let before = next.checked_sub(1)?;
        let (t0, t1) = (self.times[before], *self.times.get(next)?);
        let gap_us = t1.saturating_sub(t0) as f64;
        (gap_us <= MAX_GAP_S * 1e6)
            .then(|| self.poses[before].between(&self.poses[next], time.saturating_sub(t0) as f64 / gap_us))
    }

    /// Frames at whole tenths of a second of the clip's clock, negative ones included, where there is a pose, us.
    pub fn frames(&self) -> Vec<i64> {
        let (Some(&first), Some(&last)) = (self.times.first(), self.times.last()) else { return Vec::new() };
        let tenth = -(-first).div_euclid(FRAME_US);
        (tenth..=last.div_euclid(FRAME_US)).map(|i| i * FRAME_US).filter(|&t| self.at(t).is_some()).collect()
    }

    /// How much later than each frame (us) the latest pose is on which its motion rests.
    pub fn lags(&self, frames: &[i64]) -> Vec<Nanos> {
        let seconds = |times: &[i64]| times.iter().map(|&t| t as f64 / 1e6).collect::<Vec<_>>();
        lags(&seconds(&self.times), &seconds(frames))
    }

    /// Motion of the point `centre` (in the rig, m) at the frames (us), which are those of [`PoseTrack::frames`]. False
    /// when the table's velocities contradict its positions; they are then unknown.
    pub fn motion(&self, frames: &[i64], center: [f64; 3]) -> (Motion, bool) {
        let mut motion = Motion::unknown(frames.len());
        let mut axle = vec![[f64::NAN; 2]; frames.len()];
        for (i, &time) in frames.iter().enumerate() {
            let Some(pose) = self.at(time) else { continue };
            let p = pose.apply(center);
            (motion.x[i], motion.y[i], motion.z[i]) = (p[0], p[1], p[2]);
            axle[i] = [pose.t[0], pose.t[1]];
            motion.heading[i] = se3::heading(pose.q);
        }
        if self.velocities.is_empty() {
            return (motion, true);
        }
        let seconds: Vec<f64> = frames.iter().map(|&t| t as f64 / 1e6).collect();
        let times: Vec<f64> = self.times.iter().map(|&t| t as f64 / 1e6).collect();
        let axis = |k: usize| -> Vec<f64> {
            let own: Vec<f64> = self.velocities.iter().map(|v| v[k]).collect();
            linear(&times, &own, &seconds, MAX_GAP_S)
        };
        let (vx, vy) = (axis(0), axis(1));
        let mut errors: Vec<f64> = (1..frames.len().saturating_sub(1))
            .map(|i| {
                let dt = seconds[i + 1] - seconds[i - 1];
                let step = |k: usize| (axle[i + 1][k] - axle[i - 1][k]) / dt;
                (vx[i] - step(0)).hypot(vy[i] - step(1))
            })
            .filter(|e| e.is_finite())
            .collect();
        errors.sort_by(f64::total_cmp);
        let agree = errors.get(errors.len() / 2).is_some_and(|e| *e <= MAX_VELOCITY_ERROR_MPS);
        if agree {
            // The table's velocity is the rear axle's: a turning car's box center also goes sideways, but as fast along
            // the heading.
            let along = |i: usize| {
                let (s, c) = motion.heading[i].sin_cos();
                vx[i] * c + vy[i] * s
            };
            motion.forward = (0..frames.len()).map(along).collect();
        }
        (motion, agree || errors.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
    use std::sync::Arc;

    fn track(times: &[i64], speed_mps: f64, stated: f64) -> PoseTrack {
        let pose = |&t: &i64| Se3 { q: [1.0, 0.0, 0.0, 0.0], t: [speed_mps * t as f64 / 1e6, 0.0, 0.0] };
        PoseTrack {
            times: times.to_vec(),
            poses: times.iter().map(pose).collect(),
            velocities: times.iter().map(|_| [stated, 0.0]).collect(),
        }
    }

    #[test]
    fn frames_are_whole_tenths_also_before_the_start_and_never_in_a_gap() {
        let times: Vec<i64> = (-23..=30).map(|i| i * 10_000).chain([900_000]).collect();
        assert_eq!(
            track(&times, 5.0, 5.0).frames(),
            [-200_000, -100_000, 0, 100_000, 200_000, 300_000, 900_000]
        );
    }

    #[test]
    fn velocities_that_contradict_the_positions_are_not_used() {
        let times: Vec<i64> = (0..=100).map(|i| i * 10_000).collect();
        for (stated, agree) in [(5.2, true), (9.0, false)] {
            let track = track(&times, 5.0, stated);
            let (motion, same) = track.motion(&track.frames(), [1.5, 0.0, 0.0]);
            assert_eq!(same, agree);
            assert_eq!(motion.forward.get(3).map(|v| (v * 1e6).round() / 1e6), agree.then_some(stated));
            assert!((motion.x[0] - 1.5).abs() < 1e-12);
        }
    }

    /// The least 64-bit integer has no absolute value.
    #[test]
    fn the_least_and_the_greatest_time_are_dropped_and_the_rest_is_kept() {
        let times: ArrayRef = Arc::new(Int64Array::from(vec![i64::MIN, 0, 100_000, i64::MAX]));
        let column = |value: f64| -> ArrayRef { Arc::new(Float64Array::from(vec![value; 4])) };
        let mut columns = vec![("timestamp", times), ("qw", column(1.0))];
        columns.extend(["qx", "qy", "qz", "x", "y", "z"].map(|name| (name, column(0.0))));
        let (track, count) = read(&Columns(vec![RecordBatch::try_from_iter(columns).unwrap()])).unwrap();
        assert_eq!(track.times, [0, 100_000]);
        assert_eq!(
            (count.read, count.kept.get("pose"), count.dropped.get("invalid")),
            (4, Some(&2), Some(&2))
        );
    }
}
