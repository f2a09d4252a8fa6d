//! Objects as a log gives them at its own times, brought to frames at 10 Hz: what the adapters of sampled logs share.
//!
//! A log at 10 Hz is taken as it is. Any other rate is brought to frames every 0.1 s from the log's first time:
//! positions, sizes and velocities linearly between the two samples around the frame, headings the shorter way round.
//! Nothing is filled over more than the given gap; outside its samples an object is absent.

use crate::assemble::angles::{unwrapped, wrap_angle};
use crate::assemble::plausibility::forget_impossible;
use crate::assemble::resample::{lags, linear};
use whyroad_model::scene::{FRAME_RATE_HZ, Motion, Track};
use whyroad_model::{Nanos, ObjectClass};

/// A median step within this of 0.1 s is 10 Hz, s.
const TOLERANCE_S: f64 = 0.01;

/// Frame times, s on the log's clock, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Frames {
    pub seconds: Vec<f64>,
    /// Median step of the log, s; NaN with fewer than two times.
    pub native_step_s: f64,
}

impl Frames {
    /// Frames of a log with these times (ascending).
    pub fn of(times: &[f64]) -> Self {
        let mut steps: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        let native_step_s = steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN);
        let as_is = native_step_s.is_nan() || (native_step_s - 1.0 / FRAME_RATE_HZ).abs() <= TOLERANCE_S;
        let seconds = if as_is { times.to_vec() } else { every_tenth(times) };
        Self { seconds, native_step_s }
    }

    /// True when the frames are not the log's own times.
    pub fn resampled(&self) -> bool {
        (self.native_step_s - 1.0 / FRAME_RATE_HZ).abs() > TOLERANCE_S
    }
}

/// Every 0.1 s from the first time up to the last.
pub(crate) fn every_tenth(times: &[f64]) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else { return Vec::new() };
    // The last time has a frame when it falls on the grid but for rounding.
    let count = ((last - first) * FRAME_RATE_HZ + 1e-3).floor() as usize + 1;
    (0..count).map(|i| first + i as f64 / FRAME_RATE_HZ).collect()
}

/// One object at its own times; every vector has one value per sample, NaN is unknown.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sampled {
    /// s on the log's clock, strictly ascending.
    pub times: Vec<f64>,
    /// Box center, m.
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    /// rad.
    pub heading: Vec<f64>,
    /// Over ground, m/s. NaN where the log has no velocities.
    pub vx: Vec<f64>,
    pub vy: Vec<f64>,
    /// Along the heading, m/s, where the log states a speed and no velocity vector; NaN otherwise.
    pub forward: Vec<f64>,
    /// m.
    pub length: Vec<f64>,
    pub width: Vec<f64>,
    pub height: Vec<f64>,
    /// Lidar points in the box.
    pub points: Vec<f64>,
}

/// One sample of an object, for [`Sampled::push`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub time: f64,
    pub position: [f64; 3],
    pub heading: f64,
    pub velocity: [f64; 2],
    /// Length, width, height, m; what is not above zero is unknown.
    pub size: [f64; 3],
    pub points: f64,
    /// Speed along the heading, m/s.
    pub forward: f64,
}

impl Sample {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self {
        time: f64::NAN,
        position: [f64::NAN; 3],
        heading: f64::NAN,
        velocity: [f64::NAN; 2],
        size: [f64::NAN; 3],
        points: f64::NAN,
        forward: f64::NAN,
    };
}

impl Sampled {
    pub fn push(&mut self, s: Sample) {
        let known = |v: f64| if v > 0.0 { v } else { f64::NAN };
        self.times.push(s.time);
        for (list, value) in [
            (&mut self.x, s.position[0]),
            (&mut self.y, s.position[1]),
            (&mut self.z, s.position[2]),
            (&mut self.heading, s.heading),
            (&mut self.vx, s.velocity[0]),
            (&mut self.vy, s.velocity[1]),
            (&mut self.length, known(s.size[0])),
            (&mut self.width, known(s.size[1])),
            (&mut self.height, known(s.size[2])),
            (&mut self.points, s.points),
            (&mut self.forward, s.forward),
        ] {
            list.push(value);
        }
    }

    /// Leaves only these samples, in this order.
    pub fn keep_rows(&mut self, rows: &[usize]) {
        for list in [
            &mut self.times,
            &mut self.x,
            &mut self.y,
            &mut self.z,
            &mut self.heading,
            &mut self.vx,
            &mut self.vy,
            &mut self.forward,
            &mut self.length,
            &mut self.width,
            &mut self.height,
            &mut self.points,
        ] {
            *list = rows.iter().map(|&i| list[i]).collect();
        }
    }

    /// Motion at each of the frames; unknown where the object is absent.
    pub fn motion_at(&self, frames: &[f64], max_gap_s: f64) -> Motion {
        let at = |v: &[f64]| linear(&self.times, v, frames, max_gap_s);
        let heading = at(&unwrapped(&self.heading)).into_iter().map(wrap_angle).collect::<Vec<_>>();
        let (x, y) = (at(&self.x), at(&self.y));
        let (vx, vy) = (at(&self.vx), at(&self.vy));
        let forward = if self.forward.iter().any(|v| v.is_finite()) { at(&self.forward) } else { Vec::new() };
        Motion { z: at(&self.z), x, y, heading, vx, vy, forward, ..Motion::unknown(frames.len()) }
    }

