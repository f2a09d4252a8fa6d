//! Logs that were annotated at key frames and interpolated by a converter (nuScenes at 2 Hz in ScenarioNet pickles):
//! between two key frames every object moves in a straight line, and the stated velocity is the slope of that line.
//! Only the key frames were measured; the rest is taken out here, so that the estimator does not mistake corners of the
//! interpolation for braking. Not here: bringing samples to frames (`frames.rs`).

use crate::assemble::frames::Sampled;

/// A second difference of positions within this is a straight line, m: 0.1 m/s2 at 10 Hz.
const STRAIGHT_M: f64 = 1e-3;
/// Steps between key frames that are looked for, rows.
const STEPS: std::ops::RangeInclusive<usize> = 2..=20;
/// Fewer corners are not evidence.
const LEAST_CORNERS: usize = 30;
/// Share of the objects whose corners must all be key frames; others, as the recording car, were not interpolated.
const OBJECTS: f64 = 0.8;

/// Rows of a scenario that were measured: every `step`, from `phase` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct KeyFrames {
    pub step: usize,
    pub phase: usize,
}

impl KeyFrames {
    /// Found in the corners of all objects; `None` when these are anywhere. `times` are those of the scenario's rows.
    pub fn find<'a>(objects: impl Iterator<Item = &'a Sampled>, times: &[f64]) -> Option<Self> {
        let mut by_object: Vec<Vec<usize>> = objects.map(|o| corners(o, times)).collect();
        by_object.retain(|rows| !rows.is_empty());
        let least = (OBJECTS * by_object.len() as f64).ceil() as usize;
        STEPS.rev().find_map(|step| {
            let fits = |phase: usize| {
                let fitting = by_object.iter().filter(|rows| rows.iter().all(|r| r % step == phase));
                fitting.fold((0, 0), |(objects, corners), rows| (objects + 1, corners + rows.len()))
            };
            let (phase, (objects, corners)) =
                (0..step).map(|phase| (phase, fits(phase))).max_by_key(|(_, fit)| *fit)?;
            (objects >= least && corners >= LEAST_CORNERS).then_some(Self { step, phase })
        })
    }

    /// Keeps the measured rows of an object, and its first and last one; velocities are the slopes of the interpolation
    /// and are dropped. An object with a corner elsewhere was not interpolated, and is left as it is.
    pub fn keep(self, object: &mut Sampled, times: &[f64]) -> bool {
        if corners(object, times).iter().any(|r| r % self.step != self.phase) {
            return false;
        }
        let last = object.times.len().saturating_sub(1);
        let kept = |i: usize| i == 0 || i == last || row_of(object.times[i], times) % self.step == self.phase;
        let kept: Vec<usize> = (0..object.times.len()).filter(|&i| kept(i)).collect();
        object.keep_rows(&kept);
        object.vx.fill(f64::NAN);
        object.vy.fill(f64::NAN);
        true
    }
}

fn row_of(time: f64, times: &[f64]) -> usize {
    times.partition_point(|t| *t < time)
}

/// Rows of the scenario at which an object's path has a corner.
fn corners(object: &Sampled, times: &[f64]) -> Vec<usize> {
    let row: Vec<usize> = object.times.iter().map(|&t| row_of(t, times)).collect();
    let bend = |v: &[f64], i: usize| v[i + 1] - 2.0 * v[i] + v[i - 1];
    (1..row.len().saturating_sub(1))
        .filter(|&i| row[i + 1] - row[i - 1] == 2)
        .filter(|&i| bend(&object.x, i).hypot(bend(&object.y, i)) > STRAIGHT_M)
        .map(|i| row[i])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::frames::Sample;

    fn times() -> Vec<f64> {
        (0..101).map(|i| f64::from(i) * 0.1).collect()
    }

    /// Braking at 1 m/s2 from 15 m/s, seen every `step` rows from `phase` and interpolated between.
    fn braking(step: usize, phase: usize) -> Sampled {
        let place = |row: f64| 1.5 * row - 0.005 * row * row;
        let mut out = Sampled::default();
        for (row, time) in times().into_iter().enumerate() {
            let behind = (row + step - phase) % step;
            let (share, before) = (behind as f64 / step as f64, row as f64 - behind as f64);
            let (a, b) = (place(before), place(before + step as f64));
            out.push(Sample {
                time,
                position: [a + share * (b - a), 2.0, 0.0],
                heading: 0.0,
                velocity: [(b - a) / (0.1 * step as f64), 0.0],
                ..Sample::UNKNOWN
            });
        }
        out
    }

    #[test]
    fn key_frames_are_found_and_what_lies_between_is_taken_out() {
        let mut objects = [braking(5, 0), braking(5, 0), braking(5, 0)];
        let found = KeyFrames::find(objects.iter(), &times());
        assert_eq!(found, Some(KeyFrames { step: 5, phase: 0 }));
        assert!(found.is_some_and(|k| k.keep(&mut objects[0], &times())));
        let kept = &objects[0];
        assert_eq!(kept.times.len(), 21, "every fifth of 101 rows");
        assert!((kept.times[1] - 0.5).abs() < 1e-9 && kept.vx.iter().all(|v| v.is_nan()));
        // 15 m/s for 0.5 s less 0.5 x 1 m/s2 x 0.25 s2.
        assert!((kept.x[1] - 7.375).abs() < 1e-9);
    }

    #[test]
    fn a_scenario_cut_between_key_frames_has_another_phase() {
        let objects = [braking(5, 3), braking(5, 3), braking(5, 3)];
        assert_eq!(KeyFrames::find(objects.iter(), &times()), Some(KeyFrames { step: 5, phase: 3 }));
    }

    #[test]
    fn a_log_that_was_measured_in_every_row_has_none() {
        let objects = [braking(1, 0), braking(1, 0), braking(1, 0)];
        assert_eq!(KeyFrames::find(objects.iter(), &times()), None);
        // The recording car as one of many objects.
        let mut mixed = vec![braking(1, 0)];
        mixed.extend((0..5).map(|_| braking(5, 0)));
        assert_eq!(KeyFrames::find(mixed.iter(), &times()), Some(KeyFrames { step: 5, phase: 0 }));
        let mut ego = braking(1, 0);
        assert!(!KeyFrames { step: 5, phase: 0 }.keep(&mut ego, &times()), "it is not on the grid");
        assert_eq!(ego.times.len(), 101);
    }
}
