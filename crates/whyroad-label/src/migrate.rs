//! Converts labels of older layouts to the current one, and back to format 2.0. What cannot be converted is reported;
//! nothing is guessed that the document does not state.
//!
//! Supported inputs: format 2.0 and 2.1; the object layout of 1.0, with the same parts under the names in [`ALIASES`];
//! and the compact layout, in which the scenario, the decision, the keyframe and the range are single values and the
//! components are the list `primary_factors`.

mod loss;
mod parts;

use loss::lost;
use parts::{decision, factors, moment, range, scenario};
use serde_json::{Map, Value, json};
use whyroad_framework::Framework;
use whyroad_model::label_fields::{LABEL_FIELDS, name};
use whyroad_model::messages::CocLabel;
use whyroad_model::{Diagnostic, FORMAT_VERSION};

/// Target format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The newest format.
    Current,
    /// Format 2.0.0: without everything that later versions have added.
    V2_0,
}

/// A label in the target format.
#[derive(Clone, Debug, PartialEq)]
pub struct Migrated {
    /// The label; `None` where the document is not a label.
    pub label: Option<Value>,
    /// Layout of the input.
    pub from: &'static str,
    /// What was left out or is missing.
    pub report: Vec<Diagnostic>,
}

/// Older names of fields, and the current name.
const ALIASES: &[(&str, &str)] = &[
    ("clip", name::CLIP_ID),
    ("clipId", name::CLIP_ID),
    ("scene", name::SCENARIO),
    ("scenario_label", name::SCENARIO),
    ("decision", name::DRIVING_DECISION),
    ("decisions", name::DRIVING_DECISION),
    ("key_frame", name::KEYFRAME),
    ("keyframe_info", name::KEYFRAME),
    ("segment", name::TIME_RANGE),
    ("range", name::TIME_RANGE),
    ("components", name::CRITICAL_COMPONENTS),
    ("factors", name::CRITICAL_COMPONENTS),
    (PRIMARY_FACTORS, name::CRITICAL_COMPONENTS),
    ("trace", name::COC_TRACE),
    ("coc", name::COC_TRACE),
    ("reasoning", name::COC_TRACE),
];

/// The list that marks the compact layout.
const PRIMARY_FACTORS: &str = "primary_factors";

/// Converts one document to `target`.
pub fn migrate(framework: &Framework, document: &Value, target: Target) -> Migrated {
    let mut report = Vec::new();
    let Value::Object(fields) = document else {
        report.push(lost("", "不是 JSON 对象", "not a JSON object"));
        return Migrated { label: None, from: "unknown", report };
    };
    // A message contains its content under one key.
    let inner = fields
        .get("coc_label")
        .or_else(|| fields.get("coc_output"))
        .and_then(Value::as_object)
        .unwrap_or(fields);
    let from = layout(inner);
    let mut out = renamed(inner, &mut report);
    let times = parts::Times::of(&out, inner);
    if let Some(v) = out.remove(name::SCENARIO) {
        put(&mut out, name::SCENARIO, scenario(framework, v, &mut report));
    }
    if let Some(v) = out.remove(name::DRIVING_DECISION) {
        put(&mut out, name::DRIVING_DECISION, decision(v, &mut report));
    }
    if let Some(v) = out.remove(name::CRITICAL_COMPONENTS) {
        put(&mut out, name::CRITICAL_COMPONENTS, factors(v, &mut report));
    }
    if let Some(v) = out.remove(name::TIME_RANGE) {
        put(&mut out, name::TIME_RANGE, range(v, &times, &mut report));
    }
    if let Some(v) = out.remove(name::KEYFRAME) {
        let kind = parts::keyframe_type(framework, out.get(name::SCENARIO));
        put(&mut out, name::KEYFRAME, moment(v, &times, kind, &mut report));
    }
    records(framework, &mut out);
    out.insert(name::VERSION.to_owned(), json!(FORMAT_VERSION));
    for field in [
        name::CLIP_ID,
        name::SCENARIO,
        name::TIME_RANGE,
        name::KEYFRAME,
        name::DRIVING_DECISION,
        name::CRITICAL_COMPONENTS,
        name::COC_TRACE,
    ] {
        if !out.contains_key(field) {
            report.push(lost(
                &format!("/{field}"),
                &format!("原文档没有 {field}，须补充"),
                &format!("the document has no {field}: it must be added"),
            ));
        }
    }
    let label = match target {
        Target::Current => Value::Object(out),
        Target::V2_0 => back(out, &mut report),
    };
    Migrated { label: Some(label), from, report }
}

