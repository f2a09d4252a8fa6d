//! The answers of the two calls: their forms as JSON Schema, and how they are read. Constraints that a schema cannot
//! express, or an endpoint does not enforce, are checked here.

use crate::AnswerForm;
use serde::Deserialize;
use serde_json::{Value, json};
use whyroad_model::ComponentCategory;
use whyroad_model::decision::{Lateral, LateralDirection, Longitudinal};
use whyroad_model::messages::{Cause, Uncertainty};

/// Components of a draft.
const MOST_COMPONENTS: usize = 6;
/// Longest texts, characters.
const LONGEST_DESCRIPTION: usize = 300;
const LONGEST_TRACE: usize = 1000;

/// Components.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HistoryAnswer {
    pub components: Vec<SaidComponent>,
}

/// One component.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SaidComponent {
    pub description: String,
    pub category: String,
    pub uncertainty: Uncertainty,
    pub objects: Vec<String>,
}

/// Decision, causes, trace.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FutureAnswer {
    pub longitudinal: Option<Longitudinal>,
    pub lateral: Option<Lateral>,
    pub lateral_direction: Option<LateralDirection>,
    pub causes: SaidCauses,
    pub trace: String,
    pub safe: bool,
    pub safety_reason: String,
}

/// Causes of both channels.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SaidCauses {
    pub longitudinal: SaidCause,
    pub lateral: SaidCause,
}

/// Causes of one channel.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SaidCause {
    pub components: Vec<String>,
    pub unobserved: String,
}

impl SaidCause {
    /// As a label has it; `None` where nothing is stated.
    pub fn into_cause(self) -> Option<Cause> {
        let unobserved = self.unobserved.trim();
        let reason = (self.components.is_empty() && !unobserved.is_empty()).then(|| unobserved.to_owned());
        (!self.components.is_empty() || reason.is_some())
            .then_some(Cause { components: self.components, unobserved: reason })
    }
}

/// Every property required, no others.
fn object(properties: Value) -> Value {
    let required: Vec<&String> = properties.as_object().map(|p| p.keys().collect()).unwrap_or_default();
    json!({ "type": "object", "required": required, "additionalProperties": false, "properties": properties })
}

/// A list of some of `ids`.
fn some_of<S: AsRef<str>>(ids: &[S]) -> Value {
    let ids: Vec<&str> = ids.iter().map(AsRef::as_ref).collect();
    // An enum must not be empty.
    let item =
        if ids.is_empty() { json!({ "type": "string" }) } else { json!({ "type": "string", "enum": ids }) };
    json!({ "type": "array", "items": item })
}

/// One of `ids`, or null.
fn or_null(ids: impl Iterator<Item = &'static str>) -> Value {
    let all: Vec<Value> = ids.map(Value::from).chain([Value::Null]).collect();
    json!({ "type": ["string", "null"], "enum": all })
}

/// Form of the first answer; `objects` are ids of the record.
pub(super) fn history_form(objects: &[&str]) -> AnswerForm {
    let categories: Vec<&str> = ComponentCategory::ALL.iter().map(|c| c.id()).collect();
    let component = object(json!({
        "description": { "type": "string" },
        "category": { "type": "string", "enum": categories },
        "uncertainty": { "type": "string", "enum": ["low", "high"] },
        "objects": some_of(objects),
    }));
    let schema = object(json!({ "components": { "type": "array", "items": component } }));
    AnswerForm { name: "draft_history", schema }
}

/// Form of the second answer; `components` are ids of the first one's.
pub(super) fn future_form(components: &[String]) -> AnswerForm {
    let cause = object(json!({ "components": some_of(components), "unobserved": { "type": "string" } }));
    let schema = object(json!({
        "longitudinal": or_null(Longitudinal::ALL.iter().map(|d| d.id())),
        "lateral": or_null(Lateral::ALL.iter().map(|d| d.id())),
        "lateral_direction": or_null(LateralDirection::ALL.iter().map(|d| d.id())),
        "causes": object(json!({ "longitudinal": cause, "lateral": cause })),
        "trace": { "type": "string" },
        "safe": { "type": "boolean" },
        "safety_reason": { "type": "string" },
    }));
    AnswerForm { name: "draft_future", schema }
}

impl HistoryAnswer {
    pub fn read(text: &str, objects: &[&str]) -> Result<Self, String> {
        let answer: Self = serde_json::from_str(text).map_err(|e| e.to_string())?;
        if !(1..=MOST_COMPONENTS).contains(&answer.components.len()) {
            return Err(format!("it has {} components, not 1 to {MOST_COMPONENTS}", answer.components.len()));
        }
        for c in &answer.components {
            let length = c.description.trim().chars().count();
            if !(1..=LONGEST_DESCRIPTION).contains(&length) {
                return Err(format!("a description has {length} characters"));
            }
            if ComponentCategory::from_id(&c.category).is_none() {
                return Err("a category is not one of those listed".to_owned());
            }
            if c.objects.iter().any(|o| !objects.contains(&o.as_str())) {
                return Err("an object is not one of those listed".to_owned());
            }
        }
        Ok(answer)
    }
}

impl FutureAnswer {
    pub fn read(text: &str, components: &[String]) -> Result<Self, String> {
        let answer: Self = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let length = answer.trace.trim().chars().count();
        if !(1..=LONGEST_TRACE).contains(&length) {
            return Err(format!("the trace has {length} characters"));
        }
        let causes = &answer.causes;
        let mut named = causes.longitudinal.components.iter().chain(&causes.lateral.components);
        if named.any(|c| !components.contains(c)) {
            return Err("a cause is not one of the components".to_owned());
        }
        Ok(answer)
    }
}
