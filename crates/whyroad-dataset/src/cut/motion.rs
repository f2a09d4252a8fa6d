//! The ego around the keyframe: a window of the drive, and its pose at regular steps in the frame of the ego at t0.

use crate::pose::{Pose, known, wrap};
use crate::sample::{EgoBox, Trajectory};
use crate::spec::{Cut, Reference};
use whyroad_engine::{MetaActions, States, meta_actions, states};
use whyroad_model::catalog::CategoryValue;
use whyroad_model::scene::{Ego, Motion};
use whyroad_model::{Drive, FrameRange, Nanos};

/// Seconds of the drive before the history that the states may use: an estimator needs some data to settle.
const RUN_UP_S: f64 = 3.0;
/// Steps are interpolated between frames with a pose that are at most this far apart, s.
const LARGEST_GAP_S: f64 = 0.25;
/// A frame this near to a step is taken as it is, s.
const SAME_S: f64 = 0.001;

/// A stretch of a drive around the keyframe, with derived data.
pub(crate) struct Window {
    /// The stretch: without map, lights, context and media.
    pub drive: Drive,
    /// Frame of t0 in it.
    pub t0: usize,
    /// Known at t0.
    pub past: States,
    /// Known afterwards.
    pub whole: States,
    pub pose: Pose,
    /// From the reference point forward to the box center, m.
    pub to_center: f64,
    past_actions: Option<MetaActions>,
    whole_actions: Option<MetaActions>,
}

impl Window {
    /// `None` when the lake has no pose of the ego at `frame`.
    pub fn around(drive: &Drive, frame: usize, cut: &Cut) -> Option<Self> {
        let time = drive.times[frame];
        let first = drive.times.partition_point(|t| *t < time.plus_secs(-cut.history_s - RUN_UP_S));
        let end = drive.times.partition_point(|t| *t <= time.plus_secs(cut.future_s + 0.5));
        let stretch = drive.stretch(FrameRange::new(first, end));
        let t0 = frame - first;
        let (past, whole) = (states(&stretch, t0 + 1), states(&stretch, stretch.frame_count()));
        let ego = stretch.ego.as_ref()?;
        let to_center = match cut.reference {
            // Only a point behind the box center can be a rear axle; a front bumper or the center itself cannot.
            Reference::RearAxle if ego.reference_to_centre_m > 0.3 && ego.reference_to_centre_m < 6.0 => {
                ego.reference_to_centre_m
            }
            _ => 0.0,
        };
        let motion = past.ego.as_ref()?;
        let (x, y, z, heading) =
            (*motion.x.get(t0)?, *motion.y.get(t0)?, *motion.z.get(t0)?, *motion.heading.get(t0)?);
        if !(has_pose(ego, t0) && x.is_finite() && y.is_finite() && heading.is_finite()) {
            return None;
        }
        let (s, c) = heading.sin_cos();
        let pose = Pose { x: x - to_center * c, y: y - to_center * s, z, heading };
        let past_actions = meta_actions(&stretch.until_frame(t0 + 1));
        let whole_actions = meta_actions(&stretch);
        Some(Self { drive: stretch, t0, past, whole, pose, to_center, past_actions, whole_actions })
    }

    pub fn time(&self) -> Nanos {
        self.drive.times[self.t0]
    }

    /// Steps up to and with t0, from what was known then.
    pub fn history(&self, cut: &Cut) -> Trajectory {
        let (before, _) = cut.steps();
        self.trajectory(-before..=0, cut.rate_hz, self.past.ego.as_ref(), self.past_actions.as_ref())
    }

    /// Steps after t0.
    pub fn future(&self, cut: &Cut) -> Trajectory {
        let (_, after) = cut.steps();
        self.trajectory(1..=after, cut.rate_hz, self.whole.ego.as_ref(), self.whole_actions.as_ref())
    }

