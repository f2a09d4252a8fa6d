//! The cells of an Arrow array of any simple type as numbers, integers or texts. The rules are those of Arrow's own
//! `cast` (arrow-cast with its default options), which compiles for minutes and is needed for nothing else: a cell
//! that cannot be brought to the type is null, and an array whose type cannot is an error. Not for lists and structs.

use arrow_array::cast::AsArray;
use arrow_array::types::{
    Date32Type, Date64Type, Decimal128Type, DurationMicrosecondType, DurationMillisecondType,
    DurationNanosecondType, DurationSecondType, Float16Type, Float32Type, Float64Type, Int8Type, Int16Type,
    Int32Type, Int64Type, TimestampMicrosecondType, TimestampMillisecondType, TimestampNanosecondType,
    TimestampSecondType, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrowPrimitiveType};
use arrow_schema::{DataType, TimeUnit};
use whyroad_model::Nanos;

/// Bytes of text that any column may have, and additional ones per byte of its keys: a dictionary or a view holds a
/// text once that many rows share.
pub(crate) const FREE_TEXT: usize = 64 << 20;
const MAX_TEXT_RATIO: usize = 64;
/// Size of a view.
const VIEW_BYTES: usize = 16;

/// Cells as numbers: integers, floats, decimals, truth values (1 and 0), times (in their own unit) and texts.
pub(crate) fn numbers(array: &dyn Array) -> Result<Vec<Option<f64>>, String> {
    simple(array, "a number", &|cell| match cell {
        Cell::Integer(v) => Some(v as f64),
        Cell::Float(v) => Some(v),
        Cell::Single(v) => Some(f64::from(v)),
        Cell::Decimal(v, scale) => Some(v as f64 / 10_f64.powi(i32::from(scale))),
        Cell::Bool(v) => Some(f64::from(u8::from(v))),
        Cell::Time(v, _) => Some(v as f64),
        Cell::Text(text) => text.parse().ok(),
    })
}

/// Cells as integers: fractions are cut off; what does not fit is null.
pub(crate) fn integers(array: &dyn Array) -> Result<Vec<Option<i64>>, String> {
    // The largest i64 is not an f64; the next float, 2^63, no longer fits.
    let whole = |v: f64| (v.trunc() >= i64::MIN as f64 && v.trunc() < -(i64::MIN as f64)).then_some(v as i64);
    simple(array, "an integer", &|cell| match cell {
        Cell::Integer(v) => i64::try_from(v).ok(),
        Cell::Float(v) => whole(v),
        Cell::Single(v) => whole(f64::from(v)),
        Cell::Decimal(v, scale) => {
            let power = 10_i128.checked_pow(u32::from(scale.unsigned_abs()))?;
            i64::try_from(if scale < 0 { v.checked_mul(power)? } else { v / power }).ok()
        }
        Cell::Bool(v) => Some(i64::from(v)),
        Cell::Time(v, _) => Some(v),
        Cell::Text(text) => text.parse().ok(),
    })
}

/// Cells as texts: numbers in their shortest form, times in ISO 8601, with `Z` where the column states a time zone (the
/// cells are then in UTC). `left` is what the column may still take of shared texts, bytes; it begins with
/// [`FREE_TEXT`].
pub(crate) fn texts(array: &dyn Array, left: &mut usize) -> Result<Vec<Option<String>>, String> {
    texts_with(array, left, |v, kind| kind.text(v))
}

/// The same with times as nanoseconds since 1970.
pub(crate) fn nanosecond_texts(array: &dyn Array, left: &mut usize) -> Result<Vec<Option<String>>, String> {
    texts_with(array, left, |v, kind| kind.nanoseconds(v).map(|n| n.to_string()))
}

