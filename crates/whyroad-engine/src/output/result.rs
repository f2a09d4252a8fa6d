//! `mining_result` (DATA_FORMAT.md 5.2): results of one question, the best first, with figures over all matches. Only
//! the score, id and line in `episodes.jsonl` of each match are kept; the rest is read from there when the result is
//! written.

use super::coverage::ClassGaps;
use serde::ser::{Error as _, SerializeSeq, Serializer};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use whyroad_lake::mined::LineSpan;
use whyroad_model::ScenarioId;
use whyroad_model::messages::{
    DriveGap, EpisodeRecord, MinedClip, MinedKeyframe, MiningStatistics, NotObservable,
};

/// A question: a `mining_result` is written for each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {
    /// Repeated in the result.
    pub query_id: String,
    /// Requested class.
    pub scenario: ScenarioId,
    /// Maximum number of clips.
    pub limit: Option<u32>,
}

/// When a keyframe is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct KeyframeSeconds {
    /// Seconds from the start of the drive to it.
    pub keyframe_s: f64,
    /// Seconds from the start of the clip to it, as `explain` counts.
    pub clip_s: f64,
}

/// One of the best results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BestMatch {
    /// As in the result.
    #[serde(flatten)]
    pub clip: MinedClip,
    /// Its keyframe in seconds.
    #[serde(flatten)]
    pub at: KeyframeSeconds,
}

struct Match {
    score: f64,
    margin_score: f64,
    calibrated: bool,
    episode_id: String,
    span: LineSpan,
    at: KeyframeSeconds,
}

/// Results of one question so far.
pub struct Answer {
    question: Question,
    matches: Vec<Match>,
    total: u64,
}

impl Answer {
    /// Empty results.
    pub fn new(question: Question) -> Self {
        Self { question, matches: Vec::new(), total: 0 }
    }

    /// The question.
    pub fn question(&self) -> &Question {
        &self.question
    }

    /// Adds an episode of the requested class or below it; others are skipped. `at` is only needed for
    /// [`Answer::best`].
    pub fn add(&mut self, record: &EpisodeRecord, span: LineSpan, at: Option<KeyframeSeconds>) {
        if !record.scenario_id.is_within(&self.question.scenario) {
            return;
        }
        self.total += 1;
        self.matches.push(Match {
            score: record.score,
            margin_score: record.margin_score.unwrap_or(record.score),
            calibrated: record.calibrated.unwrap_or(false),
            episode_id: record.episode_id.clone(),
            span,
            at: at.unwrap_or_default(),
        });
        // With a limit, at most twice that number is held.
        if let Some(limit) = self.limit()
            && self.matches.len() > 2 * limit + 1000
        {
            self.sort();
            self.matches.truncate(limit);
        }
    }

    fn limit(&self) -> Option<usize> {
        self.question.limit.map(|l| usize::try_from(l).unwrap_or(usize::MAX / 4))
    }

    /// The best first; equal scores by margin score, then by id.
    fn sort(&mut self) {
        self.matches.sort_by(|a, b| {
            let by_score = b.score.total_cmp(&a.score).then(b.margin_score.total_cmp(&a.margin_score));
            by_score.then_with(|| a.episode_id.cmp(&b.episode_id))
        });
    }

    /// Closes the results: the best first, up to the limit.
    pub fn close(&mut self) {
        self.sort();
        if let Some(limit) = self.limit() {
            self.matches.truncate(limit);
        }
    }

    /// The best `n` of closed results, read from the episodes' file.
    pub fn best(&self, n: usize, episodes: &mut File) -> std::io::Result<Vec<BestMatch>> {
        let one = |m: &Match| {
            let clip = read(m.span, &self.question.scenario, episodes)?;
            Ok(BestMatch { clip, at: m.at })
        };
        self.matches.iter().take(n).map(one).collect()
    }

    /// The clips that are returned, by score (DATA_FORMAT.md 5.2: the counts add up to `returned`).
    fn distribution(&self) -> BTreeMap<String, u64> {
        let mut counts = BTreeMap::new();
        for m in &self.matches {
            *counts.entry(tenth(m.score)).or_default() += 1;
        }
        counts
    }

