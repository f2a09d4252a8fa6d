//! Signals of the vehicle bus at the frames.

use super::rows::BusRow;
use crate::assemble::resample::{greatest, latest, linear};
use serde_json::Value;
use whyroad_model::scene::{EgoBus, TurnSignal};

/// A state is valid for this long, and numbers are interpolated over gaps up to this, s.
const STATE_HOLDS_S: f64 = 1.0;
/// Time between frames, s.
const FRAME_S: f64 = 0.1;

/// Numbers interpolated, states as in the last message.
pub(super) fn at_frames(rows: &[BusRow], seconds: impl Fn(i64) -> f64, frames: &[f64]) -> EgoBus {
    let series = |signal: &str| {
        let mut all: Vec<(f64, &Value)> =
            rows.iter().filter(|r| r.signal == signal).map(|r| (seconds(r.time), &r.value)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.dedup_by(|b, a| b.0 <= a.0);
        all
    };
    let numbers = |signal: &str| {
        let all = series(signal);
        if all.is_empty() {
            return Vec::new();
        }
        let (times, values): (Vec<f64>, Vec<f64>) =
            all.iter().map(|(t, v)| (*t, v.as_f64().unwrap_or(f64::NAN))).unzip();
        linear(&times, &values, frames, STATE_HOLDS_S)
    };
    fn states<T>(
        all: &[(f64, &Value)],
        frames: &[f64],
        read: impl Fn(&Value) -> Option<T>,
    ) -> Vec<Option<T>> {
        if all.is_empty() {
            return Vec::new();
        }
        let times: Vec<f64> = all.iter().map(|(t, _)| *t).collect();
        latest(&times, frames, STATE_HOLDS_S).into_iter().map(|i| read(all[i?].1)).collect()
    }
    let text = |v: &Value| v.as_str().map(str::to_lowercase);
    let vertical_accel = || {
        let all = series("vertical_accel_mps2");
        let (times, values): (Vec<f64>, Vec<f64>) =
            all.iter().map(|(t, v)| (*t, v.as_f64().unwrap_or(f64::NAN))).unzip();
        if all.is_empty() { Vec::new() } else { greatest(&times, &values, frames, FRAME_S) }
    };
    EgoBus {
        vertical_accel: vertical_accel(),
        wipers: states(&series("wipers"), frames, |v| v.as_bool().or_else(|| Some(v.as_f64()? > 0.0))),
        speed_mps: numbers("speed_mps"),
        steering: numbers("steering"),
        throttle: numbers("throttle"),
        brake: states(&series("brake"), frames, |v| v.as_bool().or_else(|| Some(v.as_f64()? > 0.0))),
        gear: states(&series("gear"), frames, |v| {
            let letter = text(v)?.to_uppercase().chars().next()?;
            "PRND".contains(letter).then_some(letter)
        }),
        turn_signal: states(&series("turn_signal"), frames, |v| {
            Some(match text(v)?.as_str() {
                "off" | "none" => TurnSignal::Off,
                "left" => TurnSignal::Left,
                "right" => TurnSignal::Right,
                "hazard" | "both" => TurnSignal::Hazard,
                _ => return None,
            })
        }),
        ..EgoBus::default()
    }
}
