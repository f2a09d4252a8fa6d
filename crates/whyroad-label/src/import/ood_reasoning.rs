//! `reasoning/ood_reasoning.parquet` of PhysicalAI-AV and of folders with its layout: one row per clip, `events` as
//! JSON text or as a list. Every event becomes a label, not only the first.

use super::{FRAME_US, Reading, Reasoning, Row, TEXTS, cot_or_coc, findings, text, whole};
use serde_json::Value;
use std::collections::BTreeMap;

/// Columns that are read: the index under the names that pandas gives to it, and the events.
const INDEX: [&str; 2] = ["clip_id", "__index_level_0__"];

/// Reads the rows of a file.
pub fn read(file: &str, rows: &[Row]) -> Reading {
    let mut out = Reading::default();
    for (i, row) in rows.iter().enumerate() {
        let origin = format!("{file}#{}", i + 1);
        let Some(clip) = INDEX.iter().find_map(|name| text(row.get(*name))) else {
            out.diagnostics.push(findings::no_clip(&origin));
            continue;
        };
        out.leave_out_others("", row, &["clip_id", "__index_level_0__", "events"]);
        match events(row.get("events")) {
            Ok(events) if events.is_empty() => out.diagnostics.push(findings::no_text(&origin)),
            Ok(events) => {
                for (k, event) in events.iter().enumerate() {
                    add(&mut out, &format!("{origin}/{k}"), &clip, event);
                }
            }
            Err(reason) => {
                let zh = format!("events 不是事件列表：{reason}");
                out.diagnostics.push(findings::invalid(
                    &origin,
                    &zh,
                    &format!("events is not a list: {reason}"),
                ));
            }
        }
    }
    out
}

fn events(cell: Option<&Value>) -> Result<Vec<Value>, String> {
    match cell {
        None | Some(Value::Null) => Ok(Vec::new()),
        Some(Value::Array(list)) => Ok(list.clone()),
        Some(Value::String(json)) if json.trim().is_empty() => Ok(Vec::new()),
        Some(Value::String(json)) => serde_json::from_str(json).map_err(|e| e.to_string()),
        Some(_) => Err("neither text nor list".to_owned()),
    }
}

fn add(out: &mut Reading, origin: &str, clip: &str, event: &Value) {
    // Lists of JSON texts also occur.
    let parsed = event.as_str().and_then(|json| serde_json::from_str(json).ok());
    let Some(fields) = parsed.as_ref().unwrap_or(event).as_object() else {
        out.diagnostics.push(findings::invalid(origin, "事件不是对象", "the event is not an object"));
        return;
    };
    let known = ["event_start_timestamp", "event_start_frame", "event_end_timestamp", TEXTS[0], TEXTS[1]];
    out.leave_out_others("events.", fields, &known);
    let frame = whole(fields.get("event_start_frame")).and_then(|f| f.checked_mul(FRAME_US));
    let Some(at_us) = whole(fields.get("event_start_timestamp")).or(frame) else {
        return out.diagnostics.push(findings::no_time(origin));
    };
    let Some(words) = cot_or_coc(fields, origin, out) else {
        return out.diagnostics.push(findings::no_text(origin));
    };
    out.found.push(Reasoning {
        origin: origin.to_owned(),
        clip: clip.to_owned(),
        at_us,
        until_us: whole(fields.get("event_end_timestamp")),
        text: words,
        components: Vec::new(),
        versions: BTreeMap::new(),
    });
}
