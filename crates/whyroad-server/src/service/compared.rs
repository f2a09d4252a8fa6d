//! Compares two labels of one episode, field by field: a gold answer and a label, or labels of an overlap group. Texts
//! are not compared, because different people always write different texts.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_label::facts::Judgement;
use whyroad_model::label_fields::{name, pointer};

/// Maximum distance of keyframes that agree, s.
const KEYFRAME_S: f64 = 0.5;

/// Whether `label` agrees with `answer`, field by field.
pub(super) fn compare(answer: &Value, label: &Value) -> BTreeMap<&'static str, bool> {
    let (a, b) = (Judgement::of(answer), Judgement::of(label));
    let near = a.keyframe.zip(b.keyframe).is_some_and(|(a, b)| a.seconds_since(b).abs() <= KEYFRAME_S);
    let mut out: BTreeMap<&'static str, bool> = [
        ("scenario", a.scenario == b.scenario),
        ("longitudinal", a.longitudinal == b.longitudinal),
        ("lateral", (a.lateral, a.lateral_direction) == (b.lateral, b.lateral_direction)),
        ("keyframe", near),
    ]
    .into();
    let causes = causal_objects(answer);
    // If the answer names no object, this is not compared.
    if !causes.is_empty() {
        out.insert("objects", causes.is_subset(&causal_objects(label)));
    }
    out
}

/// True where two labels decide differently. One label may name more causes than the other: they disagree only if each
/// names an object that the other does not.
pub(super) fn disagree(a: &Value, b: &Value) -> bool {
    let (there, back) = (compare(a, b), compare(b, a));
    there.iter().any(|(field, agrees)| !agrees && back.get(field) == Some(&false))
}

/// Objects of the components that are causes.
fn causal_objects(label: &Value) -> BTreeSet<&str> {
    let named = |at: &str| label.pointer(at).and_then(Value::as_array).into_iter().flatten();
    let causes: BTreeSet<&str> = named(pointer::CAUSES_LONGITUDINAL_COMPONENTS)
        .chain(named(pointer::CAUSES_LATERAL_COMPONENTS))
        .filter_map(Value::as_str)
        .collect();
    let components = named(pointer::CRITICAL_COMPONENTS);
    components
        .filter(|c| c[name::ID].as_str().is_some_and(|id| causes.contains(id)))
        .flat_map(|c| c[name::LINKED_OBJECTS].as_array().into_iter().flatten())
        .filter_map(Value::as_str)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn label(longitudinal: &str, moment: &str, objects: &Value) -> Value {
        json!({
            "keyframe": { "timestamp": moment },
            "driving_decision": { "longitudinal": longitudinal, "lateral": null },
            "causes": { "longitudinal": { "components": ["c1"] } },
            "critical_components": [{ "id": "c1", "description": moment, "linked_objects": objects }],
            "coc_trace": moment,
        })
    }

    #[test]
    fn labels_disagree_where_one_decision_cannot_stand_for_the_other() {
        let one = label("yield_to_agent", "2026-01-01T00:00:05.000Z", &json!(["t1"]));
        let differs = |other: &Value| (disagree(&one, other), disagree(other, &one));
        // Another text, a keyframe half a second later, or an additional object is no disagreement.
        assert_eq!(
            differs(&label("yield_to_agent", "2026-01-01T00:00:05.500Z", &json!(["t1", "t2"]))),
            (false, false)
        );
        assert_eq!(differs(&label("yield_to_agent", "2026-01-01T00:00:05.000Z", &json!([]))), (false, false));
        for other in [
            label("lead_following", "2026-01-01T00:00:05.000Z", &json!(["t1"])),
            label("yield_to_agent", "2026-01-01T00:00:05.600Z", &json!(["t1"])),
            label("yield_to_agent", "2026-01-01T00:00:05.000Z", &json!(["t2"])),
        ] {
            assert_eq!(differs(&other), (true, true), "{other}");
        }
    }
}
