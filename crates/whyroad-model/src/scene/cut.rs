//! A drive as known at a moment, and stretches of it. Data that a cut drive lacks cannot leak into results made from
//! it.

use super::{Drive, DriveMeta, Ego, EgoBus, Motion, Track};
use crate::{FrameRange, Nanos};

impl Drive {
    /// The drive up to and with `until`: frames, rows and states of later times are not in it, nor values based on a
    /// later measurement (a pose between two samples, of which the second is later). Two recordings that are equal up
    /// to `until` give equal results. The hash of the content and the list of what is missing describe the whole drive
    /// and are empty.
    pub fn until(&self, until: Nanos) -> Drive {
        let times = &self.times[..self.times.partition_point(|t| *t <= until)];
        let ego = self.ego.as_ref().map(|e| e.rows(times, 0, Some(until)));
        let can = self.meta.can && ego.as_ref().is_some_and(|e| !e.bus.is_empty());
        Drive {
            meta: DriveMeta {
                content_hash: String::new(),
                missing: vec![],
                can,
                objects_unknown: self.unknown_until(until),
                ..self.meta.clone()
            },
            times: times.to_vec(),
            ego,
            tracks: self.tracks.iter().filter_map(|t| t.rows(times, 0, Some(until))).collect(),
            map: self.map.clone(),
            lights: stated(self.lights.as_deref(), |s| s.time <= until),
            context: stated(self.context.as_deref(), |s| s.time <= until),
            media: stated(self.media.as_deref(), |f| f.time <= until),
        }
    }

    fn unknown_until(&self, until: Nanos) -> Vec<[Nanos; 2]> {
        let stretches = self.meta.objects_unknown.iter().filter(|[first, _]| *first <= until);
        stretches.map(|[first, last]| [*first, (*last).min(until)]).collect()
    }

    /// The drive as it was at frame `frames - 1`, at most the last one; see [`Drive::until`].
    pub fn until_frame(&self, frames: usize) -> Drive {
        let last = frames.min(self.times.len()).checked_sub(1);
        self.until(last.map_or(Nanos(i64::MIN), |i| self.times[i]))
    }

    /// The ego and the tracks of `frames`, without map, lights, context and media. Nothing is withheld from the end.
    pub fn stretch(&self, frames: FrameRange) -> Drive {
        let times = &self.times[frames.start..frames.end.min(self.times.len())];
        Drive {
            meta: self.meta.clone(),
            times: times.to_vec(),
            ego: self.ego.as_ref().map(|e| e.rows(times, frames.start, None)),
            tracks: self.tracks.iter().filter_map(|t| t.rows(times, frames.start, None)).collect(),
            ..Drive::default()
        }
    }
}

/// The states that may be seen; `None` when there are none, as if the log did not have them.
fn stated<T: Clone>(all: Option<&[T]>, seen: impl Fn(&T) -> bool) -> Option<Vec<T>> {
    let seen: Vec<T> = all?.iter().filter(|s| seen(s)).cloned().collect();
    (!seen.is_empty()).then_some(seen)
}

/// Rows `first..end`; of a column that the log has not, nothing.
fn part<T: Clone>(values: &[T], first: usize, end: usize) -> Vec<T> {
    values.get(first..end.min(values.len())).unwrap_or_default().to_vec()
}

/// As [`part`]; empty when nothing of it is known, as if the log did not have the column.
fn states<T: Clone>(values: &[Option<T>], first: usize, end: usize) -> Vec<Option<T>> {
    let out = part(values, first, end);
    if out.iter().any(Option::is_some) { out } else { Vec::new() }
}

/// As [`states`], for numbers.
fn numbers(values: &[f64], first: usize, end: usize) -> Vec<f64> {
    let out = part(values, first, end);
    if out.iter().any(|v| !v.is_nan()) { out } else { Vec::new() }
}

/// When the rows at `times` were known, at most `until`; empty when none was known later than its own time.
fn known_at(all: Vec<Nanos>, times: impl Iterator<Item = Nanos>, until: Option<Nanos>) -> Vec<Nanos> {
    let all: Vec<Nanos> = all.into_iter().map(|at| until.map_or(at, |until| at.min(until))).collect();
    if all.iter().zip(times).any(|(at, time)| *at > time) { all } else { Vec::new() }
}

/// Rows of `first..end` that rest on measurements after `until`.
fn withheld(
    known_at: &[Nanos],
    first: usize,
    end: usize,
    until: Option<Nanos>,
) -> impl Iterator<Item = usize> {
    let end = end.min(known_at.len());
    (first.min(end)..end).filter(move |&row| until.is_some_and(|until| known_at[row] > until))
}

