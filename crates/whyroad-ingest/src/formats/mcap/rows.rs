//! From a message, as JSON, to rows: poses of the ego, objects, bus signals.

use super::mapping::{Frame, Role, Rule};
use crate::assemble::se3::{Se3, unit};
use serde_json::Value;

pub(super) struct EgoRow {
    /// ns
    pub time: i64,
    pub pose: Se3,
    /// Forward and left, m/s.
    pub velocity: Option<[f64; 2]>,
    pub frame_id: String,
    pub child_frame_id: String,
}

pub(super) struct ObjectRow {
    /// ns
    pub time: i64,
    pub id: String,
    pub class: String,
    pub pose: Se3,
    pub size: [f64; 3],
    pub velocity: Option<[f64; 2]>,
    pub frame_id: String,
    pub frame: Option<Frame>,
}

pub(super) struct BusRow {
    /// ns
    pub time: i64,
    /// Name of the signal, as in the rule.
    pub signal: &'static str,
    pub value: Value,
}

/// Rows of one message, and how many could not be used, with the reason.
#[derive(Default)]
pub(super) struct Rows {
    pub ego: Vec<EgoRow>,
    pub objects: Vec<ObjectRow>,
    pub bus: Vec<BusRow>,
    pub dropped: Vec<&'static str>,
}

/// The value at a path. In a list of `{key, value}` (Foxglove's metadata) a part is also the name of a key.
fn at<'v>(value: &'v Value, path: &str) -> Option<&'v Value> {
    path.split('.').try_fold(value, |v, part| match v {
        Value::Array(list) => match part.parse::<usize>() {
            Ok(i) => list.get(i),
            Err(_) => list.iter().find(|e| e.get("key").and_then(Value::as_str) == Some(part))?.get("value"),
        },
        _ => v.get(part),
    })
}

fn get<'v>(value: &'v Value, path: &Option<String>) -> Option<&'v Value> {
    at(value, path.as_deref()?)
}

/// Text or whole number.
fn text(v: Option<&Value>) -> Option<String> {
    match v? {
        Value::String(s) if !s.is_empty() => Some(s.clone()),
        Value::Number(n) => Some(n.to_string()),
        _ => None,
    }
}

/// A vector: `{x, y, z}` or a list; absent parts are 0.
fn vector(v: Option<&Value>) -> Option<[f64; 3]> {
    let v = v?;
    let part = |i: usize, key: &str| match v {
        Value::Array(list) => list.get(i).map_or(Some(0.0), Value::as_f64),
        _ => v.get(key).map_or(Some(0.0), Value::as_f64),
    };
    (v.is_object() || v.is_array()).then_some(())?;
    Some([part(0, "x")?, part(1, "y")?, part(2, "z")?]).filter(|p| p.iter().all(|v| v.is_finite()))
}

/// A time in any of the usual forms: seconds and nanoseconds, or a number whose size shows its unit. 0 is not a time.
fn time(v: Option<&Value>) -> Option<i64> {
    let v = v?;
    let part = |keys: [&str; 3]| keys.iter().find_map(|k| v.get(*k)).and_then(Value::as_i64);
    if let Some(seconds) = part(["sec", "seconds", "secs"]) {
        let nanos = part(["nsec", "nanosec", "nanos"]).unwrap_or(0);
        return seconds.checked_mul(1_000_000_000)?.checked_add(nanos).filter(|t| *t != 0);
    }
    let n = v.as_f64().filter(|n| *n > 0.0)?;
    let to_nanos =
        [(1e17, 1.0), (1e14, 1e3), (1e11, 1e6)].iter().find(|(least, _)| n > *least).map_or(1e9, |(_, f)| *f);
    // A whole number of nanoseconds is kept exactly.
    if to_nanos == 1.0 { v.as_i64() } else { Some((n * to_nanos).round() as i64) }
}

