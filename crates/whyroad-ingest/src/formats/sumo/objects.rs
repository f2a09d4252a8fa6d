//! Objects of FCD as scene tables want them: motion of the box center, the ego's bus, tracks.

use super::fcd::{Fcd, Object, Sample};
use super::frames;
use super::vehicle_types::{IsPerson, VehicleType, VehicleTypes};
use crate::assemble::angles::wrap_angle;
use crate::assemble::plausibility::forget_impossible;
use crate::assemble::resample::MAX_GAP_S;
use std::collections::BTreeMap;
use whyroad_model::scene::{Ego, EgoBus, Motion, Track, TurnSignal};
use whyroad_model::{Nanos, TrackId};

/// A sideways step of more than this in 0.1 s is a jump, not a motion, m.
const MAX_SIDE_STEP_M: f64 = 1.0;

/// What is noticed while objects are brought to frames.
#[derive(Default)]
pub(super) struct Notes {
    pub assumed: BTreeMap<String, usize>,
    pub jumps: usize,
    pub jump_example: String,
    pub impossible: BTreeMap<String, usize>,
}

impl Notes {
    pub fn assume(&mut self, type_id: &str, known: bool) {
        if !known {
            *self.assumed.entry(type_id.to_owned()).or_default() += 1;
        }
    }
}

/// The object's samples at those frames in which it is there: (frame, sample).
pub(super) fn samples_at(object: &Object, times: &[i64]) -> Vec<(u32, Sample)> {
    let frame = |(i, &t): (usize, &i64)| Some((u32::try_from(i).ok()?, frames::at(&object.samples, t)?));
    times.iter().enumerate().filter_map(frame).collect()
}

/// How much later than its frame each row was known; empty when none was.
fn lags(rows: &[(u32, Sample)]) -> Vec<Nanos> {
    if rows.iter().all(|(_, s)| s.lag == 0) {
        return Vec::new();
    }
    rows.iter().map(|(_, s)| Nanos(s.lag)).collect()
}

/// Motion of the box center.
fn motion(
    id: &str,
    rows: &[(u32, Sample)],
    shape: &VehicleType,
    is_person: IsPerson,
    notes: &mut Notes,
) -> Motion {
    let back = if is_person == IsPerson::Yes { 0.0 } else { shape.length_m / 2.0 };
    let mut m = Motion::unknown(rows.len());
    for (i, (_, s)) in rows.iter().enumerate() {
        m.heading[i] = s.heading;
        m.x[i] = s.x - back * s.heading.cos();
        m.y[i] = s.y - back * s.heading.sin();
        // SUMO's z is the road's surface.
        m.z[i] = s.z + shape.height_m / 2.0;
    }
    let seconds: Vec<f64> =
        rows.iter().map(|(_, s)| s.time.saturating_sub(rows[0].1.time) as f64 / 1e9).collect();
    let jumped = |i: usize| is_person == IsPerson::No && side_jump(&rows[i - 1].1, &rows[i].1);
    for i in (1..rows.len()).filter(|&i| jumped(i)) {
        if notes.jumps == 0 {
            notes.jump_example = format!("{id} at {} s", rows[i].1.time as f64 / 1e9);
        }
        notes.jumps += 1;
    }
    if is_person == IsPerson::No {
        // A person's speed is that of the walk, whichever direction the person faces.
        m.forward = empty_when_unknown(rows.iter().map(|(_, s)| s.speed).collect());
        m.accel = rows.iter().map(|(_, s)| s.accel).collect();
    }
    let rows = forget_impossible(shape.class, &seconds, &mut m);
    if rows > 0 {
        notes.impossible.insert(id.to_owned(), rows);
    }
    m
}

/// True when the front bumper went sideways faster than any vehicle can.
fn side_jump(a: &Sample, b: &Sample) -> bool {
    let dt = b.time.saturating_sub(a.time) as f64 / 1e9;
    if dt > MAX_GAP_S {
        return false;
    }
    let middle = a.heading + wrap_angle(b.heading - a.heading) / 2.0;
    let side = (b.y - a.y) * middle.cos() - (b.x - a.x) * middle.sin();
    side.abs() > MAX_SIDE_STEP_M * (dt / 0.1).max(1.0)
}

/// SUMO's `signals` bits (TraCI documentation, "Signaling"): 1 right, 2 left indicator, 4 hazard, 8 brake light.
fn turn_signal(bits: u32) -> TurnSignal {
    match (bits & 4 != 0, bits & 2 != 0, bits & 1 != 0) {
        (true, _, _) | (_, true, true) => TurnSignal::Hazard,
        (_, true, false) => TurnSignal::Left,
        (_, false, true) => TurnSignal::Right,
        _ => TurnSignal::Off,
    }
}

fn empty_when_unknown(values: Vec<f64>) -> Vec<f64> {
    if values.iter().any(|v| !v.is_nan()) { values } else { Vec::new() }
}

fn empty_when_never_told<T>(values: Vec<Option<T>>) -> Vec<Option<T>> {
    if values.iter().any(Option::is_some) { values } else { Vec::new() }
}

pub(super) fn ego_table(rows: &[(u32, Sample)], shape: &VehicleType, notes: &mut Notes) -> Ego {
    let signals = |f: &dyn Fn(u32) -> TurnSignal| rows.iter().map(|(_, s)| s.signals.map(f)).collect();
    Ego {
        length_m: shape.length_m,
        width_m: shape.width_m,
        height_m: shape.height_m,
        reference_to_centre_m: -shape.length_m / 2.0,
        motion: motion("ego", rows, shape, IsPerson::No, notes),
        bus: EgoBus {
            turn_signal: empty_when_never_told(signals(&turn_signal)),
            brake: empty_when_never_told(rows.iter().map(|(_, s)| s.signals.map(|b| b & 8 != 0)).collect()),
            aeb: empty_when_never_told(rows.iter().map(|(_, s)| s.aeb).collect()),
            ..EgoBus::default()
        },
        known_at: lags(rows),
    }
}

/// Everything but the ego.
pub(super) fn tracks(
    fcd: &Fcd,
    ego: &str,
    times: &[i64],
    types: &VehicleTypes,
    notes: &mut Notes,
) -> Vec<Track> {
    let mut out = Vec::new();
    for (id, object) in fcd.objects.iter().filter(|(id, _)| *id != ego) {
        let rows = samples_at(object, times);
        if rows.is_empty() {
            continue;
        }
        let (shape, known) = types.get(&object.type_id, object.is_person);
        notes.assume(&object.type_id, known);
        let n = rows.len();
        let signals = rows.iter().map(|(_, s)| s.signals.map(turn_signal)).collect();
        out.push(Track {
            id: TrackId::from(id.as_str()),
            class: shape.class,
            source_class: format!("{}/{}", shape.vclass, object.type_id),
            frames: rows.iter().map(|r| r.0).collect(),
            motion: motion(id, &rows, &shape, object.is_person, notes),
            length_m: vec![shape.length_m; n],
            width_m: vec![shape.width_m; n],
            height_m: vec![shape.height_m; n],
            interior_points: vec![f64::NAN; n],
            turn_signal: empty_when_never_told(signals),
            known_at: lags(&rows),
            // Visibility comes from the sensor model, where one is requested.
            ..Track::default()
        });
    }
    out
}
