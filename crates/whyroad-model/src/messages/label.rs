//! The CoC label (DATA_FORMAT.md 4) and the scenario label (2.2). Their fields are those of `schema/label_fields.yaml`,
//! from which the build script makes the types.

use crate::Nanos;
use crate::decision::{Lateral, LateralDirection, Longitudinal, closed_set};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

include!(concat!(env!("OUT_DIR"), "/label_types.rs"));

/// `{"scenario_label": {...}}` (DATA_FORMAT.md 2.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScenarioLabelMessage {
    /// The label.
    pub scenario_label: ScenarioLabel,
}

closed_set!(
    /// Kind of keyframe (LABELING.md 4).
    KeyframeType {
        /// One moment.
        Reactive = "reactive",
        /// A range.
        Proactive = "proactive",
    }
);

closed_set!(
    /// Level of certainty, given the annotator and the situation.
    Uncertainty {
        /// Plain.
        Low = "low",
        /// Blind spot, occlusion or unclear intention.
        High = "high",
    }
);

closed_set!(
    /// Answer of the safety filter (LABELING.md 6).
    SafetyAnswer {
        /// Legal and safe.
        Safe = "safe",
        /// Illegal or unsafe: the sample is rejected.
        Unsafe = "unsafe",
    }
);

closed_set!(
    /// Who made a label.
    ProvenanceSource {
        /// A mining rule.
        Rule = "rule",
        /// A model.
        Model = "model",
        /// A person.
        Person = "person",
    }
);

/// An `Option` whose key must be there: serde's own default treats a missing key as null.
fn present<'de, D, T>(d: D) -> Result<Option<T>, D::Error>
where
    D: serde::Deserializer<'de>,
    T: Deserialize<'de>,
{
    Option::<T>::deserialize(d)
}

/// A field that must be there and may be null. By default schemars treats an `Option` as a field that may be absent.
fn decision_or_null<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    let decision = T::json_schema(generator);
    json_schema!({
        "anyOf": [decision, { "type": "null", "description": "No change of decision." }],
    })
}

/// `null` for an optional list is the same as an absent list, as for every other optional field.
fn none_as_empty<'de, D: serde::Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or_default())
}
