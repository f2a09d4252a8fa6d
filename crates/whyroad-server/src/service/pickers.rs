//! The framework in the form for the page's pickers: names, meanings, closed sets, in both languages.

use crate::domain::safety::SafetyReason;
use crate::domain::task::{ClassChoices, DecisionChoice, FrameworkView};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_framework::decision_table::{ClassDecisions, Fit};
use whyroad_framework::decisions::DecisionText;
use whyroad_framework::taxonomy::{Decides, L1, L2, L3};
use whyroad_framework::{DecisionSets, Framework, Taxonomy};
use whyroad_model::ComponentCategory;

/// All of it.
pub fn of(framework: &Framework) -> FrameworkView {
    let category = |c: &ComponentCategory| json!({ "id": c.id(), "name": c.name() });
    let versions = [
        ("format", whyroad_model::FORMAT_VERSION),
        ("taxonomy", framework.taxonomy.version.as_str()),
        ("decisions", framework.decisions.version.as_str()),
        ("whyroad", env!("CARGO_PKG_VERSION")),
    ];
    FrameworkView {
        taxonomy: taxonomy(&framework.taxonomy),
        decisions: decisions(&framework.decisions),
        choices: framework
            .decision_table()
            .leaves
            .iter()
            .map(|(id, c)| (id.to_string(), choices(c)))
            .collect(),
        impossible_pairs: framework
            .decision_table()
            .impossible_pairs
            .iter()
            .map(|(a, b)| [a.id().to_owned(), b.id().to_owned()])
            .collect(),
        safety_reasons: SafetyReason::ALL.iter().map(|r| json!({ "id": r.id(), "name": r.name() })).collect(),
        categories: ComponentCategory::ALL.iter().map(category).collect(),
        records: records(framework),
        versions: versions.map(|(k, v)| (k.to_owned(), v.to_owned())).into(),
    }
}

fn choices(class: &ClassDecisions) -> ClassChoices {
    let fits = |fit: &Fit| *fit != Fit::Impossible;
    let longitudinal = class.longitudinal.iter().filter(|(_, fit)| fits(fit)).map(|(d, fit)| {
        DecisionChoice { id: d.map(|d| d.id().to_owned()), direction: None, usual: *fit == Fit::Usual }
    });
    let lateral = class.lateral.iter().filter(|(_, fit)| fits(fit)).map(|(e, fit)| DecisionChoice {
        id: e.lateral.map(|d| d.id().to_owned()),
        direction: e.direction.map(|d| d.id().to_owned()),
        usual: *fit == Fit::Usual,
    });
    ClassChoices {
        longitudinal: longitudinal.collect(),
        lateral: lateral.collect(),
        decides: class.decides,
        reveals: class.reveals,
    }
}

fn taxonomy(t: &Taxonomy) -> Value {
    json!(t.l1.iter().map(l1).collect::<Vec<_>>())
}

fn l1(a: &L1) -> Value {
    let below: Vec<Value> = a.l2.iter().map(|b| l2(a, b)).collect();
    json!({ "id": a.id, "name": a.name, "definition": a.definition, "l2": below })
}

fn l2(a: &L1, b: &L2) -> Value {
    let below: Vec<Value> = b.l3.iter().map(|c| l3(a, b, c)).collect();
    json!({
        "id": b.id, "full_id": format!("{}.{}", a.id, b.id), "name": b.name, "definition": b.definition,
        "condition": b.condition, "typical_decisions": b.typical_decisions, "decides": decides(&b.decides), "l3": below,
    })
}

fn l3(a: &L1, b: &L2, c: &L3) -> Value {
    json!({
        "id": c.id, "full_id": format!("{}.{}.{}", a.id, b.id, c.id), "name": c.name, "definition": c.definition,
        "condition": c.condition, "typical_decisions": c.typical_decisions, "decides": decides(&c.decides),
    })
}

fn decides(list: &[Decides]) -> Vec<Value> {
    list.iter().map(|d| json!({ "against": d.against.to_string(), "rule": d.rule })).collect()
}

fn decisions(sets: &DecisionSets) -> Value {
    let text = |t: &DecisionText| json!({ "name": t.name, "meaning": t.meaning, "not": t.not });
    let with = |id: Value, t: &DecisionText, directions: Value| {
        let mut out = text(t);
        out["id"] = id;
        out["directions"] = directions;
        out
    };
    let longitudinal: Vec<Value> =
        sets.longitudinal.iter().map(|d| with(json!(d.id), &d.text, json!([]))).collect();
    let lateral: Vec<Value> =
        sets.lateral.iter().map(|d| with(json!(d.id), &d.text, json!(d.directions))).collect();
    json!({ "longitudinal": longitudinal, "lateral": lateral, "null": text(&sets.null_decision) })
}

fn records(framework: &Framework) -> BTreeMap<String, Value> {
    let all = framework.specs.values().flat_map(|s| &s.records);
    all.map(|r| (r.id.clone(), json!({ "name": r.name, "unit": r.unit }))).collect()
}
