//! Removing drives from a mined folder: the folder is written again without them and replaces the old one atomically.
//! Remaining lines are copied unchanged; results are filled up with matches beyond their limit. For a folder that asked
//! all rules, the bytes are those of mining a lake that never had the drives.
//!
//! Counts in `coverage.json` of classes that were not requested still include episodes of the removed drives, which the
//! folder does not list.

use super::result::{Answer, Question, by_signals};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use whyroad_lake::MinedFolder;
use whyroad_lake::mined::{
    Existing, MinedFile, MinedFolderWriter, MinedWriteError, Publication, PublishError,
};
use whyroad_model::messages::{
    ClipMetadataMessage, Coverage, CoverageState, DriveGap, EpisodeRecord, KeyframeSuggestionMessage,
    LeafCoverage, MiningResultMessage, NotObservable, ScenarioPreLabelMessage,
};
use whyroad_model::{DriveId, ScenarioId};

/// A folder could not be written again.
#[derive(Debug, thiserror::Error)]
pub enum RemovalError {
    /// A file of it cannot be read.
    #[error("{}: {reason}", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// It states no question: an earlier version wrote it.
    #[error("{} does not record its question; mine it again", .0.display())]
    NoQuestion(PathBuf),
    /// The file system refused.
    #[error(transparent)]
    Write(#[from] MinedWriteError),
    /// The folder cannot be replaced.
    #[error(transparent)]
    Publish(#[from] PublishError),
}

fn unreadable(path: &Path, reason: impl ToString) -> RemovalError {
    RemovalError::Unreadable { path: path.to_owned(), reason: reason.to_string() }
}

/// Contents of a folder from some drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HeldDrives {
    /// Drives.
    pub drives: usize,
    /// Their episodes.
    pub episodes: usize,
}

/// Contents of the folder from these drives.
pub fn held(folder: &MinedFolder, drives: &BTreeSet<DriveId>) -> Result<HeldDrives, RemovalError> {
    let mut found: BTreeSet<DriveId> =
        named(coverage(folder)?).into_iter().filter(|d| drives.contains(d)).collect();
    let mut episodes = 0;
    let path = folder.path(MinedFile::Episodes);
    for record in folder.episodes().map_err(|e| unreadable(&path, e))? {
        let record = record.map_err(|d| unreadable(&path, &d.message.en))?;
        if drives.contains(&record.drive_id) {
            episodes += 1;
            found.insert(record.drive_id);
        }
    }
    Ok(HeldDrives { drives: found.len(), episodes })
}

/// Removes the drives from the folder. Nothing changes where it cannot be read completely.
pub fn remove(folder: &MinedFolder, drives: &BTreeSet<DriveId>) -> Result<HeldDrives, RemovalError> {
    let removed = held(folder, drives)?;
    if removed.drives == 0 {
        return Ok(removed);
    }
    let question = folder.question().ok_or_else(|| RemovalError::NoQuestion(folder.dir().to_owned()))?;
    let place = Publication::begin(folder.dir(), &question, false)?;
    let mut writer = MinedFolderWriter::create(place.folder(), question, Existing::Replace)?;
    let results = results(folder)?;
    let mut answers: Vec<Answer> = results.iter().map(|(_, r)| Answer::new(question_of(r))).collect();

    let (mut gone, mut counts) = (BTreeSet::new(), BTreeMap::<ScenarioId, (u64, u64)>::new());
    each::<EpisodeRecord>(folder, MinedFile::Episodes, |record, line| {
        if drives.contains(&record.drive_id) {
            let count = counts.entry(record.scenario_id).or_default();
            *count = (count.0 + 1, count.1 + u64::from(record.is_primary));
            gone.insert(record.episode_id);
            return Ok(());
        }
        let span = writer.episode_line(&record, line)?;
        answers.iter_mut().for_each(|a| a.add(&record, span, None));
        Ok(())
    })?;
    let goes = |id: &Option<String>| id.as_ref().is_some_and(|id| gone.contains(id));
    each::<ScenarioPreLabelMessage>(folder, MinedFile::PreLabels, |m, line| {
        if goes(&m.episode_id) { Ok(()) } else { Ok(writer.line(MinedFile::PreLabels, line)?) }
    })?;
    each::<KeyframeSuggestionMessage>(folder, MinedFile::KeyframeSuggestions, |m, line| {
        if goes(&m.episode_id) { Ok(()) } else { Ok(writer.line(MinedFile::KeyframeSuggestions, line)?) }
    })?;
    each::<ClipMetadataMessage>(folder, MinedFile::Clips, |m, line| {
        let clip = m.clip_metadata;
        let named = clip.clip_id.rsplit_once('_').map(|(drive, _)| drive.to_owned());
        let drive = clip.drive_id.or(named).map(DriveId);
        if drive.is_some_and(|d| drives.contains(&d)) {
            return Ok(());
        }
        Ok(writer.line(MinedFile::Clips, line)?)
    })?;

    let files = writer.finish()?;
    let episodes = RefCell::new(files.open_episodes()?);
    let coverage = without(coverage(folder)?, drives, &counts);
    let alone = results.len() == 1;
    for (answer, (class, result)) in answers.iter_mut().zip(&results) {
        answer.close();
        let blind = blind(&result.mining_result.not_observable, &coverage);
        files.result(class, &answer.message_with(blind, &episodes), alone)?;
    }
    files.coverage(&coverage)?;
    place.publish()?;
    Ok(removed)
}

/// All drives of a run, searched or not.
fn named(coverage: Coverage) -> Vec<DriveId> {
    let left_out = coverage.left_out.into_iter().map(|d| d.drive_id);
    coverage.drives.into_iter().chain(left_out).collect()
}

fn coverage(folder: &MinedFolder) -> Result<Coverage, RemovalError> {
    folder.coverage().map_err(|d| unreadable(&folder.path(MinedFile::Coverage), &d.message.en))
}

/// Calls `each` for every line of a file, with the unchanged line.
fn each<T: serde::de::DeserializeOwned>(
    folder: &MinedFolder,
    file: MinedFile,
    mut each: impl FnMut(T, Vec<u8>) -> Result<(), RemovalError>,
) -> Result<(), RemovalError> {
    let path = folder.path(file);
    let lines = BufReader::new(File::open(&path).map_err(|e| unreadable(&path, e))?);
    for line in lines.split(b'\n') {
        let line = line.map_err(|e| unreadable(&path, e))?;
        if !line.trim_ascii().is_empty() {
            each(serde_json::from_slice(&line).map_err(|e| unreadable(&path, e))?, line)?;
        }
    }
    Ok(())
}

/// The results of the folder, by class.
fn results(folder: &MinedFolder) -> Result<Vec<(ScenarioId, MiningResultMessage)>, RemovalError> {
    let dir = folder.path(MinedFile::Results);
    let mut out = Vec::new();
    for entry in std::fs::read_dir(&dir).map_err(|e| unreadable(&dir, e))?.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "json") {
            let text = std::fs::read(&path).map_err(|e| unreadable(&path, e))?;
            let message: MiningResultMessage =
                serde_json::from_slice(&text).map_err(|e| unreadable(&path, e))?;
            out.push((message.mining_result.scenario_id.clone(), message));
        }
    }
    out.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(out)
}

