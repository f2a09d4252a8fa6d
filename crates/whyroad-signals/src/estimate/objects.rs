//! Converts a drive's rows to the smoother's input and back: the rows of one object on the frames of the drive, with
//! unmeasured rows between them left empty (lost rows, rows that ingest interpolated because of the log's lower rate),
//! split where the object was missing for long. A drive that was cut between two measurements lacks the rows that
//! depend on the later one; they are left empty, too, until that measurement is due.

use super::noise::Rows;
use super::smoother::{Deviations, States};
use std::ops::Range;
use whyroad_model::scene::{ClassChange, Motion, Track};
use whyroad_model::{Nanos, TrackId};

/// A frame, with the jitter of real logs, s.
const FRAME_S: f64 = 0.11;
/// Slightly less than a frame: the frame of the next measurement is not predicted, s.
const UNDER_A_FRAME_S: f64 = 0.09;

/// Rows that were known within this time depend on the same measurement: sums of tenths are not exact, ns.
const SAME_NS: i64 = 1_000;

/// Rows of one object on consecutive frames; NaN where nothing was measured.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    /// Frame of each row.
    pub frames: Vec<u32>,
    /// Source row of each row; `None` if there is none.
    pub source: Vec<Option<usize>>,
    pub times: Vec<f64>,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub heading: Vec<f64>,
    pub vx: Vec<f64>,
    pub vy: Vec<f64>,
    pub forward: Vec<f64>,
}

impl Measured {
    /// The rows `range` as the smoother's input.
    pub fn rows(&self, range: Range<usize>) -> Rows<'_> {
        Rows {
            times: &self.times[range.clone()],
            x: &self.x[range.clone()],
            y: &self.y[range.clone()],
            heading: &self.heading[range.clone()],
            vx: &self.vx[range.clone()],
            vy: &self.vy[range.clone()],
            forward: &self.forward[range],
        }
    }

    /// Only the measured rows, for residuals.
    pub fn compact(&self) -> Measured {
        let rows: Vec<usize> = (0..self.times.len()).filter(|&i| self.x[i].is_finite()).collect();
        let some = |v: &[f64]| rows.iter().map(|&i| v[i]).collect();
        Measured {
            frames: rows.iter().map(|&i| self.frames[i]).collect(),
            source: rows.iter().map(|&i| self.source[i]).collect(),
            times: some(&self.times),
            x: some(&self.x),
            y: some(&self.y),
            heading: some(&self.heading),
            vx: some(&self.vx),
            vy: some(&self.vy),
            forward: some(&self.forward),
        }
    }

    /// True when every row was measured.
    pub fn is_complete(&self) -> bool {
        self.x.iter().all(|x| x.is_finite())
    }

    /// True when every row in the source was measured.
    pub fn lacks_only_rows(&self) -> bool {
        self.x.iter().zip(&self.source).all(|(x, source)| x.is_finite() || source.is_none())
    }

    /// Rows on the frames from the first to the last of `frames`, except for gaps longer than `max_gap_s`.
    pub fn new(
        frames: &[u32],
        motion: &Motion,
        known_at: &[Nanos],
        times: &[Nanos],
        seconds: &[f64],
        max_gap_s: f64,
    ) -> Self {
        // Room for short gaps, too.
        let span = frames.first().zip(frames.last()).map_or(0, |(first, last)| (last - first) as usize + 1);
        let mut out = Self::with_capacity(span.min(frames.len() + frames.len() / 4 + 8));
        for (row, &frame) in frames.iter().enumerate() {
            if let Some(&last) = out.frames.last()
                && seconds[frame as usize] - seconds[last as usize] <= max_gap_s
            {
                for between in last + 1..frame {
                    out.push(between, None, seconds, motion, false);
                }
            }
            out.push(frame, Some(row), seconds, motion, is_measured(row, frame, known_at, times));
        }
        out.leave_open_what_is_due(frames, motion, known_at, times, seconds);
        out
    }

    fn with_capacity(n: usize) -> Self {
        let v = || Vec::with_capacity(n);
        let (frames, source) = (Vec::with_capacity(n), Vec::with_capacity(n));
        Self { frames, source, times: v(), x: v(), y: v(), heading: v(), vx: v(), vy: v(), forward: v() }
    }

    /// Adds the last frames of the drive when their measurements are not known yet.
    fn leave_open_what_is_due(
        &mut self,
        frames: &[u32],
        motion: &Motion,
        known_at: &[Nanos],
        times: &[Nanos],
        seconds: &[f64],
    ) {
        let (Some(&end), Some(last)) = (frames.last(), times.len().checked_sub(1)) else { return };
        let late = |(at, f): (&Nanos, &u32)| at.seconds_since(times[*f as usize]);
        let late = known_at.iter().zip(frames).map(late).fold(0.0, f64::max);
        if late > 0.0 && seconds[last] - seconds[end as usize] <= (late + UNDER_A_FRAME_S).max(FRAME_S) {
            for frame in end + 1..=last as u32 {
                self.push(frame, None, seconds, motion, false);
            }
        }
    }

    /// The frames without a source row between two frames that have one.
    pub fn bridged(&self) -> Vec<u32> {
        let end = self.source.iter().rposition(Option::is_some).unwrap_or(0);
        let rows = self.frames.iter().zip(&self.source).take(end);
        rows.filter(|(_, source)| source.is_none()).map(|(frame, _)| *frame).collect()
    }

    fn push(&mut self, frame: u32, row: Option<usize>, seconds: &[f64], m: &Motion, measured: bool) {
        let of = |v: &[f64]| row.filter(|_| measured).and_then(|r| v.get(r).copied()).unwrap_or(f64::NAN);
        self.frames.push(frame);
        self.source.push(row);
        self.times.push(seconds[frame as usize]);
        let known = of(&m.x).is_finite() && of(&m.y).is_finite();
        let place = |v: f64| if known { v } else { f64::NAN };
        self.x.push(place(of(&m.x)));
        self.y.push(place(of(&m.y)));
        self.heading.push(of(&m.heading));
        self.vx.push(of(&m.vx));
        self.vy.push(of(&m.vy));
        self.forward.push(of(&m.forward));
    }

    /// Ranges without a gap in the frames.
    pub fn runs(&self) -> Vec<Range<usize>> {
        let mut out = Vec::new();
        let mut start = 0;
        for i in 1..=self.frames.len() {
            if i == self.frames.len() || self.frames[i] != self.frames[i - 1] + 1 {
                out.push(start..i);
                start = i;
            }
        }
        out.retain(|r| !r.is_empty());
        out
    }
}

