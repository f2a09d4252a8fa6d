//! Labeling specs after inheritance: requirements for a labeler of one leaf (LABELING.md 4, TAXONOMY.md last column).
//! An L3 states its differences from its L2, an L2 those from its L1's default.

mod expressions;
mod inherit;
pub mod raw;
mod read;

pub(crate) use expressions::Written;
pub(crate) use inherit::{finish, overlay};
pub(crate) use read::{ReadSpec, read_spec};

use whyroad_model::decision::Lateral;
use whyroad_model::messages::KeyframeType;
use whyroad_model::{Bilingual, ScenarioId};

/// All labeling requirements of one leaf.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ResolvedSpec {
    /// Which leaf.
    pub leaf: ScenarioId,
    /// The decision moment or range.
    pub keyframe: KeyframeSpec,
    /// Only where a leaf has two (`cutout_reveal`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_keyframe: Option<KeyframeSpec>,
    /// Start of `time_range`.
    pub start: BoundSpec,
    /// End of `time_range`.
    pub end: BoundSpec,
    /// Context kept outside `time_range`.
    pub pack: PackSpec,
    /// Records that the annotator must fill in besides the label, in file order.
    pub records: Vec<RecordSpec>,
    /// True when at least one critical component must have `uncertainty: high` (LABELING.md 3).
    pub uncertainty_high: bool,
    /// The lateral decision that the leaf prescribes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral: Option<Lateral>,
}

/// A keyframe: its kind, its rule as text and, where signals exist for it, as a moment of the rule language.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct KeyframeSpec {
    /// One moment or a range.
    #[serde(rename = "type")]
    pub kind: KeyframeType,
    /// In words.
    pub rule: Bilingual,
    /// In the rule language.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expr: Option<String>,
    /// Used when the rule gives no moment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback: Option<MomentSpec>,
}

/// A start or an end.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BoundSpec {
    /// In words.
    pub rule: Bilingual,
    /// In the rule language.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expr: Option<String>,
    /// Used when the rule gives no moment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback: Option<MomentSpec>,
}

/// A moment as text and, where signals exist for it, in the rule language.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MomentSpec {
    /// In words.
    pub rule: Bilingual,
    /// In the rule language.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expr: Option<String>,
}

/// Context outside `time_range`.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct PackSpec {
    /// Before the start, s.
    pub before_s: f64,
    /// After the end, s.
    pub after_s: f64,
    /// The context after the end stops here when this comes first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_until: Option<MomentSpec>,
}

/// A record to fill in.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RecordSpec {
    /// Key in the label's `records`.
    pub id: String,
    /// Displayed name.
    pub name: Bilingual,
    /// Unit of a measured value; absent for text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Signal that measures it: its value at the keyframe is proposed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signal: Option<String>,
    /// The value is the id of an object of the scene.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub object: bool,
    /// The object is the target of the rule, which is proposed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub target: bool,
    /// The values to choose from; empty for free text and for measured values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<RecordChoice>,
}

/// One value of a record to choose.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RecordChoice {
    /// Value in the label's `records`.
    pub id: String,
    /// Displayed name.
    pub name: Bilingual,
    /// Values of the record's signal for which it is proposed, besides its own id.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<String>,
}
