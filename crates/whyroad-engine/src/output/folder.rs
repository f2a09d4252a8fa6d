//! The folder that `whyroad mine --out` writes: from drives to the messages of the folder, its results and its
//! coverage. The files themselves are `whyroad_lake::mined`.

use super::coverage::{Counts, Searched};
use super::record::MinedEpisode;
use super::result::{Answer, BestMatch, KeyframeSeconds, Question};
use crate::mine::{MinedDrive, MinedLake};
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use whyroad_framework::Taxonomy;
use whyroad_lake::Fingerprint;
use whyroad_lake::mined::{
    DriveLines, Existing, Ledger, MinedFile, MinedFolderWriter, MinedWriteError, MiningQuestion, WrittenDrive,
};
use whyroad_mining::rule::{OTHER, Precedence};
use whyroad_model::messages::{
    ClipMetadata, ClipMetadataMessage, Coverage, EpisodeRecord, KeyframeSuggestionMessage, LeftOutDrive,
    PreLabelScenario, PreLabels, ScenarioPreLabelMessage,
};
use whyroad_model::{ClipId, DriveId, Nanos, ScenarioId};

/// Summary of the written folder.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Drives that were searched.
    pub drives: usize,
    /// Episodes of the requested classes.
    pub episodes: usize,
    /// Of these, the primary ones.
    pub primary_episodes: usize,
    /// All leaves.
    pub coverage: Coverage,
    /// For a single question: the best results.
    pub best: Vec<BestMatch>,
    /// For a single question: the number of matches.
    pub matched: u64,
    /// For each class that was found, the episode to look at first: a primary one if possible, then the highest score.
    pub examples: BTreeMap<ScenarioId, EpisodeExample>,
}

/// The episode to look at first.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeExample {
    /// Clip that the keyframe is in.
    pub clip_id: ClipId,
    /// Its keyframe in seconds.
    pub at: KeyframeSeconds,
    /// Whether it is primary.
    pub is_primary: bool,
    /// Its score, 0 to 1.
    pub score: f64,
}

/// Maximum number of best results in a [`Summary`].
const BEST: usize = 10;

/// Writes everything that is in memory. A single question's result is also `mining_result.json`.
pub fn write_folder(
    out: &Path,
    mined: &MinedLake,
    questions: &[Question],
    taxonomy: &Taxonomy,
    rules: &[ScenarioId],
    precedence: &Precedence,
) -> Result<Summary, MinedWriteError> {
    let asked = MiningQuestion::Framework { scenarios: vec![] };
    let mut folder = FolderWriter::create(out, asked, Existing::default(), questions, rules, precedence)?;
    for drive in &mined.drives {
        folder.add(drive)?;
    }
    folder.finish(taxonomy, Searched::Framework)
}

/// Writes the folder drive by drive; memory does not grow with the results, except for about a hundred bytes per
/// episode that a result without a limit has to sort.
pub struct FolderWriter {
    files: MinedFolderWriter,
    answers: Vec<Answer>,
    counts: Counts,
    precedence: Precedence,
    primary: usize,
    examples: BTreeMap<ScenarioId, EpisodeExample>,
    left_out: Vec<LeftOutDrive>,
    /// Numbers of the gaps of an earlier ledger among the counts.
    numbers: Vec<Option<usize>>,
}

/// State of a drive before it was mined.
#[derive(Clone, Debug)]
pub struct KnownDrive {
    /// Its location and state.
    pub fingerprint: Fingerprint,
    /// Hash of what it stated about itself.
    pub stated: Option<String>,
}

/// A drive that has not changed, with its lines from the earlier run.
pub struct SameDrive {
    at: usize,
    lines: DriveLines,
    records: Vec<EpisodeRecord>,
    known: KnownDrive,
}

impl SameDrive {
    /// Reads the drive at a position of the ledger; `None` where its lines cannot be read. May be called from several
    /// threads.
    pub fn read(ledger: &Ledger, at: usize, known: KnownDrive) -> Option<Self> {
        let lines = ledger.lines(at).ok()?;
        let records = lines.of(MinedFile::Episodes).map(serde_json::from_slice);
        let records = records.collect::<Result<Vec<EpisodeRecord>, _>>().ok()?;
        let own = records.iter().all(|r| r.drive_id == ledger.entries[at].drive_id);
        own.then_some(Self { at, lines, records, known })
    }
}

/// When a drive's clips begin.
struct ClipStarts(Vec<(String, Nanos)>);