fn layout(fields: &Map<String, Value>) -> &'static str {
    let version = fields.get(name::VERSION).and_then(Value::as_str).unwrap_or_default();
    if fields.contains_key(PRIMARY_FACTORS) {
        "compact"
    } else if version.starts_with("2.1") {
        "2.1"
    } else if version.starts_with("1.") || ALIASES.iter().any(|(old, _)| fields.contains_key(*old)) {
        "1.0"
    } else {
        "2.0"
    }
}

/// The fields under their current names; fields that no format has are reported and left out.
fn renamed(fields: &Map<String, Value>, report: &mut Vec<Diagnostic>) -> Map<String, Value> {
    let of_root = |p: &'static str| p.strip_prefix('/').filter(|p| !p.contains('/'));
    let known: Vec<&str> = LABEL_FIELDS.iter().filter_map(|f| of_root(f.pointer)).collect();
    let mut out = Map::new();
    for (key, value) in fields {
        let new = ALIASES.iter().find(|(old, _)| old == key).map_or(key.as_str(), |(_, new)| new);
        if !known.contains(&new) {
            report.push(lost(
                &format!("/{key}"),
                &format!("'{key}' 在当前格式中没有对应字段，未保留"),
                &format!("'{key}' has no equivalent in the current format and is removed"),
            ));
        } else if out.contains_key(new) {
            report.push(lost(
                &format!("/{key}"),
                &format!("'{key}' 与另一个字段同义，未保留"),
                &format!("'{key}' means the same as another field and is removed"),
            ));
        } else if !value.is_null() {
            out.insert(new.to_owned(), value.clone());
        }
    }
    out
}

fn put(out: &mut Map<String, Value>, field: &str, value: Option<Value>) {
    if let Some(value) = value {
        out.insert(field.to_owned(), value);
    }
}

/// Records in their stored form: without language.
fn records(framework: &Framework, out: &mut Map<String, Value>) {
    let Some(Value::Object(records)) = out.get_mut(name::RECORDS) else { return };
    for (id, value) in records.iter_mut() {
        if let Some(stored) = framework.record_types.stored(id, value) {
            *value = stored;
        }
    }
}

/// Converts to format 2.0 and reports what it cannot represent.
fn back(out: Map<String, Value>, report: &mut Vec<Diagnostic>) -> Value {
    let whole = Value::Object(out);
    let Ok(label) = serde_json::from_value::<CocLabel>(whole.clone()) else {
        report.push(lost(
            "",
            "文档不完整，无法转为 2.0",
            "the document is not complete, so it cannot be converted to 2.0",
        ));
        return whole;
    };
    let old = serde_json::to_value(label.to_2_0()).unwrap_or(Value::Null);
    for field in
        [name::RECORDS, name::CAUSES, name::SECOND_KEYFRAME, name::SECONDARY_SCENARIOS, name::PROVENANCE]
    {
        let said = whole.get(field).is_some_and(|v| !v.is_null() && *v != json!({}) && *v != json!([]));
        if said && old.get(field).is_none() {
            report.push(lost(
                &format!("/{field}"),
                &format!("格式 2.0 没有 {field}，未保留"),
                &format!("format 2.0 has no {field}: removed"),
            ));
        }
    }
    let linked = whole[name::CRITICAL_COMPONENTS].as_array().into_iter().flatten();
    let lost_links = linked
        .filter(|c| {
            [name::ID, name::EVIDENCE_TIMES, name::LINKED_OBJECTS].iter().any(|f| c.get(*f).is_some())
        })
        .count();
    if lost_links > 0 {
        report.push(lost(
            "/critical_components",
            &format!("格式 2.0 的要素没有编号、证据时间和关联目标：{lost_links} 个要素的这些内容未保留"),
            &format!("components of format 2.0 have no ids, evidence times or linked objects: removed from {lost_links}"),
        ));
    }
    old
}

#[cfg(test)]
mod tests;
