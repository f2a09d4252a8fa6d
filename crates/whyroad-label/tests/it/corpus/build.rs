//! Converts the compact form of the corpus to labels.

use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_model::messages::KeyframeType;
use whyroad_model::{Nanos, ScenarioId, yaml};

/// A true label, and its faulty variants.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Base {
    /// Full id of the L3 class.
    pub class: String,
    /// `longitudinal/lateral/direction`; `-` is null.
    pub decision: String,
    /// Components; `?` before one is uncertainty high.
    pub parts: Vec<String>,
    pub trace: String,
    /// Other true traces.
    #[serde(default)]
    pub more: Vec<String>,
    #[serde(default)]
    pub records: BTreeMap<String, Value>,
    /// Faulty traces by kind.
    #[serde(default)]
    pub faults: BTreeMap<String, Vec<String>>,
    /// Faulty components by kind.
    #[serde(default)]
    pub parts_faults: BTreeMap<String, Vec<String>>,
    /// Faulty decisions by kind.
    #[serde(default)]
    pub decision_faults: BTreeMap<String, Vec<String>>,
    /// Faulty decisions by kind, with matching traces.
    #[serde(default)]
    pub whole_faults: BTreeMap<String, Vec<Whole>>,
    /// Faulty records by kind, each replacing the record of its name.
    #[serde(default)]
    pub record_faults: BTreeMap<String, Vec<BTreeMap<String, Value>>>,
    /// Faulty moments of evidence by kind.
    #[serde(default)]
    pub evidence_faults: BTreeMap<String, Vec<Evidence>>,
}

/// A decision and a matching trace, with other components where it has some.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Whole {
    pub decision: String,
    #[serde(default)]
    pub parts: Vec<String>,
    pub trace: String,
}

/// When a component was evident.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Evidence {
    /// Index into the components.
    pub part: usize,
    /// Seconds after the keyframe.
    pub at: f64,
}

/// Both languages.
pub(super) fn bases() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("zh.yaml"))), ("en", read(include_str!("en.yaml")))]
}

/// Those that were written before the checks were improved (first set) and after (second to tenth, twelfth,
/// fourteenth to thirtieth set), and not looked at until their first figures were taken.
pub(super) fn unseen() -> [Vec<(&'static str, Vec<Base>)>; 28] {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    [
        vec![("zh", read(include_str!("unseen_zh.yaml"))), ("en", read(include_str!("unseen_en.yaml")))],
        vec![("zh", read(include_str!("unseen2_zh.yaml"))), ("en", read(include_str!("unseen2_en.yaml")))],
        vec![("zh", read(include_str!("unseen3_zh.yaml"))), ("en", read(include_str!("unseen3_en.yaml")))],
        vec![("zh", read(include_str!("unseen4_zh.yaml"))), ("en", read(include_str!("unseen4_en.yaml")))],
        vec![("zh", read(include_str!("unseen5_zh.yaml"))), ("en", read(include_str!("unseen5_en.yaml")))],
        vec![("zh", read(include_str!("unseen6_zh.yaml"))), ("en", read(include_str!("unseen6_en.yaml")))],
        vec![("zh", read(include_str!("unseen7_zh.yaml"))), ("en", read(include_str!("unseen7_en.yaml")))],
        vec![("zh", read(include_str!("unseen8_zh.yaml"))), ("en", read(include_str!("unseen8_en.yaml")))],
        vec![("zh", read(include_str!("unseen9_zh.yaml"))), ("en", read(include_str!("unseen9_en.yaml")))],
        vec![("zh", read(include_str!("unseen10_zh.yaml"))), ("en", read(include_str!("unseen10_en.yaml")))],
        vec![("zh", read(include_str!("unseen12_zh.yaml"))), ("en", read(include_str!("unseen12_en.yaml")))],
        vec![("zh", read(include_str!("unseen14_zh.yaml"))), ("en", read(include_str!("unseen14_en.yaml")))],
        vec![("zh", read(include_str!("unseen15_zh.yaml"))), ("en", read(include_str!("unseen15_en.yaml")))],
        vec![("zh", read(include_str!("unseen16_zh.yaml"))), ("en", read(include_str!("unseen16_en.yaml")))],
        vec![("zh", read(include_str!("unseen17_zh.yaml"))), ("en", read(include_str!("unseen17_en.yaml")))],
        vec![("zh", read(include_str!("unseen18_zh.yaml"))), ("en", read(include_str!("unseen18_en.yaml")))],
        vec![("zh", read(include_str!("unseen19_zh.yaml"))), ("en", read(include_str!("unseen19_en.yaml")))],
        vec![("zh", read(include_str!("unseen20_zh.yaml"))), ("en", read(include_str!("unseen20_en.yaml")))],
        vec![("zh", read(include_str!("unseen21_zh.yaml"))), ("en", read(include_str!("unseen21_en.yaml")))],
        vec![("zh", read(include_str!("unseen22_zh.yaml"))), ("en", read(include_str!("unseen22_en.yaml")))],
        vec![("zh", read(include_str!("unseen23_zh.yaml"))), ("en", read(include_str!("unseen23_en.yaml")))],
        vec![("zh", read(include_str!("unseen24_zh.yaml"))), ("en", read(include_str!("unseen24_en.yaml")))],
        vec![("zh", read(include_str!("unseen25_zh.yaml"))), ("en", read(include_str!("unseen25_en.yaml")))],
        vec![("zh", read(include_str!("unseen26_zh.yaml"))), ("en", read(include_str!("unseen26_en.yaml")))],
        vec![("zh", read(include_str!("unseen27_zh.yaml"))), ("en", read(include_str!("unseen27_en.yaml")))],
        vec![("zh", read(include_str!("unseen28_zh.yaml"))), ("en", read(include_str!("unseen28_en.yaml")))],
        vec![("zh", read(include_str!("unseen29_zh.yaml"))), ("en", read(include_str!("unseen29_en.yaml")))],
        vec![("zh", read(include_str!("unseen30_zh.yaml"))), ("en", read(include_str!("unseen30_en.yaml")))],
    ]
}