fn texts_with(
    array: &dyn Array,
    left: &mut usize,
    time: impl Fn(i64, TimeKind) -> Option<String>,
) -> Result<Vec<Option<String>>, String> {
    if matches!(array.data_type(), DataType::Dictionary(_, _) | DataType::Utf8View) {
        let length = |cell: Cell<'_>| if let Cell::Text(text) = cell { Some(text.len()) } else { None };
        let lengths = simple(array, "a text", &length)?.into_iter().flatten();
        let keys = array
            .as_any_dictionary_opt()
            .map_or_else(|| VIEW_BYTES * array.len(), |d| d.keys().get_array_memory_size());
        *left = left.saturating_add(keys.saturating_mul(MAX_TEXT_RATIO));
        *left = left
            .checked_sub(lengths.fold(0, usize::saturating_add))
            .ok_or("it repeats long texts until they fill the memory")?;
    }
    simple(array, "a text", &|cell| match cell {
        Cell::Integer(v) => Some(v.to_string()),
        Cell::Float(v) => Some(format!("{v:?}")),
        Cell::Single(v) => Some(format!("{v:?}")),
        Cell::Decimal(v, scale) => Some(decimal_text(v, scale)),
        Cell::Bool(v) => Some(v.to_string()),
        Cell::Time(v, kind) => time(v, kind),
        Cell::Text(text) => Some(text.to_owned()),
    })
}

/// One cell that is not null.
enum Cell<'a> {
    Integer(i128),
    Float(f64),
    /// Kept apart, because its shortest text differs from that of the same number as an `f64`.
    Single(f32),
    /// Digits, and how many of them are behind the point.
    Decimal(i128, i8),
    Bool(bool),
    Time(i64, TimeKind),
    Text(&'a str),
}

/// What an integer that is a time counts.
#[derive(Clone, Copy)]
enum TimeKind {
    /// Days since 1970-01-01.
    Day,
    /// Units since 1970-01-01T00:00; true where the column states a time zone, so that they count from UTC.
    Moment(TimeUnit, bool),
    /// Units, without a start date.
    Length,
}

impl TimeKind {
    /// Since 1970; `None` for lengths, and before 1677 or after 2262.
    fn nanoseconds(self, v: i64) -> Option<i64> {
        let nanos = match self {
            TimeKind::Day => i128::from(v) * 86_400_000_000_000,
            TimeKind::Moment(TimeUnit::Second, _) => i128::from(v) * 1_000_000_000,
            TimeKind::Moment(TimeUnit::Millisecond, _) => i128::from(v) * 1_000_000,
            TimeKind::Moment(TimeUnit::Microsecond, _) => i128::from(v) * 1_000,
            TimeKind::Moment(TimeUnit::Nanosecond, _) => i128::from(v),
            TimeKind::Length => return None,
        };
        i64::try_from(nanos).ok()
    }

    /// ISO 8601; `None` as above.
    fn text(self, v: i64) -> Option<String> {
        let text = Nanos(self.nanoseconds(v)?).to_string();
        let (date, _) = text.split_once('T')?;
        Some(match self {
            TimeKind::Day => date.to_owned(),
            TimeKind::Moment(_, true) => text,
            _ => text.trim_end_matches('Z').to_owned(),
        })
    }
}

/// `v` with a point `scale` digits from its end.
fn decimal_text(v: i128, scale: i8) -> String {
    let Ok(behind) = usize::try_from(scale) else {
        return format!("{v}{}", "0".repeat(usize::from(scale.unsigned_abs())));
    };
    if behind == 0 {
        return v.to_string();
    }
    let digits = format!("{:0width$}", v.unsigned_abs(), width = behind + 1);
    let (whole, part) = digits.split_at(digits.len() - behind);
    format!("{}{whole}.{part}", if v < 0 { "-" } else { "" })
}