/// False for a row between two samples of the log, which contains no additional information. Where samples are not on
/// frames, the last row before a sample is the nearest to it and represents it.
fn is_measured(row: usize, frame: u32, known_at: &[Nanos], times: &[Nanos]) -> bool {
    match known_at.get(row) {
        Some(at) if *at > times[frame as usize] => {
            known_at.get(row + 1).is_none_or(|next| next.0 - at.0 > SAME_NS)
        }
        _ => true,
    }
}

/// Copies the estimated rows into a motion; heights are interpolated.
pub(super) fn motion_of(states: &States, measured: &Measured, given: &Motion) -> Motion {
    let n = measured.frames.len();
    let mut out = Motion::unknown(n);
    out.x.clone_from(&states.x);
    out.y.clone_from(&states.y);
    out.heading.clone_from(&states.heading);
    out.vx.clone_from(&states.vx);
    out.vy.clone_from(&states.vy);
    out.accel.clone_from(&states.accel);
    out.yaw_rate.clone_from(&states.yaw_rate);
    out.z = spread(&given.z, measured);
    // Stated values are not estimated.
    for (i, row) in measured.source.iter().enumerate() {
        let Some(row) = *row else { continue };
        for (to, from) in [(&mut out.accel, &given.accel), (&mut out.yaw_rate, &given.yaw_rate)] {
            if from[row].is_finite() {
                to[i] = from[row];
            }
        }
    }
    out
}

/// A column of the source on the rows: linear between source rows, constant after the last one. A source row in which
/// neither the position nor the column is known, as one that rests on a later measurement, counts as none.
pub(super) fn spread(given: &[f64], measured: &Measured) -> Vec<f64> {
    let n = measured.frames.len();
    if given.is_empty() {
        return Vec::new();
    }
    let mut out: Vec<f64> = measured.source.iter().map(|r| r.map_or(f64::NAN, |r| given[r])).collect();
    let mut last: Option<usize> = None;
    for i in 0..n {
        if measured.source[i].is_none() || (out[i].is_nan() && measured.x[i].is_nan()) {
            continue;
        }
        if let Some(a) = last.filter(|a| i - a > 1) {
            for k in a + 1..i {
                let share = (measured.times[k] - measured.times[a]) / (measured.times[i] - measured.times[a]);
                out[k] = out[a] + share * (out[i] - out[a]);
            }
        }
        last = Some(i);
    }
    if let Some(a) = last {
        let value = out[a];
        out[a + 1..].fill(value);
    }
    out
}

/// A column of states: rows between keep the previous value.
pub(super) fn held<T: Clone>(given: &[T], measured: &Measured) -> Vec<T> {
    let mut last = None;
    let mut out = Vec::new();
    for row in &measured.source {
        last = row.and_then(|r| given.get(r).cloned()).or(last);
        out.extend(last.clone());
    }
    out
}

