//! Labeling specs as written, before inheritance. `schema/labeling_spec_schema.json` is generated from these
//! types; `read` fills them. Fields that a file leaves out are `None` and come from the level above.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Serialize;
use whyroad_model::Bilingual;
use whyroad_model::decision::Lateral;
use whyroad_model::messages::{KeyframeType, Uncertainty};

/// A file of `scenarios/`: `<l1>.yaml`, the defaults of an L1 (no `l2`, no `leaves`), or `<l1>/<l2>.yaml`, an L2 with
/// all its leaves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpecFile {
    /// Version of the framework's data, `major.minor.patch`.
    #[schemars(regex(pattern = r"^(0|[1-9][0-9]*)\.(0|[1-9][0-9]*)\.(0|[1-9][0-9]*)$"))]
    pub version: String,
    /// The L1.
    pub l1: String,
    /// The L2; absent in the file of an L1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub l2: Option<String>,
    /// Settings of the whole L1 or L2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labeling: Option<LabelingLayer>,
    /// The mining rule of the L2, which its leaves' rules inherit from (docs/reference/rules.md).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mining: Option<serde_json::Map<String, serde_json::Value>>,
    /// Every leaf of the L2, in taxonomy order; `{}` where nothing differs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leaves: Option<IndexMap<String, LeafLayer>>,
}

/// Settings of a leaf.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeafLayer {
    /// Where its labeling differs from its L2's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labeling: Option<LabelingLayer>,
    /// Its mining rule (docs/reference/rules.md); absent while there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mining: Option<serde_json::Map<String, serde_json::Value>>,
}

/// One level's labeling rules.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LabelingLayer {
    /// The decision moment or range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframe: Option<KeyframeLayer>,
    /// A second decision moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<KeyframeLayer>,
    /// Start of `time_range`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<BoundLayer>,
    /// End of `time_range`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<BoundLayer>,
    /// Context outside `time_range`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pack: Option<PackLayer>,
    /// Records that the annotator must fill in; added to the records of the level above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub records: Option<Vec<RecordLayer>>,
    /// `high`: at least one critical component must carry it. `low`: not mandatory, also where the level above says
    /// high.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The lateral decision that the class prescribes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral: Option<Lateral>,
}

/// A keyframe. `rule` and `expr` state the same thing: a level that states the rule does not inherit the expression.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeLayer {
    /// One moment or a range.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<KeyframeType>,
    /// In words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<Words>,
    /// As a moment of the rule language.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub expr: Option<String>,
    /// Used when the rule gives no moment. Not inherited by a level that changes `type`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fallback: Option<MomentLayer>,
}

/// A start or an end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundLayer {
    /// In words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<Words>,
    /// As a moment of the rule language.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub expr: Option<String>,
    /// Used when the rule gives no moment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fallback: Option<MomentLayer>,
}

/// A moment: as text, and as an expression where signals exist for it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MomentLayer {
    /// In words.
    pub rule: Words,
    /// As a moment of the rule language.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub expr: Option<String>,
}

/// Context outside `time_range`, s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PackLayer {
    /// Before the start, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub before_s: Option<f64>,
    /// After the end, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub after_s: Option<f64>,
    /// The context after the end stops here when this comes first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_until: Option<MomentLayer>,
}

/// A record to fill in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordLayer {
    /// Key in the label's `records`.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]*$"))]
    pub id: String,
    /// Displayed name.
    pub name: Words,
    /// Unit of a measured value; absent for text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1))]
    pub unit: Option<String>,
    /// Signal that measures it: its value at the keyframe is proposed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<String>,
    /// The value is the id of an object of the scene.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub object: bool,
    /// The object is the target of the rule, which is proposed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub target: bool,
    /// The values to choose from; absent for free text and for measured values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceLayer>,
}

/// One value of a record to choose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChoiceLayer {
    /// Value in the label's `records`.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]*$"))]
    pub id: String,
    /// Displayed name.
    pub name: Words,
    /// Values of the record's signal for which it is proposed, besides its own id.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<String>,
}

/// One text in Chinese and English, neither empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// Chinese.
    #[schemars(length(min = 1))]
    pub zh: String,
    /// English.
    #[schemars(length(min = 1))]
    pub en: String,
}

impl From<&Words> for Bilingual {
    fn from(w: &Words) -> Self {
        Bilingual::new(w.zh.as_str(), w.en.as_str())
    }
}