impl Motion {
    /// Rows `first..end`.
    pub fn rows(&self, first: usize, end: usize) -> Motion {
        let part = |v: &Vec<f64>| part(v, first, end);
        Motion {
            x: part(&self.x),
            y: part(&self.y),
            z: part(&self.z),
            heading: part(&self.heading),
            vx: part(&self.vx),
            vy: part(&self.vy),
            accel: part(&self.accel),
            yaw_rate: part(&self.yaw_rate),
            forward: numbers(&self.forward, first, end),
        }
    }

    /// Makes a row unknown.
    fn forget(&mut self, row: usize) {
        let Motion { x, y, z, heading, vx, vy, accel, yaw_rate, forward } = self;
        let columns = [x, y, z, heading, vx, vy, accel, yaw_rate, forward];
        columns.into_iter().filter_map(|v| v.get_mut(row)).for_each(|v| *v = f64::NAN);
    }
}

impl EgoBus {
    /// True when no value of it is stated.
    pub fn is_empty(&self) -> bool {
        let numbers = [&self.speed_mps, &self.steering, &self.throttle, &self.vertical_accel];
        let flags = [&self.brake, &self.aeb, &self.cruise, &self.wipers];
        numbers.iter().all(|v| v.is_empty())
            && flags.iter().all(|v| v.is_empty())
            && self.gear.is_empty()
            && self.turn_signal.is_empty()
            && self.route_command.is_empty()
    }

    fn rows(&self, first: usize, end: usize) -> EgoBus {
        EgoBus {
            speed_mps: numbers(&self.speed_mps, first, end),
            steering: numbers(&self.steering, first, end),
            brake: states(&self.brake, first, end),
            throttle: numbers(&self.throttle, first, end),
            gear: states(&self.gear, first, end),
            turn_signal: states(&self.turn_signal, first, end),
            aeb: states(&self.aeb, first, end),
            wipers: states(&self.wipers, first, end),
            vertical_accel: numbers(&self.vertical_accel, first, end),
            cruise: states(&self.cruise, first, end),
            route_command: states(&self.route_command, first, end),
        }
    }

    /// Makes what is interpolated between samples unknown in a row; states are valid from when they were stated.
    fn forget(&mut self, row: usize) {
        let columns = [&mut self.speed_mps, &mut self.steering, &mut self.throttle, &mut self.vertical_accel];
        columns.into_iter().filter_map(|v| v.get_mut(row)).for_each(|v| *v = f64::NAN);
    }
}

impl Ego {
    /// The rows at `times`, which begin at frame `first`; those that rest on measurements after `until` are unknown.
    fn rows(&self, times: &[Nanos], first: usize, until: Option<Nanos>) -> Ego {
        let end = first + times.len();
        let (mut motion, mut bus) = (self.motion.clone(), self.bus.clone());
        for row in withheld(&self.known_at, first, end, until) {
            motion.forget(row);
            bus.forget(row);
        }
        let known_at = known_at(part(&self.known_at, first, end), times.iter().copied(), until);
        Ego { motion: motion.rows(first, end), bus: bus.rows(first, end), known_at, ..*self }
    }
}