    fn trajectory(
        &self,
        steps: std::ops::RangeInclusive<i32>,
        rate_hz: f64,
        motion: Option<&Motion>,
        actions: Option<&MetaActions>,
    ) -> Trajectory {
        let mut out = Trajectory { complete: true, ..Trajectory::default() };
        let nothing = Motion::default();
        let motion = motion.unwrap_or(&nothing);
        for step in steps {
            let t = f64::from(step) / rate_hz;
            out.t_s.push(t as f32);
            // The states bridge gaps; a step is what was driven, so it needs a pose that the lake has.
            let between = self.frames_at(t, motion.len()).filter(|(a, b, _)| {
                let ego = self.drive.ego.as_ref();
                ego.is_some_and(|ego| has_pose(ego, *a) && has_pose(ego, *b))
            });
            let at = |v: &[f64]| between.map_or(f64::NAN, |(a, b, w)| mix(v, a, b, w));
            let heading = between.map_or(f64::NAN, |(a, b, w)| {
                let (from, to) = (motion.heading[a], motion.heading[b]);
                from + w * wrap(to - from)
            });
            let (s, c) = heading.sin_cos();
            let (x, y) =
                self.pose.local(at(&motion.x) - self.to_center * c, at(&motion.y) - self.to_center * s);
            out.complete &= x.is_finite() && y.is_finite() && heading.is_finite();
            out.x.push(known(x));
            out.y.push(known(y));
            out.z.push(known(at(&motion.z) - self.pose.z));
            out.heading.push(known(self.pose.relative(heading)));
            out.speed.push(known(at(&motion.vx) * c + at(&motion.vy) * s));
            out.accel.push(known(at(&motion.accel)));
            out.yaw_rate.push(known(at(&motion.yaw_rate)));
            let nearest = between.map(|(a, b, w)| if w < 0.5 { a } else { b });
            let at_nearest = actions.zip(nearest);
            let longitudinal = at_nearest.and_then(|(m, i)| *m.longitudinal.get(i)?);
            let lateral = at_nearest.and_then(|(m, i)| *m.lateral.get(i)?);
            out.meta_longitudinal.push(longitudinal.map(|v| v.name().to_owned()));
            out.meta_lateral.push(lateral.map(|v| v.name().to_owned()));
        }
        out
    }

    /// The two frames around `t_s` from t0 and the weight of the second; `None` outside the frames and in gaps. Only
    /// the first `frames` frames count, so that a step of the past never depends on a later frame.
    fn frames_at(&self, t_s: f64, frames: usize) -> Option<(usize, usize, f64)> {
        let times = &self.drive.times[..frames.min(self.drive.times.len())];
        let t0 = self.time();
        let at = |i: usize| times[i].seconds_since(t0);
        let after = times.partition_point(|t| t.seconds_since(t0) < t_s - SAME_S);
        if after < times.len() && (at(after) - t_s).abs() <= SAME_S {
            return Some((after, after, 0.0));
        }
        let before = after.checked_sub(1)?;
        let gap = at(after.min(times.len() - 1)) - at(before);
        (after < times.len() && gap <= LARGEST_GAP_S).then(|| (before, after, (t_s - at(before)) / gap))
    }

    pub fn ego_box(&self, cut: &Cut) -> EgoBox {
        let ego = self.drive.ego.as_ref();
        let size = |f: fn(&Ego) -> f64| ego.and_then(|e| known(f(e)).filter(|v| *v > 0.0));
        let axle = cut.reference == Reference::RearAxle && self.to_center > 0.0;
        EgoBox {
            length_m: size(|e| e.length_m),
            width_m: size(|e| e.width_m),
            height_m: size(|e| e.height_m),
            reference: if axle { "rear_axle" } else { "box_centre" }.to_owned(),
            reference_to_centre_m: self.to_center as f32,
        }
    }
}

/// The lake has the ego's position in the frame. (A heading that the log does not state follows from the positions.)
fn has_pose(ego: &Ego, frame: usize) -> bool {
    let known = |v: &[f64]| v.get(frame).is_some_and(|v| v.is_finite());
    known(&ego.motion.x) && known(&ego.motion.y)
}

