//! The fields that a rule names, message by message: how often each was there, and in a form that is understood. What
//! was not becomes a finding, so that no value is unknown in silence.

use super::values::{Form, Read};
use serde_json::Value;
use std::collections::BTreeMap;

/// Characters of an example in a finding.
const EXAMPLE_CHARS: usize = 60;

/// What became of one field.
#[derive(Default)]
pub(super) struct FieldCount {
    pub path: String,
    pub read: usize,
    pub absent: usize,
    /// What is there instead of the first part that is absent.
    pub beside: String,
    pub foreign: usize,
    /// The first value that was not understood, and the forms that are.
    pub example: Option<(String, Form)>,
}

/// By the field's name in the mapping file.
#[derive(Default)]
pub(super) struct FieldCounts(pub BTreeMap<&'static str, FieldCount>);

/// What a message says about a field.
#[derive(Debug, PartialEq)]
pub(super) enum Field<T> {
    Known(T),
    /// The message states that it is unknown.
    Unknown,
    /// In a form that is not understood.
    Foreign,
    /// The message does not have it, or the rule does not name it.
    Absent,
}

impl<T> Field<T> {
    pub fn known(self) -> Option<T> {
        match self {
            Field::Known(value) => Some(value),
            _ => None,
        }
    }
}

/// The value at a path. In a list of `{key, value}` (Foxglove's metadata) a part is also the name of a key. Otherwise
/// the last value on the way.
pub(super) fn at<'v>(value: &'v Value, path: &str) -> Result<&'v Value, &'v Value> {
    path.split('.').try_fold(value, |v, part| {
        let next = match v {
            Value::Array(list) => match part.parse::<usize>() {
                Ok(i) => list.get(i),
                Err(_) => list
                    .iter()
                    .find(|e| e.get("key").and_then(Value::as_str) == Some(part))
                    .and_then(|e| e.get("value")),
            },
            _ => v.get(part),
        };
        next.ok_or(v)
    })
}

impl FieldCounts {
    /// The field `name`, at the path of the rule in the first of `places` that has it.
    pub fn read<T>(
        &mut self,
        name: &'static str,
        path: Option<&str>,
        places: &[&Value],
        form: impl Fn(&Value) -> Read<T>,
    ) -> Field<T> {
        let Some(path) = path else { return Field::Absent };
        let count =
            self.0.entry(name).or_insert_with(|| FieldCount { path: path.into(), ..Default::default() });
        count.read += 1;
        let Some(value) = places.iter().find_map(|place| at(place, path).ok()) else {
            if count.absent == 0 {
                let last = places.last().and_then(|place| at(place, path).err());
                count.beside = last.map(members).unwrap_or_default();
            }
            count.absent += 1;
            return Field::Absent;
        };
        match form(value) {
            Ok(Some(value)) => Field::Known(value),
            Ok(None) => Field::Unknown,
            Err(form) => {
                count.foreign += 1;
                count.example.get_or_insert_with(|| (short(value), form));
                Field::Foreign
            }
        }
    }
}

/// Names of the parts of a value.
fn members(value: &Value) -> String {
    match value {
        Value::Object(parts) => parts.keys().map(String::as_str).collect::<Vec<_>>().join(", "),
        _ => short(value),
    }
}

fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(EXAMPLE_CHARS) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
