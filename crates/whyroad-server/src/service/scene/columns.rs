//! Columns of a scene in the API's form: rounded numbers, category names, null for unknown.

use crate::domain::scene::{Numbers, TrackView};
use crate::service::tasks::TaskRow;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use whyroad_model::scene::Track;
use whyroad_model::signal::deviation_name;
use whyroad_model::{Column, Drive, FrameRange, SignalTable, TrackId};

/// A number that is known to be absent: no lead, no conflict.
const NONE: &str = "none";

/// Rounds to a thousandth: a millimeter, a millisecond, a twentieth of a degree. This halves the size of a scene.
pub(super) fn rounded(x: f64) -> f64 {
    rounded_to(x, 1000.0)
}

/// Steps of a signal in one unit: a value is shown beside the one that the rule compared, with a digit of a degree.
const SIGNAL_STEPS: f64 = 10_000.0;

fn rounded_to(x: f64, steps: f64) -> f64 {
    let r = (x * steps).round() / steps;
    // -0 would be written with its sign.
    if r == 0.0 { 0.0 } else { r }
}

/// A number for JSON: unknown and infinite ones are null.
pub(super) fn number(x: Option<f64>) -> Option<f64> {
    x.filter(|x| x.is_finite()).map(rounded)
}

/// A unit variant as its serialized name.
pub(super) fn word<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_value(value).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Tracks that were observed in the shown frames.
pub(super) fn tracks(drive: &Drive, frames: FrameRange) -> Vec<TrackView> {
    drive.tracks.iter().filter_map(|t| track(t, frames)).collect()
}

fn track(t: &Track, shown: FrameRange) -> Option<TrackView> {
    let rows = t.frames.partition_point(|f| (*f as usize) < shown.start)
        ..t.frames.partition_point(|f| (*f as usize) < shown.end);
    let (first, last) =
        (*t.frames.get(rows.clone())?.first()? as usize, *t.frames.get(rows.end - 1)? as usize);
    let mut row_of: Vec<Option<usize>> = vec![None; last + 1 - first];
    for row in rows.clone() {
        row_of[t.frames[row] as usize - first] = Some(row);
    }
    let column = |value: &dyn Fn(usize) -> f64| -> Numbers {
        row_of.iter().map(|row| number(row.map(value))).collect()
    };
    let newest = |sizes: &[f64]| rows.clone().rev().find_map(|row| number(sizes.get(row).copied()));
    let m = &t.motion;
    Some(TrackView {
        id: t.id.to_string(),
        class: word(&t.class),
        length: newest(&t.length_m),
        width: newest(&t.width_m),
        first: first - shown.start,
        x: column(&|row| m.x[row]),
        y: column(&|row| m.y[row]),
        heading: column(&|row| m.heading[row]),
        speed: column(&|row| m.speed(row)),
        visible: column(&|row| t.visible_share.get(row).copied().unwrap_or(f64::NAN)),
    })
}

/// Signals of the rule and `plotted`, by name: of the ego, or of the rule's target.
pub(super) fn signals(
    t: &TaskRow,
    plotted: &[&str],
    table: &SignalTable,
    frames: FrameRange,
) -> BTreeMap<String, Vec<Value>> {
    let target: Option<&TrackId> = t.episode.target_id.as_ref();
    let span = target.and_then(|id| table.target(id));
    let names = t.episode.signals.iter().map(String::as_str).chain(plotted.iter().copied());
    let mut out = BTreeMap::new();
    for name in names {
        if let Some(column) = table.frame_columns.get(name) {
            out.insert(name.to_owned(), (frames.start..frames.end).map(|f| value(column, f)).collect());
        } else if let (Some(column), Some(span)) = (table.target_columns.get(name), span) {
            let at = |f: usize| span.row(f).map_or(Value::Null, |row| value(column, row));
            out.insert(name.to_owned(), (frames.start..frames.end).map(at).collect());
        }
    }
    out
}

/// Speed, acceleration and yaw rate of the ego, which have columns of their own.
const OF_EGO: [&str; 3] = ["ego.forward_speed", "ego.accel", "ego.yaw_rate"];

/// Standard deviations of the numbers of [`signals`] and of the ego's motion that are known by estimation.
pub(super) fn deviations(
    t: &TaskRow,
    plotted: &[&str],
    table: &SignalTable,
    frames: FrameRange,
) -> BTreeMap<String, Numbers> {
    let span = t.episode.target_id.as_ref().and_then(|id| table.target(id));
    let read = t.episode.signals.iter().map(String::as_str);
    let mut out = BTreeMap::new();
    for name in read.chain(plotted.iter().copied()).chain(OF_EGO) {
        let stored = deviation_name(name);
        let column: Numbers = if let Some(column) = table.frame_columns.get(&stored) {
            (frames.start..frames.end).map(|f| number(column.number(f))).collect()
        } else if let (Some(column), Some(span)) = (table.target_columns.get(&stored), span) {
            (frames.start..frames.end)
                .map(|f| span.row(f).and_then(|row| number(column.number(row))))
                .collect()
        } else {
            continue;
        };
        out.insert(name.to_owned(), column);
    }
    out
}

/// Makes an angle in rad continuous: a curve that passes pi goes on beyond it instead of jumping to -pi.
pub(super) fn unwrap(values: &mut [Value]) {
    let mut last: Option<f64> = None;
    for value in values {
        let Some(angle) = value.as_f64() else { continue };
        let turns = last.map_or(0.0, |last| ((last - angle) / TAU).round());
        let continuous = rounded_to(angle + turns * TAU, SIGNAL_STEPS);
        *value = Value::from(continuous);
        last = Some(continuous);
    }
}

fn value(column: &Column, row: usize) -> Value {
    match column {
        // Unknown and absent are different, and JSON has no infinite number.
        Column::Number(_) if column.number(row).is_some_and(f64::is_infinite) => Value::from(NONE),
        Column::Number(_) => {
            let known = column.number(row).filter(|x| x.is_finite());
            known.map_or(Value::Null, |x| Value::from(rounded_to(x, SIGNAL_STEPS)))
        }
        Column::Flag(_) => column.flag(row).known().map_or(Value::Null, Value::from),
        Column::Category { .. } => column.category(row).map_or(Value::Null, Value::from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// 0.26 degrees are shown as the rule compared them, 0.3, not as 0.2.
    #[test]
    fn a_small_angle_keeps_its_tenth_of_a_degree() {
        let column = Column::Number(vec![-0.00454, f64::INFINITY, f64::NAN]);
        let shown = [0, 1, 2].map(|row| value(&column, row));
        assert_eq!(shown, [json!(-0.0045), json!("none"), Value::Null]);
    }

    /// Headings of a half circle in steps of 60 degrees from 150 degrees on: 150, 210, 270.
    #[test]
    fn an_angle_that_passes_pi_goes_on() {
        let mut values = vec![json!(2.618), json!(null), json!(-2.618), json!("none"), json!(-1.571)];
        unwrap(&mut values);
        assert_eq!(values, [json!(2.618), json!(null), json!(3.6652), json!("none"), json!(4.7122)]);
    }
}