fn mix(v: &[f64], a: usize, b: usize, w: f64) -> f64 {
    match (v.get(a), v.get(b)) {
        (Some(p), _) if a == b => *p,
        (Some(p), Some(q)) => p + w * (q - p),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Driving north (heading 90 degrees) at 10 m/s, frames at 10 Hz, a gap of half a second before frame 60.
    fn drive() -> Drive {
        let t = |i: usize| if i < 60 { i as f64 / 10.0 } else { i as f64 / 10.0 + 0.5 };
        let n = 120;
        let motion = Motion {
            x: vec![100.0; n],
            y: (0..n).map(|i| 10.0 * t(i)).collect(),
            z: vec![0.0; n],
            heading: vec![FRAC_PI_2; n],
            vx: vec![0.0; n],
            vy: vec![10.0; n],
            accel: vec![0.0; n],
            yaw_rate: vec![0.0; n],
            forward: vec![],
        };
        Drive {
            times: (0..n).map(|i| Nanos::from_secs_f64(t(i))).collect(),
            ego: Some(Ego { motion, reference_to_centre_m: 1.4, length_m: 4.8, ..Ego::default() }),
            ..Drive::default()
        }
    }

    #[test]
    fn the_past_is_behind_and_the_future_ahead_in_the_frame_of_t0() {
        let cut = Cut::default();
        let w = Window::around(&drive(), 30, &cut).unwrap();
        assert_eq!((w.pose.x, w.pose.y), (100.0, 30.0 - 1.4));
        let h = w.history(&cut);
        assert_eq!(h.t_s.len(), 21);
        assert!(h.complete);
        assert!((h.x[0].unwrap() + 20.0).abs() < 1e-4 && h.y[0].unwrap().abs() < 1e-4);
        assert_eq!(h.x[20], Some(0.0));
        assert!((h.speed[3].unwrap() - 10.0).abs() < 1e-5);
        let f = w.future(&cut);
        assert_eq!(f.t_s.len(), 60);
        assert!((f.x[9].unwrap() - 10.0).abs() < 1e-4, "one second ahead");
        // The gap from 5.9 s to 6.5 s of the drive is 2.9 s to 3.5 s from t0.
        assert!(!f.complete);
        assert_eq!((f.x[28].is_some(), f.x[30], f.x[34].is_some()), (true, None, true));
    }

    #[test]
    fn a_window_at_the_edge_of_the_drive_is_incomplete_and_never_padded() {
        let cut = Cut::default();
        let w = Window::around(&drive(), 10, &cut).unwrap();
        let h = w.history(&cut);
        assert!(!h.complete);
        assert_eq!(h.x.iter().filter(|x| x.is_none()).count(), 10);
        let w = Window::around(&drive(), 119, &cut).unwrap();
        assert!(w.future(&cut).x.iter().all(Option::is_none));
    }

    /// As ingest leaves a frame with an impossible pose (`ingest.pose.impossible`).
    fn forget(drive: &mut Drive, frames: std::ops::Range<usize>) {
        let m = &mut drive.ego.as_mut().unwrap().motion;
        for column in [&mut m.x, &mut m.y, &mut m.z, &mut m.heading, &mut m.vx, &mut m.vy, &mut m.accel] {
            column[frames.clone()].fill(f64::NAN);
        }
    }

    #[test]
    fn a_step_whose_pose_the_lake_does_not_have_is_null_and_not_bridged() {
        let mut d = drive();
        // Before t0 one frame, after it two: 0.5 s back, 1.0 and 1.1 s ahead.
        forget(&mut d, 25..26);
        forget(&mut d, 40..42);
        let cut = Cut { future_s: 2.0, ..Cut::default() };
        let w = Window::around(&d, 30, &cut).unwrap();
        let nulls = |v: &[Option<f32>]| (0..v.len()).filter(|i| v[*i].is_none()).collect::<Vec<_>>();
        let (h, f) = (w.history(&cut), w.future(&cut));
        assert!(!h.complete && !f.complete);
        // Steps: history from 2.0 s back, future from 0.1 s ahead.
        for column in [&h.x, &h.y, &h.z, &h.heading, &h.speed, &h.accel, &h.yaw_rate] {
            assert_eq!(nulls(column), [15]);
        }
        for column in [&f.x, &f.y, &f.z, &f.heading, &f.speed, &f.accel, &f.yaw_rate] {
            assert_eq!(nulls(column), [9, 10]);
        }
        assert!(f.meta_longitudinal[9].is_none() && f.meta_lateral[10].is_none());
        // Constant 10 m/s: the steps around them are where the car drove.
        assert!((f.x[8].unwrap() - 9.0).abs() < 1e-3 && (f.x[11].unwrap() - 12.0).abs() < 1e-3);
        // Between two frames of which one has no pose, too.
        let fine = Cut { rate_hz: 20.0, ..cut };
        assert_eq!(nulls(&w.future(&fine).x), [18, 19, 20, 21, 22]);
        assert!(Window::around(&d, 25, &fine).is_none(), "no origin without a pose");
    }

    #[test]
    fn steps_between_frames_are_interpolated_and_headings_take_the_short_way() {
        let mut d = drive();
        for (i, h) in d.ego.as_mut().unwrap().motion.heading.iter_mut().enumerate() {
            *h = if i % 2 == 0 { PI - 0.01 } else { -PI + 0.01 };
        }
        let cut = Cut { rate_hz: 20.0, ..Cut::default() };
        let h = Window::around(&d, 30, &cut).unwrap().history(&cut);
        assert!(h.heading.iter().all(|a| a.unwrap().abs() < 0.03), "{:?}", h.heading);
    }
}
