//! The texts of a case file, before signals and times are looked up.

use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use whyroad_model::{Bilingual, ObjectClass};

/// What a case tests about its rule. Every rule has at least one of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseKind {
    /// It happens.
    Positive,
    /// A similar event, but not this one.
    Negative,
    /// On the edge of a threshold.
    Boundary,
    /// An input is unknown.
    Unknown,
}

/// The file. Where a mistake in a case may cost that case only, cases are left as [`IgnoredAny`] and read one by one.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseFile<C = IgnoredAny> {
    #[serde(rename = "version")]
    _version: Option<String>,
    /// Class of the rules; both are absent beside a rule without a class.
    pub l1: Option<String>,
    pub l2: Option<String>,
    /// Signals that the cases have in common.
    #[serde(default)]
    pub base: BTreeMap<String, String>,
    pub cases: Vec<C>,
}

impl CaseKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Positive, Self::Negative, Self::Boundary, Self::Unknown];

    /// As the file writes it.
    pub fn id(self) -> &'static str {
        match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
            Self::Boundary => "boundary",
            Self::Unknown => "unknown",
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseText {
    pub name: String,
    /// L3, or absent for the rule of the L2.
    pub leaf: Option<String>,
    pub kind: CaseKind,
    pub duration: String,
    /// Class of the target.
    pub target: Option<ObjectClass>,
    /// When the target is observed; default: all the time.
    pub seen: Option<[String; 2]>,
    /// Other objects by name: the second role of a rule, or what a count ranges over. Their signals are written
    /// `obstacle.gap`.
    #[serde(default)]
    pub objects: BTreeMap<String, ObjectText>,
    #[serde(default)]
    pub signals: BTreeMap<String, String>,
    /// Signals that the log does not have.
    #[serde(default)]
    pub lacks: Vec<String>,
    pub expect: Vec<Expectation>,
    /// Missing signals that the rule must report as the reason why it cannot be decided.
    #[serde(default)]
    pub not_observable: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectText {
    pub class: ObjectClass,
    pub seen: Option<[String; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Expectation {
    pub keyframe: String,
    pub start: Option<String>,
    pub end: Option<String>,
    pub second_keyframe: Option<String>,
}

/// Why a case fails.
pub type Reason = Bilingual;
