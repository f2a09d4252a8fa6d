//! A lake: each drive read, its signals derived, its episodes found, on all cores. The only module that does
//! I/O besides [`crate::output`]. The result does not depend on the number of threads.

use crate::drive::mine_drive;
use crate::output::record::{MinedEpisode, write_down};
use crate::rule::RuleSet;
use rayon::prelude::*;
use std::collections::BTreeMap;
use whyroad_lake::Lake;
use whyroad_model::messages::ClipMetadata;
use whyroad_model::{Bilingual, Diagnostic, DriveId, Lang, ScenarioId, SignalTable};

/// One drive's contribution.
#[derive(Clone, Debug)]
pub struct MinedDrive {
    /// The drive.
    pub drive_id: DriveId,
    /// Its clips, without pre-labels.
    pub clips: Vec<ClipMetadata>,
    /// What was found, in order of keyframe, class, target.
    pub episodes: Vec<MinedEpisode>,
    /// For each rule, by its class: the signals for lack of which it could not be decided (none: it could).
    pub missing: BTreeMap<ScenarioId, Vec<String>>,
}

/// What a run over a lake gave.
#[derive(Clone, Debug, Default)]
pub struct MinedLake {
    /// Drives that could be read, by id.
    pub drives: Vec<MinedDrive>,
    /// One error a drive that could not.
    pub diagnostics: Vec<Diagnostic>,
}

/// Mines every drive of the lake. `done` is called after each drive, from any thread; texts in messages are in
/// `lang`.
pub fn mine_lake(lake: &Lake, rules: &RuleSet, lang: Lang, done: impl Fn(&DriveId) + Sync) -> MinedLake {
    let ids = lake.drive_ids();
    let each: Vec<Result<MinedDrive, Box<Diagnostic>>> = ids
        .par_iter()
        .map(|id| {
            let mined = mine_one(lake, id, rules, lang);
            done(id);
            mined
        })
        .collect();
    let mut out = MinedLake::default();
    for result in each {
        match result {
            Ok(drive) => out.drives.push(drive),
            Err(d) => out.diagnostics.push(*d),
        }
    }
    out
}

fn mine_one(lake: &Lake, id: &DriveId, rules: &RuleSet, lang: Lang) -> Result<MinedDrive, Box<Diagnostic>> {
    let drive = lake.read_drive(id).map_err(|e| {
        let cause = e.diagnostic();
        let message = Bilingual::new(
            format!("行程 {id} 无法读取，已跳过：{}", cause.message.zh),
            format!("drive {id} cannot be read and is left out: {}", cause.message.en),
        );
        let d = Diagnostic::error("mine.drive.unreadable", message).at(cause.place);
        Box::new(match cause.hint {
            Some(hint) => d.with_hint(hint),
            None => d,
        })
    })?;
    let table = whyroad_signals::derive(&drive);
    let found = mine_drive(rules, &table);
    let clips = lake.clips(&drive);
    let episodes = write_down(&found.episodes, id, &drive.times, &drive.clips(), lang);
    Ok(MinedDrive { drive_id: id.clone(), clips, episodes, missing: found.missing })
}

/// Signals of one drive: what a report plots beside an episode.
pub fn signals_of(lake: &Lake, id: &DriveId) -> Result<SignalTable, whyroad_lake::LakeError> {
    Ok(whyroad_signals::derive(&lake.read_drive(id)?))
}
