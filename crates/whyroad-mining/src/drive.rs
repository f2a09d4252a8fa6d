//! One drive: every rule run, the episodes arbitrated, undecided rules listed. A pure function; the
//! unit that runs in parallel, also inside other engines.

use crate::episode::arbitrate::arbitrate;
use crate::episode::{Episode, Found, find};
use crate::rule::RuleSet;
use std::collections::BTreeMap;
use whyroad_model::{DriveId, Nanos, ScenarioId, SignalTable};

/// Results of one drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveEpisodes {
    /// The drive.
    pub drive_id: DriveId,
    /// Episodes in order of keyframe, class, target.
    pub episodes: Vec<Episode>,
    /// For each rule, by its class: the missing signals without which it cannot be decided (none: it was searched for).
    pub missing: BTreeMap<ScenarioId, Vec<String>>,
}

/// Runs all rules over the signals of one drive, by the reference evaluator.
pub fn mine_drive(rules: &RuleSet, table: &SignalTable) -> DriveEpisodes {
    let found = rules.rules.iter().map(|rule| find(rule, table));
    arbitrated(rules, &table.drive_id, &table.times, found)
}

/// One drive's episodes, from the results of each rule: arbitrated by their margin scores, then calibrated.
pub fn arbitrated(
    rules: &RuleSet,
    drive: &DriveId,
    times: &[Nanos],
    found: impl IntoIterator<Item = Found>,
) -> DriveEpisodes {
    let mut out = DriveEpisodes { drive_id: drive.clone(), ..DriveEpisodes::default() };
    let mut episodes = Vec::new();
    for (rule, found) in rules.rules.iter().zip(found) {
        episodes.extend(found.episodes);
        out.missing.insert(rule.scenario.clone(), found.missing.into_iter().collect());
    }
    out.episodes = arbitrate(episodes, times, &rules.precedence);
    for e in &mut out.episodes {
        e.share = rules.calibration.share(&e.scenario, e.score);
    }
    out
}