/// True and faulty labels in styles and with things that the other sets do not have, written before the checks were
/// made to compare meaning.
pub(super) fn general() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("general_zh.yaml"))), ("en", read(include_str!("general_en.yaml")))]
}

/// True labels in twelve voices, half with a fault of the kinds that the twentieth and twenty-first set showed to be
/// weak; used for development.
pub(super) fn voices() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("voices_zh.yaml"))), ("en", read(include_str!("voices_en.yaml")))]
}

/// The kinds that the ninth set showed to be weak, written before the checks were changed for them.
pub(super) fn weak() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("weak_zh.yaml"))), ("en", read(include_str!("weak_en.yaml")))]
}

/// The eleventh set: every kind that the tenth showed to be weak, by a seventh author who had seen neither the checks
/// nor the other sets.
pub(super) fn eleventh() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("dev11_zh.yaml"))), ("en", read(include_str!("dev11_en.yaml")))]
}

/// The thirteenth set: the kinds that the twelfth showed to be weak, by a ninth author who had seen neither the checks
/// nor the other sets.
pub(super) fn thirteenth() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("dev13_zh.yaml"))), ("en", read(include_str!("dev13_en.yaml")))]
}

/// True labels with three traces each, in different voices, and faults of the kinds that are found worst, written
/// before the checks were made to ask for evidence, by the author of that change.
pub(super) fn evidence() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("dev27_zh.yaml"))), ("en", read(include_str!("dev27_en.yaml")))]
}

/// True labels only, in styles that the others do not have.
pub(super) fn styles() -> Vec<(&'static str, Vec<Base>)> {
    let read = |text: &str| yaml::from_str::<Vec<Base>>(text).unwrap();
    vec![("zh", read(include_str!("styles_zh.yaml"))), ("en", read(include_str!("styles_en.yaml")))]
}

/// Moment of the keyframe: frame 100 of a clip.
pub(super) fn keyframe() -> Nanos {
    Nanos::parse_iso("2026-01-15T10:30:10.000Z").unwrap()
}

/// `s` seconds after the keyframe, as text.
pub(super) fn at(s: f64) -> Value {
    json!(keyframe().plus_secs(s).to_string())
}

/// Seconds from the keyframe to the start that the spec prescribes, where it is an offset.
pub(super) fn start_s(base: &Base) -> Option<f64> {
    let mut ids = base.class.split('.');
    let id = ScenarioId::leaf(ids.next()?, ids.next()?, ids.next()?);
    let expr = Framework::bundled().specs[&id].start.expr.clone()?;
    match expr.replace(' ', "").as_str() {
        "keyframe" => Some(0.0),
        e => e.strip_prefix("keyframe-")?.strip_suffix('s')?.parse::<f64>().ok().map(|s| -s),
    }
}

