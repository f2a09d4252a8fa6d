//! A signal over time in run lengths, in a form that people write: `10 m/s for 3 s, 10 m/s to 0 m/s for 2 s, unknown`.
//! A segment is a value or a ramp, and how long it lasts; the last one extends to the end.

use super::file::Reason;
use crate::interpret::STEP;
use crate::language::Span;
use crate::language::token::unknown_unit;
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::{Bilingual, Nanos};

/// A value at one moment.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceValue {
    /// In the base unit of its dimension.
    Number(f64, Dimension),
    /// `true`, `left`, `unknown`, `never` (infinite).
    Word(String),
}

/// A stretch of a trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    from: TraceValue,
    to: Option<TraceValue>,
    lasts: Option<Nanos>,
}

/// `0.5 s`, `true`, `left`.
pub fn value(text: &str) -> Result<TraceValue, Reason> {
    let text = text.trim();
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let Ok(number) = number.parse::<f64>() else { return Ok(TraceValue::Word(text.to_owned())) };
    let unit = Unit::parse(unit.trim()).ok_or_else(|| unknown_unit(unit, Span::default()).message)?;
    Ok(TraceValue::Number(number * unit.to_base, unit.dimension))
}

/// `0.5 s`.
pub fn time(text: &str) -> Result<Nanos, Reason> {
    match value(text)? {
        TraceValue::Number(seconds, Dimension::Time) => Ok(Nanos::from_secs_f64(seconds)),
        _ => Err(Bilingual::new(
            format!("'{text}' 不是时长，应如 0.5 s"),
            format!("'{text}' is not a time such as 0.5 s"),
        )),
    }
}

/// The segments of a trace.
pub fn segments(text: &str) -> Result<Vec<Segment>, Reason> {
    let one = |part: &str| {
        let (values, lasts) = match part.rsplit_once(" for ") {
            Some((values, lasts)) => (values, Some(time(lasts)?)),
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

/// One value per frame of `n` frames. A ramp starts at its first value and would reach the second one where the
/// next segment begins.
pub fn expand(segments: &[Segment], n: usize) -> Vec<TraceValue> {
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
                (TraceValue::Number(a, unit), Some(TraceValue::Number(b, _))) => {
                    TraceValue::Number(a + (b - a) * k as f64 / frames as f64, *unit)
                }
                (from, _) => from.clone(),
            });
        }
    }
    out
}
