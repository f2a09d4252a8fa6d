//! Auto labels of Alpamayo 2 as JSON: one object, a list of objects, or JSON Lines. `chain_of_causation` is the text;
//! `critical_components_analysis` becomes components; the other analyses may be null.

use super::{Reading, Reasoning, findings, text, whole};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

const TEXTS: [&str; 3] = ["chain_of_causation", "coc", "cot"];
const CLIP: [&str; 2] = ["clip_id", "clip"];
/// Keys of the moment, us since the clip's start; the tools around the model use different names.
const TIMES: [&str; 5] = ["event_start_timestamp", "t0_us", "t0_relative", "t0", "timestamp"];
const COMPONENTS: &str = "critical_components_analysis";

/// Reads one file; `stem`, its name without the extension, is the clip where the content names none.
pub fn read(file: &str, stem: &str, content: &str) -> Reading {
    let mut out = Reading::default();
    let objects: Vec<(String, Value)> = match serde_json::from_str(content) {
        Ok(Value::Array(list)) => numbered(file, list),
        Ok(one) => vec![(file.to_owned(), one)],
        Err(whole_file) => {
            let mut lines = Vec::new();
            for (i, line) in content.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
                let origin = format!("{file}#{}", i + 1);
                match serde_json::from_str(line) {
                    Ok(value) => lines.push((origin, value)),
                    // The first line alone is not JSON, so this is a broken JSON document, not JSON Lines.
                    Err(_) if lines.is_empty() => {
                        out.diagnostics.push(findings::unreadable(file, &whole_file.to_string()));
                        return out;
                    }
                    Err(e) => {
                        out.diagnostics.push(findings::invalid(&origin, &e.to_string(), &e.to_string()))
                    }
                }
            }
            lines
        }
    };
    for (origin, value) in &objects {
        match value.as_object() {
            Some(fields) => add(&mut out, origin, stem, fields),
            None => out.diagnostics.push(findings::invalid(origin, "不是对象", "it is not an object")),
        }
    }
    out
}

fn numbered(file: &str, list: Vec<Value>) -> Vec<(String, Value)> {
    list.into_iter().enumerate().map(|(i, v)| (format!("{file}#{}", i + 1), v)).collect()
}

fn add(out: &mut Reading, origin: &str, stem: &str, fields: &Map<String, Value>) {
    let known: Vec<&str> = TEXTS.into_iter().chain(CLIP).chain(TIMES).chain([COMPONENTS, "model"]).collect();
    out.leave_out_others("", fields, &known);
    let Some(at_us) = TIMES.iter().find_map(|name| whole(fields.get(*name))) else {
        return out.diagnostics.push(findings::no_time(origin));
    };
    let Some(words) = TEXTS.iter().find_map(|name| text(fields.get(*name))) else {
        return out.diagnostics.push(findings::no_text(origin));
    };
    let clip = CLIP.iter().find_map(|name| text(fields.get(*name))).unwrap_or_else(|| stem.to_owned());
    let model = text(fields.get("model")).map(|m| ("model".to_owned(), m));
    out.found.push(Reasoning {
        origin: origin.to_owned(),
        clip,
        at_us,
        until_us: None,
        text: words,
        components: fields.get(COMPONENTS).map(components).unwrap_or_default(),
        versions: model.into_iter().collect::<BTreeMap<_, _>>(),
    });
}

/// One component per entry of a list, or per line of a text without its bullet; objects keep their JSON.
fn components(value: &Value) -> Vec<String> {
    match value {
        Value::String(lines) => lines
            .lines()
            .map(|l| l.trim().trim_start_matches(['-', '*', '•']).trim().to_owned())
            .filter(|l| !l.is_empty())
            .collect(),
        Value::Array(list) => list.iter().flat_map(components).collect(),
        Value::Null => Vec::new(),
        Value::Object(fields) => match text(fields.get("description")) {
            Some(words) if fields.len() == 1 => vec![words],
            _ => vec![value.to_string()],
        },
        other => vec![other.to_string()],
    }
}