pub(super) fn kind(base: &Base) -> KeyframeType {
    spec(base).keyframe.kind
}

fn spec(base: &Base) -> &'static whyroad_framework::ResolvedSpec {
    let mut ids = base.class.split('.');
    let mut next = || ids.next().unwrap();
    &Framework::bundled().specs[&ScenarioId::leaf(next(), next(), next())]
}

/// The whole label.
pub(super) fn label(base: &Base) -> Value {
    let ids: Vec<&str> = base.class.split('.').collect();
    let start = start_s(base).unwrap_or(-2.0);
    let parts: Vec<Value> = base.parts.iter().enumerate().map(|(i, p)| component(i, p)).collect();
    let all: Vec<String> = (0..parts.len()).map(|i| format!("c{}", i + 1)).collect();
    let mut label = json!({
        "version": "2.1.0",
        "clip_id": "clip_1",
        "scenario": { "l1": ids[0], "l2": ids[1], "l3": ids[2], "full_id": base.class },
        "time_range": { "start_timestamp": at(start), "end_timestamp": at(4.0) },
        "keyframe": { "timestamp": at(0.0), "frame_idx": 100, "type": kind(base).id() },
        "critical_components": parts,
        "coc_trace": base.trace,
        "records": base.records,
        "provenance": { "source": "person" },
    });
    label["time_range"]["start_frame_idx"] = json!((100.0 + 10.0 * start) as u32);
    label["time_range"]["end_frame_idx"] = json!(140);
    if kind(base) == KeyframeType::Proactive {
        label["keyframe"]["range_start"] = at(0.0);
        label["keyframe"]["range_end"] = at(4.0);
    }
    if let Some(second) = &spec(base).second_keyframe {
        label["second_keyframe"] =
            json!({ "timestamp": at(1.5), "frame_idx": 115, "type": second.kind.id() });
    }
    decide(&mut label, &base.decision, &all);
    label
}

/// Sets the decision, with all components as its cause.
pub(super) fn decide(label: &mut Value, decision: &str, causes: &[String]) {
    let mut parts = decision.split('/').map(|p| if p == "-" { Value::Null } else { json!(p) });
    let (along, across) = (parts.next().unwrap(), parts.next().unwrap());
    let mut why = json!({});
    for (channel, d) in [("longitudinal", &along), ("lateral", &across)] {
        if !d.is_null() {
            why[channel] = json!({ "components": causes });
        }
    }
    label["causes"] = why;
    label["driving_decision"] = json!({ "longitudinal": along, "lateral": across });
    if let Some(side) = parts.next() {
        label["driving_decision"]["lateral_direction"] = side;
    }
}

pub(super) fn component(i: usize, text: &str) -> Value {
    let category = "critical_objects";
    let (high, description) = text.strip_prefix('?').map_or((false, text), |t| (true, t));
    json!({
        "id": format!("c{}", i + 1), "category": category, "description": description,
        "uncertainty": if high { "high" } else { "low" }, "evidence_times": [at(-0.5), at(0.0)],
    })
}

/// True labels: every trace in the forms in which the same label is written.
pub(super) fn forms(base: &Base, _: &str) -> Vec<Value> {
    let mut out = Vec::new();
    for trace in std::iter::once(&base.trace).chain(&base.more) {
        let mut whole = label(base);
        whole["coc_trace"] = json!(trace);
        // Of format 2.0: no ids, no evidence, no causes.
        let mut old = whole.clone();
        old["version"] = json!("2.0.0");
        for field in ["causes", "provenance"] {
            old.as_object_mut().unwrap().remove(field);
        }
        for part in old["critical_components"].as_array_mut().unwrap() {
            part.as_object_mut().unwrap().retain(|k, _| k == "description" || k == "uncertainty");
        }
        let mut reordered = whole.clone();
        reordered["critical_components"].as_array_mut().unwrap().reverse();
        let mut unframed = whole.clone();
        unframed["time_range"].as_object_mut().unwrap().retain(|k, _| k.ends_with("timestamp"));
        let mut one_cause = whole.clone();
        one_cause["provenance"] = json!({ "source": "person", "by": "a", "tool": "other 1.0" });
        one_cause["secondary_scenarios"] = json!([]);
        out.extend([whole, old, reordered, unframed, one_cause]);
    }
    out
}