/// The question of a result. Its limit is known where it omitted matches.
fn question_of(message: &MiningResultMessage) -> Question {
    let r = &message.mining_result;
    let limit = (r.returned < r.total_matched).then(|| u32::try_from(r.returned).unwrap_or(u32::MAX));
    Question { query_id: r.query_id.clone(), scenario: r.scenario_id.clone(), limit }
}

/// The rows of a result, from the coverage without the drives.
fn blind(rows: &[NotObservable], coverage: &Coverage) -> Vec<NotObservable> {
    let classes: BTreeSet<&ScenarioId> = rows.iter().map(|row| &row.scenario_id).collect();
    let left =
        coverage.leaves.iter().chain(&coverage.unresolved).filter(|l| classes.contains(&l.scenario_id));
    let mut left: Vec<&LeafCoverage> = left.collect();
    left.sort_by(|a, b| a.scenario_id.cmp(&b.scenario_id));
    left.into_iter().flat_map(|l| by_signals(&l.scenario_id, &l.gaps)).collect()
}

/// Coverage without the drives; `removed` counts their episodes and the primary ones among them.
fn without(
    mut coverage: Coverage,
    drives: &BTreeSet<DriveId>,
    removed: &BTreeMap<ScenarioId, (u64, u64)>,
) -> Coverage {
    coverage.drives.retain(|d| !drives.contains(d));
    coverage.left_out.retain(|d| !drives.contains(&d.drive_id));
    let all = coverage.drives.len() as u64;
    let leaf = |l: &mut LeafCoverage| {
        if l.state == CoverageState::NoRule {
            return;
        }
        for gap in &mut l.gaps {
            let left = gap.drives.iter().filter(|d| !drives.contains(*d)).cloned();
            gap.drives = left.collect::<Vec<_>>().into();
        }
        l.gaps.retain(|g: &DriveGap| !g.drives.is_empty());
        let (episodes, primary) = removed.get(&l.scenario_id).copied().unwrap_or_default();
        l.episodes = l.episodes.saturating_sub(episodes);
        l.primary_episodes = l.primary_episodes.saturating_sub(primary);
        let blind: usize = l.gaps.iter().map(|g| g.drives.len()).sum();
        l.drives_searched = all.saturating_sub(blind as u64);
        l.state = match (l.episodes, l.drives_searched) {
            (1.., _) => CoverageState::Found,
            (0, 1..) => CoverageState::NotFound,
            (0, 0) if all == 0 => CoverageState::NotFound,
            (0, 0) => CoverageState::NotObservable,
        };
    };
    coverage.leaves.iter_mut().chain(&mut coverage.unresolved).for_each(leaf);
    coverage
}
