//! `city_SE3_egovehicle.feather`: where the rear axle is in the city, about 170 times a second, and in between.

use crate::assemble::resample::MAX_GAP_S;
use crate::assemble::se3::{Se3, unit};
use crate::encodings::columns::Columns;
use crate::report::RowCount;

/// Poses by ascending time.
pub(super) struct PoseTrack {
    times: Vec<i64>,
    poses: Vec<Se3>,
}

/// Reads the poses; the counts say what was lost, the flag whether the file's times ran backwards.
pub(super) fn read(file: &Columns) -> Result<(PoseTrack, RowCount, bool), String> {
    let times = file.integers("timestamp_ns")?;
    let q = [file.numbers("qw")?, file.numbers("qx")?, file.numbers("qy")?, file.numbers("qz")?];
    let t = [file.numbers("tx_m")?, file.numbers("ty_m")?, file.numbers("tz_m")?];
    let mut count = RowCount { read: times.len(), ..RowCount::new("pose") };
    let mut rows: Vec<(i64, Se3)> = Vec::with_capacity(times.len());
    for (i, time) in times.iter().enumerate() {
        let translation = [t[0][i], t[1][i], t[2][i]];
        match (time, unit([q[0][i], q[1][i], q[2][i], q[3][i]])) {
            (Some(time), Some(q)) if translation.iter().all(|v| v.is_finite()) => {
                rows.push((*time, Se3 { q, t: translation }));
            }
            _ => count.drop_rows("invalid", 1),
        }
    }
    let backward = rows.windows(2).any(|w| w[0].0 > w[1].0);
    rows.sort_by_key(|r| r.0);
    let before = rows.len();
    rows.dedup_by_key(|r| r.0);
    count.drop_rows("duplicate", before - rows.len());
    count.keep("pose", rows.len());
    let (times, poses) = rows.into_iter().unzip();
    Ok((PoseTrack { times, poses }, count, backward))
}

impl PoseTrack {
    /// How much later than `time` the pose is on which [`PoseTrack::at`] rests, ns.
    pub fn lag(&self, time: i64) -> i64 {
        let next = self.times.partition_point(|&t| t < time);
        self.times.get(next).map_or(0, |t| t - time)
    }

    /// The pose at `time`: the log's own when it has one at that nanosecond, else between its two neighbors.
    /// `None` outside the log and inside a gap. Neighbors 1 ns apart, which AV2 has, do no harm: nothing is divided by
    /// less.
    pub fn at(&self, time: i64) -> Option<Se3> {
        let next = self.times.partition_point(|&t| t < time);
        if self.times.get(next) == Some(&time) {
            return Some(self.poses[next]);
        }
        let before = next.checked_sub(1)?;
        let (t0, t1) = (self.times[before], *self.times.get(next)?);
        let gap_ns = t1.saturating_sub(t0) as f64;
        if gap_ns > MAX_GAP_S * 1e9 {
            return None;
        }
        Some(self.poses[before].between(&self.poses[next], time.saturating_sub(t0) as f64 / gap_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(times: &[i64]) -> PoseTrack {
        let pose = |&t: &i64| Se3 { q: [1.0, 0.0, 0.0, 0.0], t: [t as f64 * 1e-8, 0.0, 0.0] };
        PoseTrack { times: times.to_vec(), poses: times.iter().map(pose).collect() }
    }

    #[test]
    fn between_two_poses_is_between_them_and_a_gap_is_a_gap() {
        // 10 m/s; a 1 ns near duplicate, then a hole of 0.4 s.
        let p = straight(&[0, 1, 100_000_000, 500_000_000]);
        assert_eq!(p.at(50_000_000).map(|s| (s.t[0] * 1e6).round()), Some(500_000.0));
        assert_eq!(p.at(100_000_000).map(|s| s.t[0]), Some(1.0));
        assert!(p.at(300_000_000).is_none() && p.at(-1).is_none() && p.at(500_000_001).is_none());
    }

    /// The time between them does not fit into 64 bits.
    #[test]
    fn between_the_least_and_the_greatest_time_is_a_gap() {
        let p = straight(&[i64::MIN, i64::MAX]);
        assert!(p.at(0).is_none() && p.at(i64::MIN + 1).is_none());
        assert!(p.at(i64::MIN).is_some() && p.at(i64::MAX).is_some());
    }
}