impl ClipStarts {
    fn of<'a>(clips: impl IntoIterator<Item = &'a ClipMetadata>) -> Self {
        Self(clips.into_iter().map(|c| (c.clip_id.clone(), c.capture_time)).collect())
    }

    fn of_lines(lines: &DriveLines) -> Self {
        let clips = lines.of(MinedFile::Clips).filter_map(|l| serde_json::from_slice(l).ok());
        let clips: Vec<ClipMetadata> = clips.map(|m: ClipMetadataMessage| m.clip_metadata).collect();
        Self::of(&clips)
    }

    /// The times in between are measured, not counted in frames: a log can have gaps.
    fn keyframe(&self, record: &EpisodeRecord) -> KeyframeSeconds {
        let at = record.keyframe.timestamp;
        let drive = self.0.iter().map(|(_, start)| *start).min();
        let clip = self.0.iter().find(|(id, _)| id == record.clip_id.as_str()).map(|(_, start)| *start);
        let since = |start: Option<Nanos>| at.seconds_since(start.unwrap_or(at));
        KeyframeSeconds { keyframe_s: since(drive), clip_s: since(clip) }
    }
}

impl FolderWriter {
    /// A new folder. `asked` is recorded in it; `questions` each get a `mining_result`; `rules` are the classes for
    /// which a rule is run.
    pub fn create(
        out: &Path,
        asked: MiningQuestion,
        existing: Existing,
        questions: &[Question],
        rules: &[ScenarioId],
        precedence: &Precedence,
    ) -> Result<Self, MinedWriteError> {
        Ok(Self {
            files: MinedFolderWriter::create(out, asked, existing)?,
            answers: questions.iter().cloned().map(Answer::new).collect(),
            counts: Counts::new(rules),
            precedence: precedence.clone(),
            primary: 0,
            examples: BTreeMap::new(),
            left_out: Vec::new(),
            numbers: Vec::new(),
        })
    }

    /// Adds the results of a drive; drives come in the order of their ids. Episodes that were not requested are
    /// counted, but not written.
    pub fn add(&mut self, drive: &MinedDrive) -> Result<(), MinedWriteError> {
        self.counts.add(drive);
        self.write(drive)
    }

    /// Records a drive that could not be searched, in the order of the ids.
    pub fn leave_out(&mut self, drive_id: &DriveId, code: &str) {
        self.left_out.push(LeftOutDrive { drive_id: drive_id.clone(), code: code.to_owned() });
    }

    /// Also writes a ledger of the drives, by which the next run into the folder knows which of them have changed.
    /// `of` is all that the results depend on besides the drives. Every drive is then added by
    /// [`FolderWriter::add_known`] or [`FolderWriter::add_same`].
    pub fn keep_ledger(&mut self, of: &str) -> Result<(), MinedWriteError> {
        self.files.keep_ledger(of)
    }

    /// [`FolderWriter::add`], and records in the ledger the state of the drive before it was mined.
    pub fn add_known(&mut self, drive: &MinedDrive, known: KnownDrive) -> Result<(), MinedWriteError> {
        let (number, counts) = self.counts.add(drive);
        self.write(drive)?;
        self.files.account(WrittenDrive {
            drive_id: &drive.drive_id,
            fingerprint: known.fingerprint,
            stated: known.stated,
            gaps: (number, &drive.missing),
            counts,
        })
    }

    /// Adds a drive that has not changed since `ledger` was written, in the same order as the others.
    pub fn add_same(&mut self, ledger: &Ledger, same: SameDrive) -> Result<(), MinedWriteError> {
        let (entry, SameDrive { lines, records, known, .. }) = (&ledger.entries[same.at], same);
        let gaps = &ledger.gaps[entry.gaps];
        if self.numbers.len() < ledger.gaps.len() {
            self.numbers.resize(ledger.gaps.len(), None);
        }
        let number = *self.numbers[entry.gaps].get_or_insert_with(|| self.counts.number(gaps));
        self.counts.add_counted(&entry.drive_id, number, &entry.counts);
        let (mut starts, is_single) = (None, self.answers.len() == 1);
        for (record, line) in records.into_iter().zip(lines.of(MinedFile::Episodes)) {
            self.primary += usize::from(record.is_primary);
            let mut at = || starts.get_or_insert_with(|| ClipStarts::of_lines(&lines)).keyframe(&record);
            self.example(&record, &mut at);
            let placed = self.files.same_episode(&record, line)?;
            let at = is_single.then(&mut at);
            self.answers.iter_mut().for_each(|answer| answer.add(&record, placed, at));
        }
        self.files.same_lines(&lines)?;
        self.files.account(WrittenDrive {
            drive_id: &entry.drive_id,
            fingerprint: known.fingerprint,
            stated: known.stated,
            gaps: (number, gaps),
            counts: entry.counts.clone(),
        })
    }

