//! Rules between the fields of a label (DATA_FORMAT.md 4.3 "业务校验") as JSON Schema conditions. Rules that compare
//! times or read the trace are beyond JSON Schema; `whyroad validate` checks those too.

use crate::{Framework, Taxonomy};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use whyroad_model::ScenarioId;
use whyroad_model::decision::Lateral;
use whyroad_model::ids::OTHER;

/// Closes `l1`, `l2` and the fields that hold an L3 to the classes: an L2 under its own L1, an L3 under its own L2.
pub(super) fn classes(scenario: &mut Value, leaf_fields: &[&str], taxonomy: &Taxonomy) {
    scenario["properties"]["l1"]["enum"] = taxonomy.l1.iter().map(|a| a.id.as_str()).collect();
    let mut conditions = Vec::new();
    for l1 in &taxonomy.l1 {
        let l2: Vec<&str> = l1.l2.iter().map(|b| b.id.as_str()).chain([OTHER]).collect();
        conditions.push(json!({
            "if": { "properties": { "l1": { "const": l1.id } }, "required": ["l1"] },
            "then": { "properties": { "l2": { "enum": l2 } } },
        }));
        for l2 in &l1.l2 {
            let mut l3: Vec<Value> = l2.l3.iter().map(|c| json!(c.id)).collect();
            l3.extend([json!(OTHER), Value::Null]);
            let leaves: Map<String, Value> =
                leaf_fields.iter().map(|field| ((*field).to_owned(), json!({ "enum": l3 }))).collect();
            conditions.push(json!({
                "if": { "properties": { "l1": { "const": l1.id }, "l2": { "const": l2.id } }, "required": ["l1", "l2"] },
                "then": { "properties": leaves },
            }));
        }
    }
    scenario["allOf"] = Value::Array(conditions);
}

/// Directions, proactive ranges, mandatory uncertainty, mandated lateral decisions, and texts that may not be empty.
pub(super) fn label(coc: &mut Value, framework: &Framework) {
    for name in ["clip_id", "coc_trace"] {
        coc["properties"][name]["minLength"] = json!(1);
    }
    coc["properties"]["critical_components"]["minItems"] = json!(1);
    coc["$defs"]["CriticalComponent"]["properties"]["description"]["minLength"] = json!(1);
    coc["$defs"]["DrivingDecision"]["allOf"] = directions();
    coc["$defs"]["Keyframe"]["allOf"] = json!([{
        "if": { "properties": { "type": { "const": "proactive" } }, "required": ["type"] },
        "then": {
            "properties": { "range_start": { "type": "string" }, "range_end": { "type": "string" } },
            "required": ["range_start", "range_end"],
        },
    }]);
    let mut conditions = Vec::new();
    for id in mandatory_uncertainty(framework) {
        conditions.push(json!({
            "if": is_class(&id),
            "then": { "properties": { "critical_components": {
                "contains": { "properties": { "uncertainty": { "const": "high" } }, "required": ["uncertainty"] },
            } } },
        }));
    }
    for spec in framework.specs.values() {
        if let Some(lateral) = spec.lateral {
            conditions.push(json!({
                "if": is_class(&spec.leaf),
                "then": { "properties": { "driving_decision": { "properties": { "lateral": { "const": lateral.id() } } } } },
            }));
        }
    }
    coc["allOf"] = Value::Array(conditions);
}

fn directions() -> Value {
    let mut conditions = Vec::new();
    let mut without: Vec<Value> = vec![Value::Null];
    for lateral in Lateral::ALL {
        let sides: Vec<&str> = lateral.directions().iter().map(|d| d.id()).collect();
        if sides.is_empty() {
            without.push(json!(lateral.id()));
        } else {
            conditions.push(json!({
                "if": { "properties": { "lateral": { "const": lateral.id() } }, "required": ["lateral"] },
                "then": { "properties": { "lateral_direction": { "enum": sides } }, "required": ["lateral_direction"] },
            }));
        }
    }
    conditions.push(json!({
        "if": { "properties": { "lateral": { "enum": without } }, "required": ["lateral"] },
        "then": { "properties": { "lateral_direction": { "type": "null" } } },
    }));
    Value::Array(conditions)
}

/// Classes that require `uncertainty: high`: a whole L2 where all its leaves do, else single leaves.
fn mandatory_uncertainty(framework: &Framework) -> Vec<ScenarioId> {
    let high = |leaf: &ScenarioId| framework.specs.get(leaf).is_some_and(|s| s.uncertainty_high);
    let mut out = BTreeSet::new();
    for (l1, l2, l3) in framework.taxonomy.leaves() {
        let leaf = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        if l2.l3.iter().all(|c| high(&ScenarioId::leaf(&l1.id, &l2.id, &c.id))) {
            out.insert(ScenarioId { l3: None, ..leaf });
        } else if high(&leaf) {
            out.insert(leaf);
        }
    }
    out.into_iter().collect()
}

/// Holds when `scenario` is `id` or lies below it.
fn is_class(id: &ScenarioId) -> Value {
    let mut properties = json!({ "l1": { "const": id.l1 } });
    let mut required = vec!["l1"];
    for (key, part) in [("l2", &id.l2), ("l3", &id.l3)] {
        if let Some(part) = part {
            properties[key] = json!({ "const": part });
            required.push(key);
        }
    }
    json!({
        "properties": { "scenario": { "properties": properties, "required": required } },
        "required": ["scenario"],
    })
}
