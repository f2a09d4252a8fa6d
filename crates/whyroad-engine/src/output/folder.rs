//! The folder that `whyroad mine --out` writes: from drives to the messages of the folder, its results and its
//! coverage. The files themselves are `whyroad_lake::mined`.

use super::coverage::{Counts, Searched};
use super::record::MinedEpisode;
use super::result::{Answer, Question};
use crate::mine::{MinedDrive, MinedLake};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use whyroad_framework::Taxonomy;
use whyroad_lake::mined::{Existing, MinedFolderWriter, MinedWriteError, MiningQuestion};
use whyroad_mining::rule::{OTHER, Precedence};
use whyroad_model::messages::{
    ClipMetadata, ClipMetadataMessage, Coverage, EpisodeRecord, KeyframeSuggestionMessage, MinedClip,
    PreLabelScenario, PreLabels, ScenarioPreLabelMessage,
};
use whyroad_model::{ClipId, Nanos, ScenarioId};

/// What was written.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Drives that were searched.
    pub drives: usize,
    /// Episodes of the classes asked for.
    pub episodes: usize,
    /// Of these, the primary ones.
    pub primary_episodes: usize,
    /// All leaves.
    pub coverage: Coverage,
    /// Where one question was asked: the best of what was found for it.
    pub best: Vec<MinedClip>,
    /// Where one question was asked: how many matched.
    pub matched: u64,
    /// For each class that was found, the episode to look at first: a primary one if possible, then the highest score.
    pub examples: BTreeMap<ScenarioId, EpisodeExample>,
}

/// The episode to look at first.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeExample {
    /// Clip that the keyframe is in.
    pub clip_id: ClipId,
    /// Seconds from the start of the drive to the keyframe.
    pub keyframe_s: f64,
    /// Whether it is primary.
    pub is_primary: bool,
    /// Its score, 0 to 1.
    pub score: f64,
}

/// How many of the best a [`Summary`] names.
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

/// Writes the folder drive by drive; what it holds in memory does not grow with what was found, except for about a
/// hundred bytes per episode that a result without a limit has to put in order.
pub struct FolderWriter {
    files: MinedFolderWriter,
    answers: Vec<Answer>,
    counts: Counts,
    precedence: Precedence,
    primary: usize,
    examples: BTreeMap<ScenarioId, EpisodeExample>,
}

impl FolderWriter {
    /// A folder that is begun. `asked` is recorded in it; `questions` each get a `mining_result`; `rules` are the
    /// classes for which a rule is run.
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
        })
    }

    /// Adds the results of a drive; drives come in the order of their ids. Episodes that were not asked for are
    /// counted, and not written.
    pub fn add(&mut self, drive: &MinedDrive) -> Result<(), MinedWriteError> {
        self.counts.add(drive);
        let asked = |e: &&MinedEpisode| {
            let class = &e.record.scenario_id;
            self.answers.iter().any(|a| class.is_within(&a.question().scenario))
        };
        let episodes: Vec<MinedEpisode> = drive.episodes.iter().filter(asked).cloned().collect();
        let start = drive.clips.iter().map(|c| c.capture_time).min();
        for e in &episodes {
            let span = self.files.episode(&e.record)?;
            self.answers.iter_mut().for_each(|answer| answer.add(&e.record, span));
            self.primary += usize::from(e.record.is_primary);
            self.example(&e.record, start);
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

    /// A clip's pre-label is its primary episode whose class comes first in the order of precedence, then the one with
    /// the higher score, then the earlier.
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

    fn example(&mut self, record: &EpisodeRecord, start: Option<Nanos>) {
        let at = record.keyframe.timestamp;
        let example = EpisodeExample {
            clip_id: record.clip_id.clone(),
            keyframe_s: at.seconds_since(start.unwrap_or(at)),
            is_primary: record.is_primary,
            score: record.score,
        };
        let rank = |e: &EpisodeExample| (e.is_primary, e.score);
        match self.examples.get_mut(&record.scenario_id) {
            Some(known) if rank(&example) > rank(known) => *known = example,
            Some(_) => {}
            None => {
                self.examples.insert(record.scenario_id.clone(), example);
            }
        }
    }

    /// Writes the results and the coverage, and puts everything in place of what an earlier run left.
    pub fn finish(mut self, taxonomy: &Taxonomy, searched: Searched) -> Result<Summary, MinedWriteError> {
        let written = self.files.episodes();
        let files = self.files.finish()?;
        let episodes = RefCell::new(files.open_episodes()?);
        let alone = self.answers.len() == 1;
        for answer in &mut self.answers {
            answer.close();
            let message = answer.message(&self.counts, &episodes);
            files.result(&answer.question().scenario, &message, alone)?;
        }
        let of_one = self.answers.first().filter(|_| alone);
        let best = of_one.map_or(Ok(vec![]), |a| a.best(BEST, &mut episodes.borrow_mut()));
        let coverage = self.counts.coverage(taxonomy, searched);
        files.coverage(&coverage)?;
        Ok(Summary {
            drives: self.counts.drives(),
            episodes: written,
            primary_episodes: self.primary,
            coverage,
            best: best.map_err(|e| files.unreadable(e))?,
            matched: of_one.map_or(0, Answer::total),
            examples: self.examples,
        })
    }
}

/// True for a class of the taxonomy, as opposed to moments that no class explains and matches of a custom rule.
fn is_class(id: &ScenarioId) -> bool {
    id.l1 != OTHER && id.custom_name().is_none()
}