    fn write(&mut self, drive: &MinedDrive) -> Result<(), MinedWriteError> {
        let asked = |e: &&MinedEpisode| {
            let class = &e.record.scenario_id;
            self.answers.iter().any(|a| class.is_within(&a.question().scenario))
        };
        let episodes: Vec<MinedEpisode> = drive.episodes.iter().filter(asked).cloned().collect();
        let starts = ClipStarts::of(&drive.clips);
        for e in &episodes {
            let span = self.files.episode(&e.record)?;
            let at = starts.keyframe(&e.record);
            self.answers.iter_mut().for_each(|answer| answer.add(&e.record, span, Some(at)));
            self.primary += usize::from(e.record.is_primary);
            self.example(&e.record, &mut || at);
            let (episode_id, clip_id) =
                (Some(e.record.episode_id.clone()), Some(e.record.clip_id.to_string()));
            // Only a class of the taxonomy can be proposed.
            if is_class(&e.record.scenario_id) {
                self.files.pre_label(&ScenarioPreLabelMessage {
                    scenario_pre_label: e.pre_label.clone(),
                    episode_id: episode_id.clone(),
                    clip_id: clip_id.clone(),
                })?;
            }
            self.files.keyframe_suggestion(&KeyframeSuggestionMessage {
                keyframe_suggestion: e.suggestion.clone(),
                episode_id,
                clip_id,
            })?;
        }
        for clip in &drive.clips {
            self.files.clip(&ClipMetadataMessage { clip_metadata: self.with_pre_labels(clip, &episodes) })?;
        }
        Ok(())
    }

    /// A clip's pre-label is its primary episode whose class is first in the order of precedence, then the one with the
    /// higher score, then the earlier.
    fn with_pre_labels(&self, clip: &ClipMetadata, episodes: &[MinedEpisode]) -> ClipMetadata {
        let of_clip = episodes
            .iter()
            .map(|e| &e.record)
            .filter(|r| r.clip_id.as_str() == clip.clip_id && r.is_primary && is_class(&r.scenario_id));
        let first = of_clip.reduce(|a, b| {
            let (ra, rb) = (self.precedence.rank(&a.scenario_id), self.precedence.rank(&b.scenario_id));
            let better =
                |a: &EpisodeRecord, b: &EpisodeRecord| (b.score, b.margin_score) > (a.score, a.margin_score);
            if rb < ra || (rb == ra && better(a, b)) { b } else { a }
        });
        let pre_labels = first.map(|r| PreLabels {
            scenario: PreLabelScenario {
                l1: r.scenario_id.l1.clone(),
                l2: r.scenario_id.l2.clone().unwrap_or_default(),
                l3: r.scenario_id.l3.clone(),
            },
            mining_score: r.score,
            mining_method: "rule_based".to_owned(),
        });
        ClipMetadata { pre_labels, ..clip.clone() }
    }

    fn example(&mut self, record: &EpisodeRecord, at: &mut dyn FnMut() -> KeyframeSeconds) {
        let known = self.examples.get(&record.scenario_id);
        if known.is_some_and(|e| (record.is_primary, record.score) <= (e.is_primary, e.score)) {
            return;
        }
        let example = EpisodeExample {
            clip_id: record.clip_id.clone(),
            at: at(),
            is_primary: record.is_primary,
            score: record.score,
        };
        self.examples.insert(record.scenario_id.clone(), example);
    }

    /// Writes the results and the coverage, and moves everything into place over an earlier run's results.
    pub fn finish(mut self, taxonomy: &Taxonomy, searched: Searched) -> Result<Summary, MinedWriteError> {
        let written = self.files.episodes();
        let files = self.files.finish()?;
        let alone = self.answers.len() == 1;
        let gaps = self.counts.gaps();
        let left_out = std::mem::take(&mut self.left_out);
        let coverage = Coverage { left_out, ..self.counts.coverage(taxonomy, searched, &gaps) };
        let result = |answer: &mut Answer| -> Result<(), MinedWriteError> {
            answer.close();
            let episodes = RefCell::new(files.open_episodes()?);
            files.result(&answer.question().scenario, &answer.message(&gaps, &episodes), alone)
        };
        // Results repeat the lines of episodes and name drives: for a large lake they are the largest files.
        let answers = &mut self.answers;
        let results = || answers.par_iter_mut().with_max_len(1).try_for_each(result);
        let (written_coverage, results) = rayon::join(|| files.coverage(&coverage), results);
        written_coverage.and(results)?;
        let of_one = self.answers.first().filter(|_| alone);
        let best = match of_one {
            Some(answer) => {
                answer.best(BEST, &mut files.open_episodes()?).map_err(|e| files.unreadable(e))?
            }
            None => vec![],
        };
        files.seal()?;
        Ok(Summary {
            drives: self.counts.drives(),
            episodes: written,
            primary_episodes: self.primary,
            coverage,
            best,
            matched: of_one.map_or(0, Answer::total),
            examples: self.examples,
        })
    }
}

/// True for a class of the taxonomy, as opposed to moments that no class explains and matches of a custom rule.
fn is_class(id: &ScenarioId) -> bool {
    id.l1 != OTHER && id.custom_name().is_none()
}