    fn statistics(&self) -> MiningStatistics {
        let uncalibrated = self.matches.iter().filter(|m| !m.calibrated).count() as u64;
        MiningStatistics { score_distribution: self.distribution(), uncalibrated }
    }

    /// All matches, regardless of the limit.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The message of closed results, to be written: its clips are read from the episodes' file one by one.
    pub fn message<'a>(&'a self, gaps: &ClassGaps, episodes: &'a RefCell<File>) -> impl Serialize + 'a {
        self.message_with(not_observable(gaps, &self.question.scenario), episodes)
    }

    /// The same where it is known already which drives could not be decided.
    pub(super) fn message_with<'a>(
        &'a self,
        not_observable: Vec<NotObservable>,
        episodes: &'a RefCell<File>,
    ) -> impl Serialize + 'a {
        Message {
            mining_result: Body {
                query_id: &self.question.query_id,
                scenario_id: &self.question.scenario,
                total_matched: self.total,
                returned: self.matches.len() as u64,
                clips: Clips { answer: self, episodes },
                statistics: self.statistics(),
                not_observable,
            },
        }
    }
}

/// The same fields in the same order as [`whyroad_model::messages::MiningResultMessage`], which reads it.
#[derive(Serialize)]
struct Message<'a> {
    mining_result: Body<'a>,
}

#[derive(Serialize)]
struct Body<'a> {
    query_id: &'a str,
    scenario_id: &'a ScenarioId,
    total_matched: u64,
    returned: u64,
    clips: Clips<'a>,
    statistics: MiningStatistics,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    not_observable: Vec<NotObservable>,
}

struct Clips<'a> {
    answer: &'a Answer,
    episodes: &'a RefCell<File>,
}

impl Serialize for Clips<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.answer.matches.len()))?;
        for m in &self.answer.matches {
            let clip = read(m.span, &self.answer.question.scenario, &mut self.episodes.borrow_mut());
            list.serialize_element(&clip.map_err(S::Error::custom)?)?;
        }
        list.end()
    }
}

fn read(span: LineSpan, asked: &ScenarioId, episodes: &mut File) -> std::io::Result<MinedClip> {
    let mut line = vec![0; span.len];
    episodes.seek(SeekFrom::Start(span.start))?;
    episodes.read_exact(&mut line)?;
    let r: EpisodeRecord = serde_json::from_slice(&line)?;
    Ok(MinedClip {
        clip_id: r.clip_id.to_string(),
        match_score: r.score,
        keyframe_suggestion: MinedKeyframe {
            timestamp: r.keyframe.timestamp,
            frame_idx: r.keyframe.frame_idx,
        },
        conditions_matched: r.conditions_matched,
        scenario_id: (r.scenario_id != *asked).then_some(r.scenario_id),
        episode_id: Some(r.episode_id),
        target_id: r.target_id.map(|id| id.to_string()),
        ego_response: r.ego_response,
        calibrated: r.calibrated,
    })
}

/// `0.8-0.9` holds scores from 0.8 up to but not 0.9; the last tenth holds 1 as well.
fn tenth(score: f64) -> String {
    let lower = ((score * 10.0).floor() as i64).clamp(0, 9);
    format!("{:.1}-{:.1}", lower as f64 / 10.0, (lower + 1) as f64 / 10.0)
}

fn not_observable(gaps: &ClassGaps, scenario: &ScenarioId) -> Vec<NotObservable> {
    // In the order of the classes.
    gaps.iter().filter(|(id, _)| id.is_within(scenario)).flat_map(|(id, gaps)| by_signals(id, gaps)).collect()
}

/// One row for the drives that lack the same signals.
pub(super) fn by_signals(scenario_id: &ScenarioId, gaps: &[DriveGap]) -> impl Iterator<Item = NotObservable> {
    gaps.iter().map(|gap| NotObservable {
        scenario_id: scenario_id.clone(),
        drives: gap.drives.clone(),
        missing_signals: gap.missing_signals.clone(),
    })
}