/// Applies `read` to each cell that is not null.
fn simple<T: Clone>(
    array: &dyn Array,
    wanted: &str,
    read: &dyn Fn(Cell<'_>) -> Option<T>,
) -> Result<Vec<Option<T>>, String> {
    fn of<P: ArrowPrimitiveType, T>(
        array: &dyn Array,
        read: impl Fn(P::Native) -> Option<T>,
    ) -> Vec<Option<T>> {
        array.as_primitive::<P>().iter().map(|v| v.and_then(&read)).collect()
    }
    macro_rules! primitive {
        ($kind:ty, $v:ident => $cell:expr) => {
            of::<$kind, T>(array, |$v| read($cell))
        };
    }
    use TimeKind::{Day, Length, Moment};
    let text = |cells: &mut dyn Iterator<Item = Option<&str>>| -> Vec<Option<T>> {
        cells.map(|text| text.and_then(|text| read(Cell::Text(text)))).collect()
    };
    Ok(match array.data_type() {
        DataType::Null => vec![None; array.len()],
        DataType::Boolean => array.as_boolean().iter().map(|v| v.and_then(|v| read(Cell::Bool(v)))).collect(),
        DataType::Int8 => primitive!(Int8Type, v => Cell::Integer(v.into())),
        DataType::Int16 => primitive!(Int16Type, v => Cell::Integer(v.into())),
        DataType::Int32 => primitive!(Int32Type, v => Cell::Integer(v.into())),
        DataType::Int64 => primitive!(Int64Type, v => Cell::Integer(v.into())),
        DataType::UInt8 => primitive!(UInt8Type, v => Cell::Integer(v.into())),
        DataType::UInt16 => primitive!(UInt16Type, v => Cell::Integer(v.into())),
        DataType::UInt32 => primitive!(UInt32Type, v => Cell::Integer(v.into())),
        DataType::UInt64 => primitive!(UInt64Type, v => Cell::Integer(v.into())),
        DataType::Float16 => primitive!(Float16Type, v => Cell::Single(v.to_f32())),
        DataType::Float32 => primitive!(Float32Type, v => Cell::Single(v)),
        DataType::Float64 => primitive!(Float64Type, v => Cell::Float(v)),
        DataType::Decimal128(_, scale) => primitive!(Decimal128Type, v => Cell::Decimal(v, *scale)),
        DataType::Date32 => primitive!(Date32Type, v => Cell::Time(v.into(), Day)),
        DataType::Date64 => primitive!(Date64Type, v => Cell::Time(v, Moment(TimeUnit::Millisecond, false))),
        DataType::Timestamp(unit, zone) => match unit {
            TimeUnit::Second => {
                primitive!(TimestampSecondType, v => Cell::Time(v, Moment(*unit, zone.is_some())))
            }
            TimeUnit::Millisecond => {
                primitive!(TimestampMillisecondType, v => Cell::Time(v, Moment(*unit, zone.is_some())))
            }
            TimeUnit::Microsecond => {
                primitive!(TimestampMicrosecondType, v => Cell::Time(v, Moment(*unit, zone.is_some())))
            }
            TimeUnit::Nanosecond => {
                primitive!(TimestampNanosecondType, v => Cell::Time(v, Moment(*unit, zone.is_some())))
            }
        },
        DataType::Duration(unit) => match unit {
            TimeUnit::Second => primitive!(DurationSecondType, v => Cell::Time(v, Length)),
            TimeUnit::Millisecond => primitive!(DurationMillisecondType, v => Cell::Time(v, Length)),
            TimeUnit::Microsecond => primitive!(DurationMicrosecondType, v => Cell::Time(v, Length)),
            TimeUnit::Nanosecond => primitive!(DurationNanosecondType, v => Cell::Time(v, Length)),
        },
        DataType::Utf8 => text(&mut array.as_string::<i32>().iter()),
        DataType::LargeUtf8 => text(&mut array.as_string::<i64>().iter()),
        DataType::Utf8View => text(&mut array.as_string_view().iter()),
        DataType::Dictionary(_, _) => {
            let dictionary = array.as_any_dictionary();
            // A dictionary without values has no keys either; Arrow's accessor panics on it.
            if dictionary.values().is_empty() {
                return Ok(vec![None; array.len()]);
            }
            let values = simple(dictionary.values().as_ref(), wanted, read)?;
            let keys = dictionary.normalized_keys();
            let null = |row: usize| dictionary.keys().is_null(row);
            keys.iter()
                .enumerate()
                .map(|(row, key)| if null(row) { None } else { values.get(*key).cloned().flatten() })
                .collect()
        }
        other => return Err(format!("values of type {other} are not {wanted}")),
    })
}

#[cfg(test)]
mod tests;