/// The track with estimated rows; `bridged` are the unobserved ones.
pub(super) fn track_of(given: &Track, measured: &Measured, states: &States) -> Track {
    // Counts and shares of observations: unknown in unobserved rows.
    let seen = |v: &[f64]| -> Vec<f64> {
        if v.is_empty() {
            return Vec::new();
        }
        measured.source.iter().map(|r| r.map_or(f64::NAN, |r| v[r])).collect()
    };
    let row_of =
        |row: u32| measured.source.iter().position(|s| s.is_some_and(|s| s >= row as usize)).unwrap_or(0);
    Track {
        id: given.id.clone(),
        class: given.class,
        source_class: given.source_class.clone(),
        class_changes: given
            .class_changes
            .iter()
            .map(|c| ClassChange { row: row_of(c.row) as u32, ..c.clone() })
            .collect(),
        frames: measured.frames.clone(),
        motion: motion_of(states, measured, &given.motion),
        length_m: spread(&given.length_m, measured),
        width_m: spread(&given.width_m, measured),
        height_m: spread(&given.height_m, measured),
        interior_points: seen(&given.interior_points),
        turn_signal: held(&given.turn_signal, measured),
        visible_share: seen(&given.visible_share),
        occluder: if given.occluder.is_empty() { Vec::new() } else { held(&given.occluder, measured) },
        known_at: Vec::new(),
    }
}

/// Two tracks of one object, joined; the id and the class of the first, unless that class is unknown.
pub(super) fn joined(first: &Track, next: &Track) -> Track {
    let offset = first.frames.len() as u32;
    let both = |a: &[f64], b: &[f64]| [a, b].concat();
    let whole = |a: &[f64], b: &[f64]| {
        if a.is_empty() && b.is_empty() {
            return Vec::new();
        }
        let full = |v: &[f64], n: usize| if v.is_empty() { vec![f64::NAN; n] } else { v.to_vec() };
        [full(a, first.frames.len()), full(b, next.frames.len())].concat()
    };
    let (a, b) = (&first.motion, &next.motion);
    let mut out = Track {
        id: first.id.clone(),
        frames: [&first.frames[..], &next.frames].concat(),
        motion: Motion {
            x: both(&a.x, &b.x),
            y: both(&a.y, &b.y),
            z: both(&a.z, &b.z),
            heading: both(&a.heading, &b.heading),
            vx: both(&a.vx, &b.vx),
            vy: both(&a.vy, &b.vy),
            accel: both(&a.accel, &b.accel),
            yaw_rate: both(&a.yaw_rate, &b.yaw_rate),
            forward: whole(&a.forward, &b.forward),
        },
        length_m: both(&first.length_m, &next.length_m),
        width_m: both(&first.width_m, &next.width_m),
        height_m: both(&first.height_m, &next.height_m),
        interior_points: both(&first.interior_points, &next.interior_points),
        turn_signal: optional(&first.turn_signal, offset as usize, &next.turn_signal, next.frames.len()),
        visible_share: whole(&first.visible_share, &next.visible_share),
        occluder: optional(&first.occluder, offset as usize, &next.occluder, next.frames.len()),
        known_at: Vec::new(),
        ..first.clone()
    };
    let classes: Vec<_> = (0..first.frames.len())
        .map(|r| first.class_at(r))
        .chain((0..next.frames.len()).map(|r| next.class_at(r)))
        .collect();
    if classes.windows(2).any(|w| w[0] != w[1]) {
        out.state_classes(classes);
    }
    if !first.known_at.is_empty() && !next.known_at.is_empty() {
        out.known_at = [&first.known_at[..], &next.known_at].concat();
    }
    out
}

fn optional<T: Clone>(a: &[Option<T>], n: usize, b: &[Option<T>], m: usize) -> Vec<Option<T>> {
    if a.is_empty() && b.is_empty() {
        return Vec::new();
    }
    let full = |v: &[Option<T>], n: usize| if v.is_empty() { vec![None; n] } else { v.to_vec() };
    [full(a, n), full(b, m)].concat()
}

/// Appends rows.
pub(super) fn append(to: &mut States, rows: States) {
    let States { x, y, heading, vx, vy, accel, yaw_rate, sd } = rows;
    let Deviations { position, heading: sd_heading, speed, accel: sd_accel, yaw_rate: sd_yaw } = sd;
    for (to, from) in [
        (&mut to.x, x),
        (&mut to.y, y),
        (&mut to.heading, heading),
        (&mut to.vx, vx),
        (&mut to.vy, vy),
        (&mut to.accel, accel),
        (&mut to.yaw_rate, yaw_rate),
        (&mut to.sd.position, position),
        (&mut to.sd.heading, sd_heading),
        (&mut to.sd.speed, speed),
        (&mut to.sd.accel, sd_accel),
        (&mut to.sd.yaw_rate, sd_yaw),
    ] {
        to.extend(from);
    }
}

/// Ids of joined tracks: from the later id to the first one.
pub type Joined = std::collections::BTreeMap<TrackId, TrackId>;
