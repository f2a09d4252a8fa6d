//! Drafts from elsewhere: what Stage I shows of them was known at the suggested keyframe. It shows none of their
//! components, whose words may tell what comes later; these are kept for Stage II.

use serde_json::Value;
use whyroad_model::Nanos;
use whyroad_model::label_fields::{LabelField, name, pointer};
use whyroad_model::messages::Keyframe;

/// The draft with the data known at the suggested keyframe in those fields that Stage I shows: fields of the format
/// only, and no later keyframe.
pub fn known_then(mut draft: Value, suggested: &Keyframe) -> Value {
    only_fields(draft.get_mut(name::SCENARIO), pointer::SCENARIO);
    keyframe(&mut draft, suggested);
    remove_unless(&mut draft, name::CRITICAL_COMPONENTS, Value::is_array);
    draft
}

/// Whether a time is later than the keyframe. One that cannot be read may be.
fn is_late(time: &Value, keyframe: Nanos) -> bool {
    let moment = time.as_str().and_then(|text| Nanos::parse_iso(text).ok());
    moment.is_none_or(|at| at > keyframe)
}

/// Keeps the fields of the format; `at` is the place of the object.
fn only_fields(fields: Option<&mut Value>, at: &str) {
    if let Some(fields) = fields.and_then(Value::as_object_mut) {
        fields.retain(|name, _| LabelField::at(&format!("{at}/{name}")).is_some());
    }
}

/// Removes a field that is not of its type.
fn remove_unless(draft: &mut Value, name: &str, fits: fn(&Value) -> bool) {
    if draft.get(name).is_some_and(|v| !fits(v))
        && let Some(fields) = draft.as_object_mut()
    {
        fields.remove(name);
    }
}

fn keyframe(draft: &mut Value, suggested: &Keyframe) {
    remove_unless(draft, name::KEYFRAME, Value::is_object);
    only_fields(draft.get_mut(name::KEYFRAME), pointer::KEYFRAME);
    let Some(own) = draft.get_mut(name::KEYFRAME).and_then(Value::as_object_mut) else { return };
    let late = |time: &Value| is_late(time, suggested.timestamp);
    if own.get(name::TIMESTAMP).is_none_or(late) {
        own.insert(name::TIMESTAMP.to_owned(), Value::String(suggested.timestamp.to_string()));
        own.insert(name::FRAME_IDX.to_owned(), suggested.frame_idx.into());
    }
    if own.get(name::RANGE_START).is_some_and(late) {
        own.remove(name::RANGE_START);
    }
}
