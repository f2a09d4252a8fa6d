//! Asking for the episodes of a mined folder page by page: the request, and the content of one page. Not messages of
//! DATA_FORMAT.md: types that the lake (which reads) and the service (which requests) share.

use super::episode::EpisodeRecord;
use crate::ids::OTHER;
use crate::{DriveId, ScenarioId};
use std::collections::BTreeSet;

/// Filter of episodes. The default is all of them; every field that is set narrows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EpisodeFilter {
    /// Only episodes of this class or below it.
    pub scenario: Option<ScenarioId>,
    /// Only episodes of this drive.
    pub drive: Option<DriveId>,
    /// Only episodes of exactly one of these classes, by id.
    pub classes: Option<BTreeSet<String>>,
    /// Only episodes that a class explains, not `other`.
    pub explained_only: bool,
    /// Only episodes that arbitration made primary.
    pub primary_only: bool,
    /// Only episodes with at least this score, 0 to 1.
    pub min_score: Option<f64>,
}

impl EpisodeFilter {
    /// True when no field is set.
    pub fn is_all(&self) -> bool {
        *self == Self::default()
    }

    /// True when `record` matches.
    pub fn accepts(&self, record: &EpisodeRecord) -> bool {
        self.scenario.as_ref().is_none_or(|id| record.scenario_id.is_within(id))
            && self.drive.as_ref().is_none_or(|id| record.drive_id == *id)
            && self.classes.as_ref().is_none_or(|ids| ids.contains(&record.scenario_id.to_string()))
            && (!self.explained_only || record.scenario_id.l1 != OTHER)
            && (!self.primary_only || record.is_primary)
            && self.min_score.is_none_or(|min| record.score >= min)
    }
}

/// Where to continue after a page. Only valid for the folder and the filter that it came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EpisodeCursor(pub u64);

/// Some of the requested episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EpisodePage {
    /// In the order of drive, keyframe, class, target.
    pub episodes: Vec<EpisodeRecord>,
    /// Where the next page begins; `None` when this is the last one.
    pub next: Option<EpisodeCursor>,
}
