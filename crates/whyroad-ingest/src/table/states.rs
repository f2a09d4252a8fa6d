//! `lights` and `context`: what holds from a time on until the next row of the same kind.

use super::Reader;
use super::problems::Problems;
use super::sheet::TIME;
use crate::report::RowCount;
use whyroad_model::Nanos;
use whyroad_model::scene::{ContextState, LightColour, LightState};

const COLOURS: &str = "one of red, yellow, green, green_yield, red_yellow, flashing_yellow, off, unknown";

/// Light states; `None` without the table.
pub(super) fn lights(reader: &mut Reader) -> Option<Vec<LightState>> {
    let columns = ["timestamp_ns", "time", "time_s", "lane_id", "to_lane_id", "colour"];
    let sheet = reader.sheet("lights", &columns, &[TIME, &["lane_id"], &["colour"]])?;
    let mut problems = Problems::default();
    let times = sheet.times(reader.start, &mut problems);
    let (lanes, to) = (sheet.texts("lane_id"), sheet.texts("to_lane_id"));
    let colours: Vec<Option<LightColour>> = sheet.words("colour", COLOURS, &mut problems);
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("lights") };
    let mut out = Vec::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        match (times[i], lanes[i].clone()) {
            (None, _) => problems.row("no_time", row, &mut count),
            (_, None) => problems.row("no_id", row, &mut count),
            (Some(t), Some(lane_id)) => {
                count.keep("light", 1);
                let colour = colours[i].unwrap_or(LightColour::Unknown);
                out.push(LightState { lane_id, to_lane_id: to[i].clone(), time: Nanos(t), colour });
            }
        }
    }
    out.sort_by(|a, b| (&a.lane_id, &a.to_lane_id, a.time).cmp(&(&b.lane_id, &b.to_lane_id, b.time)));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.tables.push(count);
    Some(out)
}

/// Weather, surface and the like; `None` without the table.
pub(super) fn context(reader: &mut Reader) -> Option<Vec<ContextState>> {
    let columns = ["timestamp_ns", "time", "time_s", "kind", "value", "source"];
    let sheet = reader.sheet("context", &columns, &[TIME, &["kind"], &["value"]])?;
    let mut problems = Problems::default();
    let times = sheet.times(reader.start, &mut problems);
    let [kinds, values, sources] = ["kind", "value", "source"].map(|n| sheet.texts(n));
    let mut count = RowCount { read: sheet.rows, ..RowCount::new("context") };
    let mut out = Vec::new();
    for i in 0..sheet.rows {
        let row = sheet.first_row + i;
        match (times[i], kinds[i].clone(), values[i].clone()) {
            (None, ..) => problems.row("no_time", row, &mut count),
            (Some(t), Some(kind), Some(value)) => {
                count.keep("state", 1);
                let source = sources[i].clone().unwrap_or_else(|| "log".to_owned());
                out.push(ContextState { time: Nanos(t), kind, value, source });
            }
            _ => problems.row("invalid", row, &mut count),
        }
    }
    out.sort_by(|a, b| (a.time, &a.kind).cmp(&(b.time, &b.kind)));
    reader.report.diagnostics.extend(problems.diagnostics(&sheet.label));
    reader.report.tables.push(count);
    Some(out)
}
