//! Time. One clock per drive: nanoseconds since the Unix epoch as the log states them. Nothing here reads the machine's
//! clock.

use crate::Bilingual;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Nanoseconds since 1970-01-01T00:00:00Z, or a difference of two such times.
///
/// In messages it is an ISO 8601 string in UTC with at least three fraction digits
/// (DATA_FORMAT.md 3.1) and as many as are needed to be exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Nanos(pub i64);

impl Nanos {
    /// One second.
    pub const SECOND: Nanos = Nanos(1_000_000_000);

    /// From seconds, rounded to the nearest nanosecond.
    pub fn from_secs_f64(seconds: f64) -> Self {
        Self((seconds * 1e9).round() as i64)
    }

    /// As seconds. Exact to about 100 ns for times, far better for differences.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 / 1e9
    }

    /// Seconds from `earlier` to `self`.
    pub fn seconds_since(self, earlier: Nanos) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 / 1e9
    }

    /// This time moved by `seconds`; limited to the first or last representable time.
    pub fn plus_secs(self, seconds: f64) -> Self {
        Self(self.0.saturating_add(Self::from_secs_f64(seconds).0))
    }

    /// Parses an ISO 8601 date-time that states its offset from UTC (RFC 3339). Errors say what is wrong.
    pub fn parse_iso(s: &str) -> Result<Self, TimeError> {
        // jiff accepts more than the format allows (a space for `T`, no seconds), so the shape is checked first.
        let b = s.as_bytes();
        let digits = |r: std::ops::Range<usize>| b.get(r).is_some_and(|d| d.iter().all(u8::is_ascii_digit));
        let shaped = b.len() >= 20
            && digits(0..4)
            && b[4] == b'-'
            && digits(5..7)
            && b[7] == b'-'
            && digits(8..10)
            && b[10] == b'T'
            && digits(11..13)
            && b[13] == b':'
            && digits(14..16)
            && b[16] == b':'
            && digits(17..19);
        if !shaped {
            return Err(TimeError(s.to_owned()));
        }
        let t: jiff::Timestamp = s.parse().map_err(|_| TimeError(s.to_owned()))?;
        i64::try_from(t.as_nanosecond()).map(Self).map_err(|_| TimeError(s.to_owned()))
    }
}

/// A text that is not an ISO 8601 date-time with an offset.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not an ISO 8601 date-time such as 2026-01-15T10:30:00.000Z")]
pub struct TimeError(pub String);

impl TimeError {
    /// What is wrong, in both languages.
    pub fn text(&self) -> Bilingual {
        Bilingual::new("应为带时区的 ISO 8601 时间，例如 2026-01-15T10:30:00.000Z", self.to_string())
    }
}

impl fmt::Display for Nanos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Ok(t) = jiff::Timestamp::from_nanosecond(i128::from(self.0)) else {
            return write!(f, "{}ns", self.0);
        };
        let digits = match self.0.rem_euclid(1_000_000_000) {
            n if n % 1_000_000 == 0 => 3,
            n if n % 1_000 == 0 => 6,
            _ => 9,
        };
        write!(f, "{t:.digits$}")
    }
}

impl std::ops::Add for Nanos {
    type Output = Nanos;
    fn add(self, rhs: Nanos) -> Nanos {
        Nanos(self.0.saturating_add(rhs.0))
    }
}

impl std::ops::Sub for Nanos {
    type Output = Nanos;
    fn sub(self, rhs: Nanos) -> Nanos {
        Nanos(self.0.saturating_sub(rhs.0))
    }
}

impl Serialize for Nanos {
    fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Nanos {
    fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct V;
        impl serde::de::Visitor<'_> for V {
            type Value = Nanos;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an ISO 8601 date-time")
            }
            fn visit_str<E: serde::de::Error>(self, s: &str) -> Result<Nanos, E> {
                Nanos::parse_iso(s).map_err(E::custom)
            }
        }
        d.deserialize_str(V)
    }
}

impl JsonSchema for Nanos {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "DateTime".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "format": "date-time" })
    }
}

/// Frames `start..end`, half open: the end frame is not part of the range (LABELING.md 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameRange {
    /// First frame.
    pub start: usize,
    /// One past the last frame.
    pub end: usize,
}

impl FrameRange {
    /// `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// Number of frames.
    pub fn len(self) -> usize {
        self.end.saturating_sub(self.start)
    }

    /// True when there is no frame in the range.
    pub fn is_empty(self) -> bool {
        self.end <= self.start
    }

    /// True when `frame` is in the range.
    pub fn contains(self, frame: usize) -> bool {
        self.start <= frame && frame < self.end
    }

    /// Frames in both ranges.
    pub fn intersect(self, other: FrameRange) -> FrameRange {
        FrameRange { start: self.start.max(other.start), end: self.end.min(other.end) }
    }
}

/// The frame nearest to `time`; one past the last frame for a time after it, as ends of ranges are.
pub fn frame_at(times: &[Nanos], time: Nanos) -> usize {
    let after = times.partition_point(|t| *t < time);
    let Some(before) = after.checked_sub(1) else { return 0 };
    match times.get(after) {
        Some(t) if (t.0 - time.0) < (time.0 - times[before].0) => after,
        Some(_) => before,
        // The end of the last frame's range is one past it.
        None => {
            if time > times[before] {
                after
            } else {
                before
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iso_times_round_trip_exactly() {
        // Expected texts: DATA_FORMAT.md 3.3 and RFC 3339.
        for text in
            ["2026-01-15T10:30:15.500Z", "1980-01-06T00:24:13.660357Z", "2026-01-01T00:00:00.000000001Z"]
        {
            assert_eq!(Nanos::parse_iso(text).unwrap().to_string(), text);
        }
        assert_eq!(
            Nanos::parse_iso("2026-01-15T18:30:00.000+08:00").unwrap().to_string(),
            "2026-01-15T10:30:00.000Z"
        );
    }

    #[test]
    fn what_is_not_iso_is_refused() {
        for text in [
            "",
            "2026-01-15",
            "2026-01-15 10:30:00Z",
            "2026-01-15T10:30:00",
            "2026-13-15T10:30:00Z",
            "10:30",
            "1768473000",
        ] {
            assert!(Nanos::parse_iso(text).is_err(), "{text}");
        }
    }
}
