//! The forms in which messages state a value: times, vectors, rotations, ids, states of the bus. A value in another
//! form is an error, never a guess; null is a value that the message leaves unknown.

use crate::assemble::se3::unit;
use serde_json::Value;
use whyroad_model::scene::TurnSignal;
use whyroad_model::{Bilingual, Nanos};

/// `Ok(None)`: the message states that it is unknown.
pub(super) type Read<T> = Result<Option<T>, Form>;

/// The forms in which a value is understood, for the finding about one that is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Time,
    Vector,
    Rotation,
    Number,
    Id,
    Text,
    Flag,
    Gear,
    TurnSignal,
}

impl Form {
    /// What can be written there.
    pub fn text(self) -> Bilingual {
        match self {
            Form::Time => Bilingual::new(
                "秒与纳秒（`{sec, nanosec}`）、数字（s、ms、µs、ns）或带 UTC 偏移的 ISO 8601 文本",
                "seconds and nanoseconds (`{sec, nanosec}`), a number (s, ms, us or ns), or ISO 8601 text with an offset \
                 from UTC",
            ),
            Form::Vector => Bilingual::new(
                "米：`{x, y, z}`、`{X, Y, Z}`、`{easting, northing}` 或列表；尺寸也可为 `{length, width, height}`；经纬度须先投影",
                "meters: `{x, y, z}`, `{X, Y, Z}`, `{easting, northing}` or a list, for sizes also `{length, width, height}`; \
                 latitude and longitude have to be projected first",
            ),
            Form::Rotation => {
                Bilingual::new("单位四元数 `{x, y, z, w}`", "a quaternion `{x, y, z, w}` of length 1")
            }
            Form::Number => Bilingual::new("数字", "a number"),
            Form::Id => Bilingual::new(
                "文本、整数或 UUID 的 16 个字节",
                "a text, a whole number or the 16 bytes of a UUID",
            ),
            Form::Text => Bilingual::new("文本或数字", "a text or a number"),
            Form::Flag => {
                Bilingual::new("true、false 或数字（大于 0 为真）", "true, false or a number (true over 0)")
            }
            Form::Gear => Bilingual::new("以 P、R、N、D 开头的文本", "a text that begins with P, R, N or D"),
            Form::TurnSignal => {
                Bilingual::new("文本 off、left、right、hazard", "one of the texts off, left, right, hazard")
            }
        }
    }
}

/// A number; null is not a number.
pub(super) fn number(v: &Value) -> Read<f64> {
    if v.is_null() { Ok(None) } else { v.as_f64().map(Some).ok_or(Form::Number) }
}

/// Text or a number; an empty text is unknown.
pub(super) fn text(v: &Value) -> Read<String> {
    match v {
        Value::Null => Ok(None),
        Value::String(s) => Ok((!s.is_empty()).then(|| s.clone())),
        Value::Number(n) => Ok(Some(n.to_string())),
        _ => Err(Form::Text),
    }
}

/// Text, a number, or a UUID: `unique_identifier_msgs/UUID` or its 16 bytes.
pub(super) fn id(v: &Value) -> Read<String> {
    if let Ok(id) = text(v) {
        return Ok(id);
    }
    let bytes = v.get("uuid").unwrap_or(v).as_array().ok_or(Form::Id)?;
    let byte = |v: &Value| v.as_u64().and_then(|b| u8::try_from(b).ok());
    let bytes: Option<Vec<u8>> = bytes.iter().map(byte).collect();
    let bytes = bytes.filter(|b| b.len() == 16).ok_or(Form::Id)?;
    let hex: Vec<String> = bytes.iter().map(|b| format!("{b:02x}")).collect();
    let part = |range: std::ops::Range<usize>| hex[range].concat();
    Ok(Some([part(0..4), part(4..6), part(6..8), part(8..10), part(10..16)].join("-")))
}

/// Names of the parts of a vector.
const AXES: [[&str; 3]; 4] =
    [["x", "y", "z"], ["X", "Y", "Z"], ["easting", "northing", "altitude"], ["length", "width", "height"]];

