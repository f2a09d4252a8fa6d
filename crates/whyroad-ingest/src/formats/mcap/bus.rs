//! Signals of the vehicle bus at the frames.

use super::findings;
use super::rows::{BusRow, BusValue};
use crate::assemble::resample::{greatest, latest, linear};
use crate::report::{RowCount, SourceReport};
use whyroad_model::scene::EgoBus;

/// A state is valid for this long, and numbers are interpolated over gaps up to this, s.
const STATE_HOLDS_S: f64 = 1.0;
/// Time between frames, s.
const FRAME_S: f64 = 0.1;

/// Counts the rows that are near to a frame, and those that are not; where none is, the bus is unknown.
pub(super) fn account(
    rows: &[BusRow],
    seconds: impl Fn(i64) -> f64,
    frames: &[f64],
    label: &str,
    count: &mut RowCount,
    report: &mut SourceReport,
) {
    // From the message, ahead of the first frame of the drive, to the frame at which it no longer holds.
    let is_used = |row: &BusRow| {
        let t = seconds(row.stamp.time);
        let next = frames.partition_point(|f| *f < t - STATE_HOLDS_S);
        frames.get(next).is_some_and(|f| *f <= t + STATE_HOLDS_S)
    };
    let used = rows.iter().filter(|r| is_used(r)).count();
    count.keep("state", used);
    count.set_aside("ego_away", rows.len() - used);
    if let (0, Some(first)) = (used, rows.iter().map(|r| seconds(r.stamp.time)).reduce(f64::min)) {
        report.diagnostics.push(findings::bus_unused(label, rows.len(), first));
    }
}

/// Numbers interpolated, states as in the last message.
pub(super) fn at_frames(rows: &[BusRow], seconds: impl Fn(i64) -> f64, frames: &[f64]) -> EgoBus {
    let series = |signal: &str| {
        let mut all: Vec<(f64, BusValue)> =
            rows.iter().filter(|r| r.signal == signal).map(|r| (seconds(r.stamp.time), r.value)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.dedup_by(|b, a| b.0 <= a.0);
        all
    };
    let numbers = |signal: &str| -> (Vec<f64>, Vec<f64>) {
        let value = |v: BusValue| if let BusValue::Number(v) = v { v } else { f64::NAN };
        series(signal).into_iter().map(|(t, v)| (t, value(v))).unzip()
    };
    let interpolated = |signal: &str| {
        let (times, values) = numbers(signal);
        if times.is_empty() { Vec::new() } else { linear(&times, &values, frames, STATE_HOLDS_S) }
    };
    fn states<T>(
        all: &[(f64, BusValue)],
        frames: &[f64],
        read: impl Fn(BusValue) -> Option<T>,
    ) -> Vec<Option<T>> {
        if all.is_empty() {
            return Vec::new();
        }
        let times: Vec<f64> = all.iter().map(|(t, _)| *t).collect();
        latest(&times, frames, STATE_HOLDS_S).into_iter().map(|i| read(all[i?].1)).collect()
    }
    let flag = |v: BusValue| if let BusValue::Flag(v) = v { Some(v) } else { None };
    let vertical_accel = || {
        let (times, values) = numbers("vertical_accel_mps2");
        if times.is_empty() { Vec::new() } else { greatest(&times, &values, frames, FRAME_S) }
    };
    EgoBus {
        vertical_accel: vertical_accel(),
        wipers: states(&series("wipers"), frames, flag),
        speed_mps: interpolated("speed_mps"),
        steering: interpolated("steering"),
        throttle: interpolated("throttle"),
        brake: states(&series("brake"), frames, flag),
        gear: states(&series("gear"), frames, |v| if let BusValue::Gear(v) = v { Some(v) } else { None }),
        turn_signal: states(&series("turn_signal"), frames, |v| {
            if let BusValue::TurnSignal(v) = v { Some(v) } else { None }
        }),
        ..EgoBus::default()
    }
}

/// True when a frame has a value.
pub(super) fn has_values(bus: &EgoBus) -> bool {
    let number = [&bus.vertical_accel, &bus.speed_mps, &bus.steering, &bus.throttle];
    number.iter().any(|v| v.iter().any(|v| v.is_finite()))
        || [&bus.wipers, &bus.brake].iter().any(|v| v.iter().any(Option::is_some))
        || bus.gear.iter().any(Option::is_some)
        || bus.turn_signal.iter().any(Option::is_some)
}
