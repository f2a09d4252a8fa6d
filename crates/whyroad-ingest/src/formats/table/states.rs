//! `lights` and `context`: states that are valid from a time until the next row of the same kind.

use super::findings;
use super::problems::Problems;
use super::reader::Reader;
use super::sheet::{Sheet, TIME};
use super::words::UnknownWords;
use crate::report::RowCount;
use whyroad_model::Nanos;
use whyroad_model::scene::{ContextState, LightColor, LightState};
use whyroad_model::vocabulary::{CONTEXT_KINDS, ContextValues, UNKNOWN, context_values};

const COLORS: &str = "one of red, yellow, green, green_yield, green_round, green_arrow, flashing_green, red_yellow, \
    flashing_yellow, off, unknown";

/// The highest posted limit is 160 km/h (Abu Dhabi), m/s.
const HIGHEST_LIMIT_MPS: f64 = 45.0;

/// The states, if a row can be used. A table with a header only says that there is none; one whose rows cannot be used
/// says nothing.
fn usable<T>(states: Vec<T>, sheet: &Sheet, reader: &mut Reader) -> Option<Vec<T>> {
    if states.is_empty() && sheet.rows > 0 {
        reader.report.diagnostics.push(findings::no_row(&sheet.label));
        return None;
    }
    Some(states)
}

/// Light states; `None` without the table, and where no row of it can be used.
pub(super) fn lights(reader: &mut Reader) -> Option<Vec<LightState>> {
    let sheet = reader.sheet("lights", &[TIME, &["lane_id"], &["colour"]])?;
    let mut problems = Problems::default();
    let times = sheet.times(reader.start, &mut problems);
    let (lanes, to) = (sheet.texts("lane_id"), sheet.texts("to_lane_id"));
    let countdowns = sheet.numbers("countdown_s", &mut problems);
    let colors: Vec<Option<LightColor>> = sheet.words("colour", COLORS, &mut problems);
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("lights") };
    let mut out = Vec::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        match (times[i], lanes[i].clone()) {
            (None, _) => problems.row("no_time", row, &mut count),
            (_, None) => problems.row("no_id", row, &mut count),
            (Some(t), Some(lane_id)) => {
                count.keep("light", 1);
                let color = colors[i].unwrap_or(LightColor::Unknown);
                let countdown_s = Some(countdowns[i]).filter(|s| *s >= 0.0);
                let (to_lane_id, time) = (to[i].clone(), Nanos(t));
                out.push(LightState { lane_id, to_lane_id, time, color, countdown_s });
            }
        }
    }
    out.sort_by(|a, b| (&a.lane_id, &a.to_lane_id, a.time).cmp(&(&b.lane_id, &b.to_lane_id, b.time)));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.tables.push(count);
    usable(out, &sheet, reader)
}

/// Weather, surface and the like; `None` without the table, and without a row that can be used. A value that is missing
/// or not allowed for its kind ends the previous state: from there on the state is `unknown`.
pub(super) fn context(reader: &mut Reader) -> Option<Vec<ContextState>> {
    let sheet = reader.sheet("context", &[TIME, &["kind"], &["value"]])?;
    let (mut problems, mut words) = (Problems::default(), UnknownWords::default());
    let known: Vec<&'static str> = CONTEXT_KINDS.iter().map(|(kind, _)| *kind).collect();
    let times = sheet.times(reader.start, &mut problems);
    let [kinds, values, sources] = ["kind", "value", "source"].map(|n| sheet.texts(n));
    let confidences = sheet.parsed("confidence", "a number from 0 to 1", &mut problems, |text| {
        text.parse().ok().filter(|v: &f64| (0.0..=1.0).contains(v))
    });
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("context") };
    let mut out = Vec::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        let (Some(time), Some(kind)) = (times[i], kinds[i].as_deref()) else {
            problems.row(if times[i].is_none() { "no_time" } else { "invalid" }, row, &mut count);
            continue;
        };
        let Some(kind) = words.check("kind", kind, &known) else {
            problems.row("unknown_word", row, &mut count);
            continue;
        };
        let stated = values[i].as_deref().filter(|v| *v != UNKNOWN);
        let value = stated.and_then(|text| match context_values(&kind)? {
            ContextValues::Words(list) => words.check("value", text, list),
            ContextValues::Number(_) => {
                let number = text.parse::<f64>().ok();
                // Distances and speeds; no limit is above 160 km/h.
                let most = if kind == "nav_speed_limit" { HIGHEST_LIMIT_MPS } else { f64::MAX };
                let fits = number.is_some_and(|v| (0.0..=most).contains(&v));
                if !fits {
                    problems.cell("value", "a number from 0 in m or m/s", row, text);
                }
                fits.then(|| text.to_owned())
            }
        });
        count.keep("state", 1);
        let source = sources[i].clone().unwrap_or_else(|| "log".to_owned());
        let value = value.unwrap_or_else(|| UNKNOWN.to_owned());
        let confidence = confidences[i];
        out.push(ContextState { time: Nanos(time), kind, value, source, confidence });
    }
    out.sort_by(|a, b| (a.time, &a.kind).cmp(&(b.time, &b.kind)));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.diagnostics.extend(words.diagnostics(&sheet.label));
    reader.report.tables.push(count);
    usable(out, &sheet, reader)
}