    /// How much later than each frame the latest measurement is on which the motion at it rests; see [`lags`].
    pub fn lags(&self, frames: &[f64]) -> Vec<Nanos> {
        lags(&self.times, frames)
    }

    /// The object as a track: rows for the frames in which it is present. Also the number of rows with an impossible
    /// speed.
    pub fn track_at(
        &self,
        id: &str,
        class: ObjectClass,
        source_class: &str,
        frames: &[f64],
        max_gap_s: f64,
    ) -> (Track, usize) {
        let x = linear(&self.times, &self.x, frames, max_gap_s);
        let there: Vec<usize> = (0..frames.len()).filter(|&i| x[i].is_finite()).collect();
        // Only the frames in which it is present go into the fits, so that the cost of an object is proportional to its
        // length.
        let own: Vec<f64> = there.iter().map(|&i| frames[i]).collect();
        let mut motion = self.motion_at(&own, max_gap_s);
        let impossible = forget_impossible(class, &own, &mut motion);
        let at = |v: &[f64]| linear(&self.times, v, &own, max_gap_s);
        let track = Track {
            id: id.into(),
            class,
            source_class: source_class.to_owned(),
            frames: there.iter().map(|&i| i as u32).collect(),
            motion,
            length_m: at(&self.length),
            width_m: at(&self.width),
            height_m: at(&self.height),
            interior_points: at(&self.points),
            known_at: self.lags(&own),
            ..Track::default()
        };
        (track, impossible)
    }
}

/// A track whose rows are at other frames, `seconds`, brought to `frames`; nothing is filled over more than
/// `max_gap_s`. A class is stated from the first frame after the row that states it.
pub(crate) fn resample_track(track: &Track, seconds: &[f64], frames: &[f64], max_gap_s: f64) -> Track {
    let m = &track.motion;
    let mut sampled = Sampled::default();
    for (i, &frame) in track.frames.iter().enumerate() {
        sampled.push(Sample {
            time: seconds[frame as usize],
            position: [m.x[i], m.y[i], m.z[i]],
            heading: m.heading[i],
            velocity: [m.vx[i], m.vy[i]],
            size: [track.length_m[i], track.width_m[i], track.height_m[i]],
            points: track.interior_points[i],
            forward: m.forward.get(i).copied().unwrap_or(f64::NAN),
        });
    }
    // Impossible speeds were found, and reported, at the log's own times.
    let mut out = sampled.track_at(&track.id.0, track.class, &track.source_class, frames, max_gap_s).0;
    if !track.class_changes.is_empty() {
        let row_at = |t: f64| sampled.times.partition_point(|s| *s <= t + 1e-6).saturating_sub(1);
        let stated: Vec<_> = out.frames.iter().map(|&f| track.class_at(row_at(frames[f as usize]))).collect();
        out.state_classes(stated);
        (out.class, out.source_class) = (track.class, track.source_class.clone());
    }
    out
}

/// The middle one of the known values; NaN when none is known.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    known.sort_by(f64::total_cmp);
    known.get(known.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, x: f64, heading: f64) -> Sample {
        Sample {
            time,
            position: [x, 0.0, 0.0],
            heading,
            velocity: [f64::NAN; 2],
            size: [4.0, 2.0, 0.0],
            ..Sample::UNKNOWN
        }
    }

    #[test]
    fn a_log_at_ten_hertz_keeps_its_own_times_and_any_other_gets_tenths() {
        let own = [0.0, 0.1001, 0.2, 0.31];
        assert_eq!(Frames::of(&own).seconds, own);
        let slow = Frames::of(&[10.0, 10.5, 11.0]);
        assert!(slow.resampled() && slow.seconds.len() == 11 && (slow.seconds[10] - 11.0).abs() < 1e-9);
    }

    #[test]
    fn half_way_between_two_samples_and_not_over_a_gap() {
        let mut s = Sampled::default();
        // 10 m/s along x, turning through pi; then a hole of a second.
        for sample in [at(0.0, 0.0, 3.0), at(0.5, 5.0, -3.0), at(1.5, 15.0, -3.0)] {
            s.push(sample);
        }
        let frames: Vec<f64> = (0..16).map(|i| f64::from(i) / 10.0).collect();
        let (track, _) = s.track_at("a", ObjectClass::Car, "car", &frames, 0.6);
        assert_eq!(track.frames, [0, 1, 2, 3, 4, 5, 15]);
        assert!((track.motion.x[2] - 2.0).abs() < 1e-9 && track.motion.vx[2].is_nan(), "nothing is derived");
        // From 3.0 to -3.0 over pi is 0.283 rad; at two fifths of the way it is 3.113.
        assert!((track.motion.heading[2] - (3.0 + 0.4 * (std::f64::consts::TAU - 6.0))).abs() < 1e-9);
        assert!(track.height_m[0].is_nan() && (track.length_m[0] - 4.0).abs() < 1e-12);
    }
}
