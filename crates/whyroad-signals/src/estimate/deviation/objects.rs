//! Standard deviations of the signals of any object and of pairs of objects: first order, states treated as
//! independent.

use super::{LEAST_SPEED_MPS, OfDrive, number};
use crate::estimate::smoother::Deviations;
use whyroad_model::pair::PairTable;
use whyroad_model::scene::Motion;
use whyroad_model::signal::{EGO_ID, TargetSpan, deviation_name};
use whyroad_model::{Column, SignalTable};

/// Minimum distance for a division, m.
const LEAST_DISTANCE_M: f64 = 0.5;

/// Inputs of a signal of one object.
#[derive(Clone, Copy)]
enum OfObject {
    Position,
    Speed,
    Accel,
    /// Yaw rate times speed.
    LateralAccel,
}

/// Inputs of a signal of two objects.
#[derive(Clone, Copy)]
enum OfPair {
    Distance,
    /// Along the first object's axes: its heading's deviation counts with the lateral distance.
    Forward,
    Lateral,
    /// An angle at the first one.
    Bearing,
    Closing,
    TimeToCollision,
}

const OBJECT: &[(&str, OfObject)] = &[
    ("object.speed", OfObject::Speed),
    ("object.accel", OfObject::Accel),
    ("object.lateral_accel", OfObject::LateralAccel),
    ("object.junction_distance", OfObject::Position),
    ("object.crosswalk_distance", OfObject::Position),
];

const PAIR: &[(&str, OfPair)] = &[
    ("pair.distance", OfPair::Distance),
    ("pair.forward", OfPair::Forward),
    ("pair.lateral", OfPair::Lateral),
    ("pair.bearing", OfPair::Bearing),
    ("pair.course", OfPair::Bearing),
    ("pair.closing", OfPair::Closing),
    ("pair.ttc_box", OfPair::TimeToCollision),
];

/// Adds the columns to a table of objects and pairs.
pub(in crate::estimate) fn write(of: &OfDrive<'_>, table: &mut SignalTable) {
    if of.ego.is_none() && of.tracks.iter().all(Option::is_none) {
        return;
    }
    let objects: Vec<Object<'_>> = table.targets.iter().filter_map(|span| Object::new(of, span)).collect();
    if objects.len() != table.targets.len() {
        return;
    }
    let mut found = Vec::new();
    for (name, made) in OBJECT.iter().filter(|(name, _)| table.target_columns.contains_key(*name)) {
        let rows = objects
            .iter()
            .flat_map(|o| (o.span.frames.start..o.span.frames.end).map(|f| o.of_signal(*made, f)));
        found.push((name, rows.collect()));
    }
    let mut of_all_pairs = table.pairs.take();
    if let Some(pairs) = &mut of_all_pairs {
        of_pairs(&objects, pairs);
    }
    for (name, column) in found {
        add(&mut table.target_columns, name, column);
    }
    table.pairs = of_all_pairs;
}

fn of_pairs(objects: &[Object<'_>], pairs: &mut PairTable) {
    for (name, made) in PAIR {
        let Some(Column::Number(values)) = pairs.columns.get(*name) else { continue };
        let mut column = vec![0.0; values.len()];
        for span in &pairs.spans {
            let (a, b) = (&objects[span.first], &objects[span.second]);
            for (row, frame) in span.rows().zip(span.frames.start..) {
                column[row] = of_pair(*made, (a, b), frame, values[row]);
            }
        }
        add(&mut pairs.columns, name, column);
    }
}

fn add(to: &mut std::collections::BTreeMap<String, Column>, signal: &str, column: Vec<f64>) {
    if column.iter().any(|d| *d > 0.0) {
        to.insert(deviation_name(signal), Column::Number(column));
    }
}

/// One object with its deviations.
struct Object<'a> {
    span: &'a TargetSpan,
    motion: &'a Motion,
    /// Frames of the rows; `None` where there is a row for every frame.
    frames: Option<&'a [u32]>,
    sd: Option<&'a Deviations>,
}

impl<'a> Object<'a> {
    fn new(of: &OfDrive<'a>, span: &'a TargetSpan) -> Option<Self> {
        let track = of.drive.tracks.iter().position(|t| t.id == span.id && !t.frames.is_empty());
        match track {
            Some(i) => {
                let track = &of.drive.tracks[i];
                let sd = of.tracks.get(i).and_then(Option::as_ref);
                Some(Self { span, motion: &track.motion, frames: Some(&track.frames), sd })
            }
            None if span.id.as_str() == EGO_ID => {
                Some(Self { span, motion: &of.drive.ego.as_ref()?.motion, frames: None, sd: of.ego })
            }
            None => None,
        }
    }

    fn row(&self, frame: usize) -> Option<usize> {
        match self.frames {
            Some(frames) => frames.binary_search(&u32::try_from(frame).ok()?).ok(),
            None => (frame < self.motion.len()).then_some(frame),
        }
    }

    /// A deviation in a frame; zero where it is exact or not observed.
    fn sd(&self, pick: fn(&Deviations) -> &Vec<f64>, frame: usize) -> f64 {
        number(self.row(frame).zip(self.sd).and_then(|(row, sd)| pick(sd).get(row).copied()))
    }

    fn of_signal(&self, made: OfObject, frame: usize) -> f64 {
        match made {
            OfObject::Position => self.sd(|s| &s.position, frame),
            OfObject::Speed => self.sd(|s| &s.speed, frame),
            OfObject::Accel => self.sd(|s| &s.accel, frame),
            OfObject::LateralAccel => self.row(frame).map_or(0.0, |row| {
                let (speed, turns) = (self.motion.speed(row), self.motion.yaw_rate[row]);
                let by_turning = number(Some(speed)) * self.sd(|s| &s.yaw_rate, frame);
                by_turning.hypot(number(Some(turns)) * self.sd(|s| &s.speed, frame))
            }),
        }
    }
}

fn of_pair(made: OfPair, (a, b): (&Object<'_>, &Object<'_>), frame: usize, value: f64) -> f64 {
    let (Some(i), Some(k)) = (a.row(frame), b.row(frame)) else { return 0.0 };
    let both = |pick: fn(&Deviations) -> &Vec<f64>| a.sd(pick, frame).hypot(b.sd(pick, frame));
    let (place, speed, turned) = (both(|s| &s.position), both(|s| &s.speed), a.sd(|s| &s.heading, frame));
    let (dx, dy) = (b.motion.x[k] - a.motion.x[i], b.motion.y[k] - a.motion.y[i]);
    let (sin, cos) = a.motion.heading[i].sin_cos();
    let (ahead, aside) = (dx * cos + dy * sin, dy * cos - dx * sin);
    let away = dx.hypot(dy).max(LEAST_DISTANCE_M);
    match made {
        OfPair::Distance => place,
        OfPair::Forward => place.hypot(number(Some(aside)) * turned),
        OfPair::Lateral => place.hypot(number(Some(ahead)) * turned),
        OfPair::Bearing => number(Some(place / away)).hypot(turned),
        OfPair::Closing => speed,
        OfPair::TimeToCollision => {
            let (vx, vy) = (b.motion.vx[k] - a.motion.vx[i], b.motion.vy[k] - a.motion.vy[i]);
            let closing = (vx * dx + vy * dy).abs() / away;
            let closing = number(Some(closing)).max(LEAST_SPEED_MPS);
            let gap = (number(Some(value)) * closing).max(LEAST_DISTANCE_M);
            number(Some(value)) * (place / gap).hypot(speed / closing)
        }
    }
}

#[cfg(test)]
mod tests;