/// A vector in the plane and its height, which may be absent and is then NaN.
pub(super) fn vector(v: &Value) -> Read<[f64; 3]> {
    let parts: [Option<&Value>; 3] = match v {
        Value::Null => return Ok(None),
        Value::Array(list) => [list.first(), list.get(1), list.get(2)],
        _ => {
            let of = |axes: &[&str; 3]| axes.map(|axis| v.get(axis));
            AXES.iter().map(of).find(|parts| parts[0].is_some()).ok_or(Form::Vector)?
        }
    };
    let part = |v: Option<&Value>| number(v?).ok().map(|v| v.unwrap_or(f64::NAN));
    let height = if parts[2].is_none() { Some(f64::NAN) } else { part(parts[2]) };
    let (Some(x), Some(y), Some(z)) = (part(parts[0]), part(parts[1]), height) else {
        return Err(Form::Vector);
    };
    Ok((x.is_finite() && y.is_finite()).then_some([x, y, z]))
}

/// A unit quaternion, scalar first.
pub(super) fn rotation(v: &Value) -> Read<[f64; 4]> {
    if v.is_null() {
        return Ok(None);
    }
    let part = |i: usize, key: &str| {
        let v = if v.is_array() { v.get(i) } else { v.get(key) };
        number(v?).ok()
    };
    let parts = [part(3, "w"), part(0, "x"), part(1, "y"), part(2, "z")];
    let [Some(w), Some(x), Some(y), Some(z)] = parts else { return Err(Form::Rotation) };
    let (Some(w), Some(x), Some(y), Some(z)) = (w, x, y, z) else { return Ok(None) };
    unit([w, x, y, z]).map(Some).ok_or(Form::Rotation)
}

/// ns. Seconds and a fraction, a number whose size shows its unit, either as text, or ISO 8601. 0 is returned as it is:
/// whether it is a time depends on the others of its topic.
pub(super) fn time(v: &Value) -> Read<i64> {
    match v {
        Value::Null => Ok(None),
        Value::Object(_) => of_parts(v).map(Some).ok_or(Form::Time),
        _ => of_size(v).or_else(|| of_text(v.as_str()?.trim())).map(Some).ok_or(Form::Time),
    }
}

/// Parts of a second, and their length in ns.
const FRACTIONS: [(&[&str], i64); 3] = [
    (&["nanosec", "nanosecs", "nsec", "nsecs", "nanos", "nanoseconds"], 1),
    (&["usec", "usecs", "micros", "microseconds"], 1_000),
    (&["msec", "msecs", "millis", "milliseconds"], 1_000_000),
];

/// Every part has to be known: one with another name would be lost.
fn of_parts(v: &Value) -> Option<i64> {
    let whole = |v: &Value| v.as_i64().or_else(|| v.as_str()?.parse().ok());
    let (mut seconds, mut nanos) = (None, 0_i64);
    for (key, part) in v.as_object()? {
        if ["sec", "secs", "seconds"].contains(&key.as_str()) {
            seconds = Some(match part.as_f64() {
                Some(v) if !part.is_i64() => exact(v * 1e9)?,
                _ => whole(part)?.checked_mul(1_000_000_000)?,
            });
        } else {
            let (_, unit) = FRACTIONS.iter().find(|(names, _)| names.contains(&key.as_str()))?;
            nanos = nanos.checked_add(whole(part)?.checked_mul(*unit)?)?;
        }
    }
    seconds?.checked_add(nanos).filter(|t| *t >= 0)
}

/// A whole number of nanoseconds that fits.
fn exact(nanos: f64) -> Option<i64> {
    (nanos.is_finite() && nanos.abs() < 9.2e18).then(|| nanos.round() as i64)
}

fn of_size(v: &Value) -> Option<i64> {
    let n = v.as_f64().filter(|n| *n >= 0.0)?;
    let to_nanos =
        [(1e17, 1.0), (1e14, 1e3), (1e11, 1e6)].iter().find(|(least, _)| n > *least).map_or(1e9, |(_, f)| *f);
    // A whole number of nanoseconds is kept exactly.
    v.as_i64().filter(|_| to_nanos == 1.0).or_else(|| exact(n * to_nanos))
}

fn of_text(text: &str) -> Option<i64> {
    if let Ok(whole) = text.parse::<i64>() {
        return of_size(&Value::from(whole));
    }
    if let Ok(number) = text.parse::<f64>() {
        return of_size(&Value::from(number));
    }
    // ISO 8601 has a T where many programs print a space.
    Nanos::parse_iso(&text.replacen(' ', "T", 1)).ok().map(|t| t.0)
}

