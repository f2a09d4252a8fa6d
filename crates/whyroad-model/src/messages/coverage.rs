//! What mining looked for and found, leaf by leaf: `coverage.json`. Not one of DATA_FORMAT.md's
//! messages; a rule that could not be decided is never counted as one that found nothing.

use crate::decision::closed_set;
use crate::{DriveId, ScenarioId};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::Deref;
use std::sync::Arc;

/// One mining run over a lake.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Coverage {
    /// Version of the taxonomy whose leaves these are.
    pub taxonomy_version: String,
    /// Drives that were searched, sorted.
    pub drives: Vec<DriveId>,
    /// Drives that could not be searched, sorted: nothing is known about what happened in them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOutDrive>,
    /// Every leaf of the taxonomy, in its order; after a custom question (`--rule`, `--query`) only its class.
    pub leaves: Vec<LeafCoverage>,
    /// L2s with their own rule, for episodes whose L2 is known but not the variant. In taxonomy order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unresolved: Vec<LeafCoverage>,
}

/// A drive that could not be searched.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOutDrive {
    /// The drive.
    pub drive_id: DriveId,
    /// Code of the diagnostic that says why.
    pub code: String,
}

closed_set!(
    /// What is known about a leaf after a mining run.
    CoverageState {
        /// At least one episode.
        Found = "found",
        /// Its rule could be decided on at least one drive, and nothing was found.
        NotFound = "not_found",
        /// It has a rule, but every drive lacks signals that it needs.
        NotObservable = "not_observable",
        /// No rule is written yet.
        NoRule = "no_rule",
    }
);

/// One leaf.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeafCoverage {
    /// The leaf.
    pub scenario_id: ScenarioId,
    /// The state over all drives.
    pub state: CoverageState,
    /// Episodes, primary and secondary.
    pub episodes: u64,
    /// Episodes for which this leaf was the primary one.
    pub primary_episodes: u64,
    /// Drives on which the rule could be decided.
    pub drives_searched: u64,
    /// Drives on which it could not be decided, by what they lack.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<DriveGap>,
}

/// Why a rule could not be decided on some drives.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct DriveGap {
    /// The drives, sorted.
    #[schemars(with = "Vec<DriveId>")]
    pub drives: DriveList,
    /// Signals that the rule needs and these drives cannot support, sorted.
    pub missing_signals: Vec<String>,
}

/// Ids of drives, sorted. Classes that lack the same signals on the same drives share one list; in JSON it is a plain
/// list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriveList(pub Arc<[DriveId]>);

impl Deref for DriveList {
    type Target = [DriveId];

    fn deref(&self) -> &[DriveId] {
        &self.0
    }
}

impl From<Vec<DriveId>> for DriveList {
    fn from(drives: Vec<DriveId>) -> Self {
        Self(drives.into())
    }
}

impl<'a> IntoIterator for &'a DriveList {
    type Item = &'a DriveId;
    type IntoIter = std::slice::Iter<'a, DriveId>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl Serialize for DriveList {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.iter())
    }
}

impl<'de> Deserialize<'de> for DriveList {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Vec::deserialize(from).map(Self::from)
    }
}
