//! Raw CAN of a comma2k19 segment to [`EgoBus`], by the DBC that the user gives.

use super::recording::Recording;
use super::state_sources::{BRAKE, BRAKE_LIGHT, CRUISE, GEAR, HAZARD, StateSource, TURN};
use crate::assemble::resample::{latest, linear};
use crate::encodings::can::{CanDatabase, SignalCoding};
use std::collections::BTreeMap;
use whyroad_model::Need;
use whyroad_model::scene::{EgoBus, TurnSignal};

/// The bus that a comma device sees the car's own messages on; others are its echoes and the radar's.
const CAR_BUS: i64 = 0;
/// Steering angle and speed (83 Hz) may be missing this long and still be interpolated, s.
const SAMPLE_GAP_S: f64 = 0.25;

/// Bus signals on `frames` (seconds on the log's clock), and what the log or the DBC does not have.
pub(super) fn decode(
    recording: &Recording,
    dbc: Option<&CanDatabase>,
    frames: &[f64],
) -> (EgoBus, Vec<Need>) {
    let mut bus = EgoBus::default();
    let mut missing = Vec::new();
    let mut at_frames = |need: Need, (times, values): &(Vec<f64>, Vec<f64>), scale: f64| {
        if times.is_empty() {
            missing.push(need);
            return Vec::new();
        }
        let scaled: Vec<f64> = values.iter().map(|v| v * scale).collect();
        linear(times, &scaled, frames, SAMPLE_GAP_S)
    };
    bus.steering = at_frames(Need::SteeringAngle, &recording.steering, 1.0_f64.to_radians());
    bus.speed_mps = at_frames(Need::VehicleSpeed, &recording.speed, 1.0);
    let Some(dbc) = dbc else {
        missing.extend([Need::Brake, Need::Cruise, Need::Gear, Need::TurnSignal]);
        return (bus, missing);
    };
    let messages = by_address(recording);
    let state = |source: &StateSource| -> Option<Vec<Option<State>>> {
        let coding = dbc.signal(source.message, source.signal)?;
        let rows = messages.get(&i64::from(coding.address)).filter(|r| !r.is_empty())?;
        let times: Vec<f64> = rows.iter().map(|&i| recording.can.times[i]).collect();
        let at = latest(&times, frames, source.holds_s);
        Some(at.into_iter().map(|k| State::read(&coding, recording.can.frame(rows[k?]))).collect())
    };
    let mut state_of = |need: Need, found: bool| {
        if !found {
            missing.push(need);
        }
    };

    // The brake lights show what the car does, the pedal what the driver does; the lights take precedence.
    let brake = state(&BRAKE_LIGHT).or_else(|| state(&BRAKE));
    state_of(Need::Brake, brake.is_some());
    bus.brake = brake.into_iter().flatten().map(|s| s.map(|s| s.raw != 0)).collect();

    let cruise = state(&CRUISE);
    state_of(Need::Cruise, cruise.is_some());
    bus.cruise = cruise
        .into_iter()
        .flatten()
        .map(|s| match s?.name.as_deref() {
            Some("enabled" | "hold" | "hold_waiting_user_cmd") => Some(true),
            Some("disabled") => Some(false),
            _ => None,
        })
        .collect();

    let gear = state(&GEAR);
    state_of(Need::Gear, gear.is_some());
    bus.gear = gear
        .into_iter()
        .flatten()
        .map(|s| match s?.name.as_deref() {
            // Sport and engine-brake positions drive forwards.
            Some("D" | "S" | "B") => Some('D'),
            Some("R") => Some('R'),
            Some("N") => Some('N'),
            Some("P") => Some('P'),
            _ => None,
        })
        .collect();

    let turn = state(&TURN);
    state_of(Need::TurnSignal, turn.is_some());
    let hazard = state(&HAZARD);
    bus.turn_signal = turn
        .into_iter()
        .flatten()
        .enumerate()
        .map(|(i, s)| {
            if hazard.as_ref().and_then(|h| h[i].as_ref()).is_some_and(|h| h.raw != 0) {
                return Some(TurnSignal::Hazard);
            }
            match s?.name.as_deref() {
                Some("left") => Some(TurnSignal::Left),
                Some("right") => Some(TurnSignal::Right),
                Some("none") => Some(TurnSignal::Off),
                _ => None,
            }
        })
        .collect();
    (bus, missing)
}

/// True when none of the wanted states could be decoded by the DBC.
pub(super) fn has_no_state(bus: &EgoBus) -> bool {
    bus.brake.is_empty() && bus.cruise.is_empty() && bus.gear.is_empty() && bus.turn_signal.is_empty()
}

/// A decoded state: its number and, where the DBC names it, its name.
struct State {
    raw: i64,
    name: Option<String>,
}

impl State {
    fn read(coding: &SignalCoding, frame: &[u8]) -> Option<State> {
        let raw = coding.raw(frame)?;
        Some(State { raw, name: coding.names.get(&raw).cloned() })
    }
}

/// Rows of the car's own bus by arbitration id, each in the order of time.
fn by_address(recording: &Recording) -> BTreeMap<i64, Vec<usize>> {
    let mut rows: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (i, (&address, &source)) in recording.can.addresses.iter().zip(&recording.can.sources).enumerate() {
        if source == CAR_BUS {
            rows.entry(address).or_default().push(i);
        }
    }
    for list in rows.values_mut() {
        list.sort_by(|&a, &b| recording.can.times[a].total_cmp(&recording.can.times[b]));
    }
    rows
}
