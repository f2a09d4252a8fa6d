//! What people changed in a draft until its label was accepted, field by field of the label's table of fields.

use serde_json::Value;
use whyroad_model::Nanos;
use whyroad_model::label_fields::{LABEL_FIELDS, LabelField, name, pointer};
use whyroad_model::messages::Uncertainty;

/// Differences between a draft and the accepted label.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Revision {
    /// Pointers of the fields that differ, in the order of the table. A list (components, records) is one field.
    pub changed: Vec<&'static str>,
    /// Keyframe of the label minus that of the draft, s; `None` where one of them has none.
    pub keyframe_shift_s: Option<f64>,
}

/// Fields that the service writes into every label.
const WRITTEN_BY_THE_SERVICE: [&str; 4] = ["/version", "/clip_id", "/safety_filter", "/provenance"];

impl Revision {
    /// The fields that a revision compares: single values, and lists as a whole.
    pub fn fields() -> impl Iterator<Item = &'static LabelField> {
        LABEL_FIELDS.iter().filter(|f| {
            let inner = |other: &&LabelField| {
                let below = other.pointer.strip_prefix(f.pointer).and_then(|rest| rest.strip_prefix('/'));
                below.is_some_and(|rest| !rest.starts_with('*'))
            };
            let own = WRITTEN_BY_THE_SERVICE
                .iter()
                .any(|p| f.pointer == *p || f.pointer.strip_prefix(p).is_some_and(|r| r.starts_with('/')));
            // Frames are derived from times, the full id from its parts.
            let derived = f.pointer.ends_with("frame_idx") || f.pointer.ends_with("full_id");
            !f.pointer.contains('*') && !own && !derived && !LABEL_FIELDS.iter().any(|o| inner(&o))
        })
    }
}

/// Compares a draft with the label made from it.
pub fn revision(draft: &Value, label: &Value) -> Revision {
    let at = |of: &Value| {
        let text = of.pointer(pointer::KEYFRAME_TIMESTAMP).and_then(Value::as_str)?;
        Nanos::parse_iso(text).ok()
    };
    let changed = Revision::fields().map(|f| f.pointer);
    let is_same = |p: &str| {
        if p == pointer::CRITICAL_COMPONENTS {
            same(stated(draft, p).as_ref(), stated(label, p).as_ref())
        } else {
            same(draft.pointer(p), label.pointer(p))
        }
    };
    Revision {
        changed: changed.filter(|p| !is_same(p)).collect(),
        keyframe_shift_s: at(label).zip(at(draft)).map(|(now, then)| now.seconds_since(then)),
    }
}

/// The components with the uncertainty that they have where nobody states one: low. The page writes it into every
/// label.
fn stated(of: &Value, at: &str) -> Option<Value> {
    let mut components = of.pointer(at)?.clone();
    for fields in components.as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
        let uncertainty = fields.entry(name::UNCERTAINTY).or_insert(Value::Null);
        if uncertainty.is_null() {
            *uncertainty = Value::from(Uncertainty::Low.id());
        }
    }
    Some(components)
}

/// Null, an absent field and an empty list are equal; times are compared as moments.
fn same(a: Option<&Value>, b: Option<&Value>) -> bool {
    let stated = |v: &&Value| match v {
        Value::Null => false,
        Value::Array(items) => !items.is_empty(),
        Value::Object(fields) => !fields.is_empty(),
        _ => true,
    };
    match (a.filter(stated), b.filter(stated)) {
        (None, None) => true,
        (Some(a), Some(b)) => a == b || time(a).is_some_and(|t| Some(t) == time(b)),
        _ => false,
    }
}

fn time(value: &Value) -> Option<Nanos> {
    Nanos::parse_iso(value.as_str()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn changed_fields_are_named_by_their_pointers() {
        let draft = json!({
            "keyframe": {"timestamp": "2026-01-01T00:00:02.000Z", "frame_idx": 10, "type": "reactive"},
            "driving_decision": {"longitudinal": null, "lateral": null},
            "critical_components": [{"description": "a car"}], "coc_trace": "t",
        });
        let mut label = draft.clone();
        label["keyframe"]["timestamp"] = json!("2026-01-01T00:00:01.6Z");
        label["keyframe"]["frame_idx"] = json!(6);
        label["driving_decision"]["longitudinal"] = json!("yield");
        label["critical_components"][0]["description"] = json!("a white car");
        label["records"] = json!({});
        label["provenance"] = json!({"source": "person"});
        let found = revision(&draft, &label);
        assert_eq!(
            found.changed,
            ["/keyframe/timestamp", "/driving_decision/longitudinal", "/critical_components"]
        );
        assert!((found.keyframe_shift_s.unwrap() + 0.4).abs() < 1e-9);
        assert_eq!(revision(&draft, &draft).changed, Vec::<&str>::new());
    }

    #[test]
    fn an_uncertainty_that_was_left_out_is_low() {
        let of = |uncertainty: Value| json!({ "critical_components": [{ "description": "a car", "uncertainty": uncertainty }] });
        let draft = json!({ "critical_components": [{ "description": "a car" }] });
        assert!(revision(&draft, &of(json!("low"))).changed.is_empty());
        assert!(revision(&of(Value::Null), &of(json!("low"))).changed.is_empty());
        assert_eq!(revision(&draft, &of(json!("high"))).changed, ["/critical_components"]);
    }

    #[test]
    fn one_moment_written_in_two_ways_is_no_change() {
        let at = |text: &str| json!({"keyframe": {"timestamp": text}});
        let (a, b) = (at("2026-01-01T00:00:02Z"), at("2026-01-01T00:00:02.000Z"));
        assert!(revision(&a, &b).changed.is_empty());
        assert_eq!(revision(&json!({}), &a).keyframe_shift_s, None);
    }

    #[test]
    fn every_compared_field_is_one_that_a_person_can_change() {
        let fields: Vec<&str> = Revision::fields().map(|f| f.pointer).collect();
        assert!(fields.contains(&"/coc_trace") && fields.contains(&"/scenario/l3"), "{fields:?}");
        assert!(!fields.iter().any(|f| f.starts_with("/provenance") || *f == "/keyframe"), "{fields:?}");
    }
}