impl Track {
    /// The rows at `times`, which begin at frame `first`, but for those that rest on measurements after `until`; `None`
    /// if there are none.
    fn rows(&self, times: &[Nanos], first: usize, until: Option<Nanos>) -> Option<Track> {
        let a = self.frames.partition_point(|&f| (f as usize) < first);
        let b = self.frames.partition_point(|&f| (f as usize) < first + times.len());
        // Rows ascend in time, and so do the measurements on which they rest.
        let b = withheld(&self.known_at, a, b, until).next().unwrap_or(b);
        if a >= b {
            return None;
        }
        let frames: Vec<u32> = self.frames[a..b].iter().map(|f| f - first as u32).collect();
        let time = |&f: &u32| times[f as usize];
        let mut out = Track {
            id: self.id.clone(),
            class: self.class,
            source_class: self.source_class.clone(),
            class_changes: Vec::new(),
            motion: self.motion.rows(a, b),
            length_m: part(&self.length_m, a, b),
            width_m: part(&self.width_m, a, b),
            height_m: part(&self.height_m, a, b),
            interior_points: part(&self.interior_points, a, b),
            turn_signal: states(&self.turn_signal, a, b),
            visible_share: numbers(&self.visible_share, a, b),
            occluder: states(&self.occluder, a, b),
            known_at: known_at(part(&self.known_at, a, b), frames.iter().map(time), until),
            frames,
        };
        if !self.class_changes.is_empty() {
            out.state_classes((a..b).map(|row| self.class_at(row)));
        }
        Some(out)
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{ContextState, Drive, DriveMeta, Ego, EgoBus, Motion, Track};
    use crate::{FrameRange, Nanos, ObjectClass};

    fn at(frame: usize) -> Nanos {
        Nanos(frame as i64 * 100_000_000)
    }

    /// Ten frames. The ego's pose is measured every second frame, the object's every fifth; what comes after frame 6 is
    /// `later`.
    fn drive(later: f64) -> Drive {
        let value = |i: usize| if i > 6 { later } else { i as f64 };
        let motion = |step: usize| {
            let x = (0..10).map(|i| {
                let (a, b) = (i / step * step, i.div_ceil(step) * step);
                let w = (i - a) as f64 / step as f64;
                value(a) * (1.0 - w) + value(b) * w
            });
            Motion { x: x.collect(), ..Motion::unknown(10) }
        };
        let known_at = |step: usize| (0..10).map(|i: usize| at(i.div_ceil(step) * step)).collect();
        let mut object = Track {
            id: "a".into(),
            frames: (0..10).collect(),
            motion: motion(5),
            length_m: vec![4.0; 10],
            width_m: vec![2.0; 10],
            height_m: vec![1.5; 10],
            interior_points: vec![f64::NAN; 10],
            known_at: known_at(5),
            ..Track::default()
        };
        let class = |i| match i {
            0 => (ObjectClass::Unknown, "?"),
            1..7 => (ObjectClass::Car, "car"),
            _ => (ObjectClass::Truck, if later > 0.0 { "truck" } else { "lorry" }),
        };
        object.state_classes((0..10).map(class));
        let weather = |frame, value: &str| ContextState {
            time: at(frame),
            kind: "weather".into(),
            value: value.into(),
            source: "log".into(),
            confidence: None,
        };
        Drive {
            meta: DriveMeta { can: true, content_hash: later.to_string(), ..DriveMeta::default() },
            times: (0..10).map(at).collect(),
            ego: Some(Ego {
                motion: motion(2),
                known_at: known_at(2),
                bus: EgoBus {
                    brake: (0..10).map(|i| (i > 6).then_some(later > 0.0)).collect(),
                    ..EgoBus::default()
                },
                ..Ego::default()
            }),
            tracks: vec![object],
            context: Some(vec![weather(8, if later > 0.0 { "rain" } else { "clear" })]),
            ..Drive::default()
        }
    }

    #[test]
    fn a_cut_drive_does_not_depend_on_what_comes_later() {
        for frames in 1..=6 {
            let [a, b] = [99.0, -99.0].map(|later| format!("{:?}", drive(later).until_frame(frames)));
            assert_eq!(a, b, "{frames} frames");
        }
        assert_ne!(format!("{:?}", drive(99.0).until_frame(9)), format!("{:?}", drive(-99.0).until_frame(9)));
    }

    #[test]
    fn rows_that_rest_on_a_later_measurement_are_withheld() {
        let seen = drive(99.0).until_frame(6);
        let ego = seen.ego.unwrap();
        assert_eq!(ego.motion.x[..5], [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert!(ego.motion.x[5].is_nan(), "frame 5 lies between the samples of frames 4 and 6");
        assert_eq!(seen.tracks[0].frames, [0, 1, 2, 3, 4, 5]);
        assert_eq!(drive(99.0).until_frame(8).tracks[0].frames, [0, 1, 2, 3, 4, 5]);
        assert!(!seen.meta.can && ego.bus.brake.is_empty() && seen.context.is_none());
    }

    #[test]
    fn a_class_that_becomes_known_later_does_not_apply_earlier() {
        let whole = &drive(99.0).tracks[0];
        assert_eq!((whole.class, whole.class_at(0).0, whole.class_at(9).0), {
            (ObjectClass::Car, ObjectClass::Unknown, ObjectClass::Truck)
        });
        let class = |frames| drive(99.0).until_frame(frames).tracks[0].class;
        assert_eq!(class(1), ObjectClass::Unknown);
        // One row of each: an unknown class carries less information than a known one.
        assert_eq!(class(2), ObjectClass::Unknown, "the second row rests on frame 5");
        assert_eq!(class(6), ObjectClass::Car);
    }

    #[test]
    fn a_stretch_keeps_whole_rows() {
        let part = drive(99.0).stretch(FrameRange::new(3, 8));
        assert_eq!(part.ego.unwrap().motion.x.len(), 5);
        assert_eq!(part.tracks[0].frames, [0, 1, 2, 3, 4]);
        assert_eq!(part.tracks[0].class, ObjectClass::Car);
        assert_eq!(part.tracks[0].known_at[1], at(5), "times stay those of the log");
    }
}
