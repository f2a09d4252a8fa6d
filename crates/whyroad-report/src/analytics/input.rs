//! Inputs of the analytics. The caller reads files and stores; `None` means "not given", never zero.

use std::collections::BTreeMap;
use whyroad_label::facts::{Judgement, TaskFacts};
use whyroad_lake::mined::EpisodeSummary;
use whyroad_model::messages::{Coverage, MiningQueryMessage};
use whyroad_model::{DriveId, Nanos, ScenarioId};

/// Everything.
#[derive(Clone, Copy)]
pub struct AnalyticsInputs<'a> {
    /// A mined folder.
    pub mined: Option<&'a MinedFacts>,
    /// Tasks of the labeling service.
    pub tasks: Option<&'a [TaskFacts]>,
    /// Releases, each with its name.
    pub releases: Option<&'a [ReleaseFacts]>,
    /// Required accepted labels by leaf; empty when nothing is stated.
    pub wanted: &'a BTreeMap<ScenarioId, u64>,
    /// Cost of an hour of work.
    pub rate: Option<&'a HourlyRate>,
    /// The moment that ages and forecasts count from; `None` for that of the last entry of the history.
    pub as_of: Option<Nanos>,
    /// Shift of hours of the day from UTC, h.
    pub utc_offset_h: i8,
    /// The query that finds this many more episodes of a class; `None` when its rule has no form as a query.
    pub query: &'a dyn Fn(&ScenarioId, usize) -> Option<MiningQueryMessage>,
}

/// Cost of an hour of work.
#[derive(Clone, Debug, PartialEq)]
pub struct HourlyRate {
    /// Amount for an hour.
    pub amount: f64,
    /// Currency, as written.
    pub currency: String,
}

/// Context that a drive states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveFacts {
    /// Length, s.
    pub seconds: f64,
    /// City or road network.
    pub place: Option<String>,
    /// Vehicle or fleet.
    pub source: Option<String>,
    /// Stated weather, where the whole drive has one or the first of several.
    pub weather: Option<String>,
    /// First frame, where the log states date and time of day.
    pub start: Option<Nanos>,
}

/// Summary of a mined folder.
#[derive(Clone, Debug, Default)]
pub struct MinedFacts {
    /// Search results by leaf.
    pub coverage: Coverage,
    /// The drives.
    pub drives: BTreeMap<DriveId, DriveFacts>,
    /// Its episodes.
    pub episodes: EpisodeTally,
}

/// Counts of episodes: memory grows with classes times drives, not with episodes.
#[derive(Clone, Debug, Default)]
pub struct EpisodeTally {
    /// Episodes and primary ones, by class and drive.
    pub by_class: BTreeMap<ScenarioId, BTreeMap<DriveId, (u64, u64)>>,
    /// Primary episodes by drive and hour of the day, UTC.
    pub by_hour: BTreeMap<DriveId, [u64; 24]>,
}

impl EpisodeTally {
    /// Counts an episode.
    pub fn add(&mut self, episode: EpisodeSummary) {
        if episode.is_primary {
            self.by_hour.entry(episode.drive_id.clone()).or_default()[hour(episode.keyframe)] += 1;
        }
        let of_class = self.by_class.entry(episode.scenario_id).or_default();
        let n = of_class.entry(episode.drive_id).or_default();
        n.0 += 1;
        if episode.is_primary {
            n.1 += 1;
        }
    }
}

/// Hour of the day, UTC.
pub(crate) fn hour(time: Nanos) -> usize {
    (time.0.div_euclid(3_600_000_000_000)).rem_euclid(24) as usize
}

/// Summary of a release.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReleaseFacts {
    /// Name and version.
    pub name: String,
    /// Its samples.
    pub samples: Vec<SampleFacts>,
}

/// Summary of a sample of a release.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleFacts {
    /// Id: the same sample in every release.
    pub sample: String,
    /// Class, decisions and keyframe.
    pub judgement: Judgement,
    /// Whether its drive states date and time of day.
    pub dated: bool,
    /// City or road network.
    pub place: Option<String>,
    /// Vehicle or fleet.
    pub source: Option<String>,
    /// Stated weather.
    pub weather: Option<String>,
}