fn pose(message: &Value, rule: &Rule) -> Result<Se3, &'static str> {
    let t = vector(get(message, &rule.position)).ok_or("no_position")?;
    let q = match (get(message, &rule.orientation), get(message, &rule.heading).and_then(Value::as_f64)) {
        (_, Some(heading)) => [(heading / 2.0).cos(), 0.0, 0.0, (heading / 2.0).sin()],
        (Some(q), None) => {
            let part = |key: &str| q.get(key).and_then(Value::as_f64).unwrap_or(0.0);
            [part("w"), part("x"), part("y"), part("z")]
        }
        (None, None) => return Err("invalid"),
    };
    Ok(Se3 { q: unit(q).ok_or("invalid")?, t })
}

/// The rows of a message.
pub(super) fn of(message: &Value, rule: &Rule, log_time: i64) -> Rows {
    let mut out = Rows::default();
    let stamp = |v: &Value| time(get(v, &rule.time));
    let now = stamp(message).unwrap_or(log_time);
    let frame_of = |v: &Value| text(get(v, &rule.frame_id));
    match rule.role {
        Role::Ignore => {}
        Role::Ego => match pose(message, rule) {
            Ok(pose) => out.ego.push(EgoRow {
                time: now,
                pose,
                velocity: vector(get(message, &rule.velocity)).map(|v| [v[0], v[1]]),
                frame_id: frame_of(message).unwrap_or_default(),
                child_frame_id: text(message.get("child_frame_id")).unwrap_or_default(),
            }),
            Err(reason) => out.dropped.push(reason),
        },
        Role::Objects => {
            let list = match &rule.list {
                None => Some(message),
                Some(path) => at(message, path),
            };
            let Some(list) = list.and_then(Value::as_array) else {
                out.dropped.push("no_list");
                return out;
            };
            for item in list {
                let object =
                    text(get(item, &rule.id)).ok_or("no_id").and_then(|id| Ok((id, pose(item, rule)?)));
                match object {
                    Err(reason) => out.dropped.push(reason),
                    Ok((id, pose)) => out.objects.push(ObjectRow {
                        time: stamp(item).unwrap_or(now),
                        id,
                        class: text(get(item, &rule.class)).unwrap_or_default(),
                        pose,
                        size: vector(get(item, &rule.size)).unwrap_or([f64::NAN; 3]),
                        velocity: vector(get(item, &rule.velocity)).map(|v| [v[0], v[1]]),
                        frame_id: frame_of(item).or_else(|| frame_of(message)).unwrap_or_default(),
                        frame: rule.frame,
                    }),
                }
            }
        }
        Role::Bus => {
            let signals = [
                ("speed_mps", &rule.speed_mps),
                ("steering", &rule.steering),
                ("brake", &rule.brake),
                ("wipers", &rule.wipers),
                ("vertical_accel_mps2", &rule.vertical_accel_mps2),
                ("throttle", &rule.throttle),
                ("gear", &rule.gear),
                ("turn_signal", &rule.turn_signal),
            ];
            for (signal, path) in signals {
                if let Some(value) = get(message, path) {
                    out.bus.push(BusRow { time: now, signal, value: value.clone() });
                }
            }
            if out.bus.is_empty() {
                out.dropped.push("invalid");
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_any_usual_form() {
        let read = |v: Value| time(Some(&v));
        let want = Some(1_700_000_000_500_000_000);
        assert_eq!(read(serde_json::json!({"sec": 1_700_000_000, "nanosec": 500_000_000})), want);
        assert_eq!(read(serde_json::json!({"seconds": 1_700_000_000, "nanos": 500_000_000})), want);
        assert_eq!(read(serde_json::json!(1_700_000_000.5)), want);
        assert_eq!(read(serde_json::json!(1_700_000_000_500i64)), want);
        assert_eq!(read(serde_json::json!(1_700_000_000_500_000_000i64)), want);
        assert_eq!(read(serde_json::json!({"sec": 0, "nsec": 0})), None);
    }
}