/// True, false, or a stage.
pub(super) fn flag(v: &Value) -> Read<bool> {
    if v.is_null() {
        return Ok(None);
    }
    v.as_bool().or_else(|| Some(v.as_f64()? > 0.0)).map(Some).ok_or(Form::Flag)
}

pub(super) fn gear(v: &Value) -> Read<char> {
    if v.is_null() {
        return Ok(None);
    }
    let letter = v.as_str().and_then(|s| s.to_uppercase().chars().next());
    letter.filter(|c| "PRND".contains(*c)).map(Some).ok_or(Form::Gear)
}

pub(super) fn turn_signal(v: &Value) -> Read<TurnSignal> {
    if v.is_null() {
        return Ok(None);
    }
    Ok(Some(match v.as_str().map(str::to_lowercase).as_deref() {
        Some("off" | "none") => TurnSignal::Off,
        Some("left") => TurnSignal::Left,
        Some("right") => TurnSignal::Right,
        Some("hazard" | "both") => TurnSignal::Hazard,
        _ => return Err(Form::TurnSignal),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn times_in_any_usual_form() {
        let want = Ok(Some(1_700_000_000_500_000_000));
        for form in [
            json!({"sec": 1_700_000_000, "nanosec": 500_000_000}),
            json!({"seconds": "1700000000", "nanos": 500_000_000}),
            json!({"secs": 1_700_000_000, "nsecs": 500_000_000}),
            json!({"sec": 1_700_000_000, "usec": 500_000}),
            json!({"sec": 1_700_000_000.5}),
            json!(1_700_000_000.5),
            json!(1_700_000_000_500_i64),
            json!(1_700_000_000_500_000_000_i64),
            // 2^60 to 2^61 is in steps of 256: this one is a multiple.
            json!(1_700_000_000_500_000_000_f64),
            json!("1700000000500000000"),
            json!("1700000000.5"),
            json!("2023-11-14T22:13:20.500Z"),
            json!("2023-11-15 06:13:20.500+08:00"),
        ] {
            assert_eq!(time(&form), want, "{form}");
        }
        assert_eq!(time(&json!({"sec": 0, "nsec": 0})), Ok(Some(0)), "the first stamp of a simulation");
        assert_eq!(time(&json!(null)), Ok(None));
        for other in [
            json!("2023-11-14T22:13:20"),
            json!("soon"),
            json!(-5.0),
            json!({"sec": 5, "ticks": 3}),
            json!({"nsec": 3}),
            json!([5]),
            json!(true),
        ] {
            assert_eq!(time(&other), Err(Form::Time), "{other}");
        }
    }

    #[test]
    fn parts_of_a_vector_are_never_zero_because_they_are_absent() {
        let of = |v: Value| vector(&v).map(|v| v.map(|v| v.map(|v| if v.is_nan() { -1.0 } else { v })));
        for form in [json!({"x": 3, "y": 4}), json!({"X": 3, "Y": 4.0}), json!([3, 4])] {
            assert_eq!(of(form), Ok(Some([3.0, 4.0, -1.0])));
        }
        let utm = json!({"easting": 3, "northing": 4, "altitude": 5});
        assert_eq!(of(utm), Ok(Some([3.0, 4.0, 5.0])));
        assert_eq!(of(json!({"length": 4, "width": 2, "height": 1})), Ok(Some([4.0, 2.0, 1.0])));
        assert_eq!(of(json!({"x": null, "y": 4})), Ok(None));
        for other in
            [json!({"lat": 39.9, "lon": 116.3}), json!({"x": 3}), json!([3]), json!(3), json!("3, 4")]
        {
            assert_eq!(of(other.clone()), Err(Form::Vector), "{other}");
        }
    }

    #[test]
    fn an_id_may_be_the_bytes_of_a_uuid() {
        let bytes: Vec<u8> = (0..16).collect();
        let want = Ok(Some("00010203-0405-0607-0809-0a0b0c0d0e0f".to_owned()));
        assert_eq!(id(&json!(bytes)), want);
        assert_eq!(id(&json!({"uuid": bytes})), want);
        assert_eq!((id(&json!(7)), id(&json!(""))), (Ok(Some("7".to_owned())), Ok(None)));
        assert_eq!((id(&json!([1, 2])), id(&json!({"a": 1}))), (Err(Form::Id), Err(Form::Id)));
    }
}
