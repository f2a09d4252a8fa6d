//! The CAN bus expansion: `can_bus/scene-0001_vehicle_monitor.json` (2 Hz) and `..._steeranglefeedback.json` (100 Hz).
//! Units and codes: the expansion's own README (devkit 1.2).

use crate::assemble::resample::{latest, linear};
use crate::encodings::input::Folder;
use serde_json::Value;
use whyroad_model::scene::{EgoBus, TurnSignal};

/// States come at 2 Hz; one that is older than this is no longer used, s.
const STATE_HOLDS_S: f64 = 0.75;
/// Steering at 100 Hz: a gap longer than this is not filled, s.
const STEERING_GAP_S: f64 = 0.25;
const MPS_PER_KMH: f64 = 1.0 / 3.6;
/// The pedal's full range.
const FULL_THROTTLE: f64 = 1000.0;

/// What the bus of a scene contains.
#[derive(Default)]
pub(super) struct BusReading {
    pub bus: EgoBus,
    /// The files that were there: name and content.
    pub files: Vec<(String, Vec<u8>)>,
    /// Names of those that are not lists of messages.
    pub broken: Vec<String>,
}

/// The bus at the frames (s after `zero_us`).
pub(super) fn read(can_bus: Folder<'_>, scene: &str, zero_us: i64, frames: &[f64]) -> BusReading {
    let (mut files, mut broken) = (Vec::new(), Vec::new());
    let mut messages = |what: &str| -> Vec<(f64, Value)> {
        let name = format!("{scene}_{what}.json");
        let Some(Ok(bytes)) = can_bus.file(&name).map(|f| f.bytes()) else { return Vec::new() };
        let rows = serde_json::from_slice::<Vec<Value>>(&bytes);
        files.push((name.clone(), bytes.into_owned()));
        let Ok(rows) = rows else {
            broken.push(name);
            return Vec::new();
        };
        let timed =
            |row: Value| Some((row.get("utime")?.as_i64()?.saturating_sub(zero_us) as f64 / 1e6, row));
        let mut rows: Vec<(f64, Value)> = rows.into_iter().filter_map(timed).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.dedup_by(|b, a| b.0 <= a.0);
        rows
    };
    let monitor = messages("vehicle_monitor");
    let steering = messages("steeranglefeedback");
    let number = |rows: &[(f64, Value)], key: &str| -> Vec<f64> {
        rows.iter().map(|(_, r)| r.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN)).collect()
    };
    let times = |rows: &[(f64, Value)]| rows.iter().map(|(t, _)| *t).collect::<Vec<_>>();
    let mut bus = EgoBus::default();
    if !steering.is_empty() {
        // The README has right turns positive.
        let left = linear(&times(&steering), &number(&steering, "value"), frames, STEERING_GAP_S);
        bus.steering = left.into_iter().map(|v| -v).collect();
    }
    if !monitor.is_empty() {
        let held = latest(&times(&monitor), frames, STATE_HOLDS_S);
        let at = |i: &Option<usize>, key: &str| monitor[(*i)?].1.get(key)?.as_f64();
        let between = |key: &str, scale: f64| -> Vec<f64> {
            let values = linear(&times(&monitor), &number(&monitor, key), frames, STATE_HOLDS_S);
            values.into_iter().map(|v| v * scale).collect()
        };
        bus.speed_mps = between("vehicle_speed", MPS_PER_KMH);
        bus.throttle = between("throttle", 1.0 / FULL_THROTTLE);
        // 1 not pressed, 2 pressed, 3 confirmed pressed.
        bus.brake = held.iter().map(|i| at(i, "brake_switch").map(|v| v >= 2.0)).collect();
        let gear = |v: f64| match v as i64 {
            0 => Some('P'),
            7 => Some('D'),
            _ => None,
        };
        bus.gear = held.iter().map(|i| at(i, "gear_position").and_then(gear)).collect();
        let signal = |i: &Option<usize>| {
            Some(match (at(i, "left_signal")? > 0.0, at(i, "right_signal")? > 0.0) {
                (true, true) => TurnSignal::Hazard,
                (true, false) => TurnSignal::Left,
                (false, true) => TurnSignal::Right,
                (false, false) => TurnSignal::Off,
            })
        };
        bus.turn_signal = held.iter().map(signal).collect();
    }
    BusReading { bus, files, broken }
}
