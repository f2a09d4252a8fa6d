//! A signal over time in run lengths, as a person writes it: `10 m/s for 3 s, 10 m/s to 0 m/s for 2 s, unknown`.
//! A segment is a value or a ramp, and how long it lasts; the last one goes on to the end.

use crate::evaluate::STEP;
use whyroad_model::Nanos;
use whyroad_model::units::Unit;

/// A value at one moment.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// In the base unit.
    Number(f64),
    /// `true`, `left`, `unknown`, `never` (infinite).
    Word(String),
}

/// A stretch of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    from: Value,
    to: Option<Value>,
    lasts: Option<Nanos>,
}

/// `0.5 s`, `true`, `left`.
pub fn value(text: &str) -> Result<Value, String> {
    let text = text.trim();
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let Ok(number) = number.parse::<f64>() else { return Ok(Value::Word(text.to_owned())) };
    let unit = Unit::parse(unit.trim()).ok_or(format!("'{unit}' is not a unit"))?;
    Ok(Value::Number(number * unit.to_base))
}

/// The segments of a trace.
pub fn segments(text: &str) -> Result<Vec<Segment>, String> {
    let one = |part: &str| {
        let (values, lasts) = match part.rsplit_once(" for ") {
            Some((values, time)) => match value(time)? {
                Value::Number(s) => (values, Some(Nanos::from_secs_f64(s))),
                Value::Word(w) => return Err(format!("'{w}' is not a time")),
            },
            None => (part, None),
        };
        let (from, to) = match values.split_once(" to ") {
            Some((a, b)) => (value(a)?, Some(value(b)?)),
            None => (value(values)?, None),
        };
        Ok(Segment { from, to, lasts })
    };
    text.split(',').map(one).collect()
}

/// One value a frame of `n` frames. A ramp starts at its first value and would reach the second one where the
/// next segment begins.
pub fn expand(segments: &[Segment], n: usize) -> Vec<Value> {
    let mut out = Vec::with_capacity(n);
    for (i, s) in segments.iter().enumerate() {
        let left = n.saturating_sub(out.len());
        let last = i + 1 == segments.len();
        let frames = match s.lasts {
            Some(t) if !last => usize::try_from((t.0 + STEP.0 / 2) / STEP.0).unwrap_or(left).min(left),
            _ => left,
        };
        for k in 0..frames {
            out.push(match (&s.from, &s.to) {
                (Value::Number(a), Some(Value::Number(b))) => {
                    Value::Number(a + (b - a) * k as f64 / frames as f64)
                }
                (from, _) => from.clone(),
            });
        }
    }
    out
}
