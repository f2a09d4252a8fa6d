//! The folder that `whyroad mine --out` writes.

use super::coverage::{Counts, Searched};
use super::episode_table::{EPISODES_VERSION, episode_batch};
use super::record::MinedEpisode;
use super::result::{Answer, LinePlace, Question};
use crate::mine::{MinedDrive, MinedLake};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde::Serialize;
use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use whyroad_framework::Taxonomy;
use whyroad_mining::rule::OTHER;
use whyroad_model::ScenarioId;
use whyroad_model::messages::{
    ClipMetadata, ClipMetadataMessage, Coverage, KeyframeSuggestionMessage, MinedClip, PreLabelScenario,
    PreLabels, ScenarioPreLabelMessage,
};

/// The folder could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file system refused.
    #[error("cannot write {}: {source}", .path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// A table or message could not be encoded.
    #[error("cannot write {}: {reason}", .path.display())]
    Encoding {
        /// File.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Drives that were searched.
    pub drives: usize,
    /// Episodes of the classes asked for.
    pub episodes: usize,
    /// All leaves.
    pub coverage: Coverage,
    /// Where one question was asked: the best of what was found for it.
    pub best: Vec<MinedClip>,
    /// Where one question was asked: how many matched.
    pub matched: u64,
}

/// How many of the best a [`Summary`] names.
const BEST: usize = 10;
/// Episodes that are written to the Parquet file at once, and rows of its row groups.
const EPISODES_AT_ONCE: usize = 512;
const ROWS_A_GROUP: usize = 1 << 16;
/// Ending of files that are not finished: what an earlier run left stays until this one is done.
const PART: &str = "part";

/// Writes everything that is in memory. A single question's result is also `mining_result.json`.
pub fn write_folder(
    out: &Path,
    mined: &MinedLake,
    questions: &[Question],
    taxonomy: &Taxonomy,
    rules: &[ScenarioId],
) -> Result<Summary, WriteError> {
    let mut folder = FolderWriter::create(out, questions, rules)?;
    for drive in &mined.drives {
        folder.add(drive)?;
    }
    folder.finish(taxonomy, Searched::Framework)
}

/// Writes the folder drive by drive; what it holds in memory does not grow with what was found, but for some hundred
/// bytes an episode that a result without a limit has to put in order.
pub struct FolderWriter {
    out: PathBuf,
    episodes: Lines,
    pre_labels: Lines,
    suggestions: Lines,
    clips: Lines,
    table: ArrowWriter<File>,
    /// Episodes that are not in the table yet.
    waiting: Vec<MinedEpisode>,
    written: usize,
    answers: Vec<Answer>,
    counts: Counts,
}

impl FolderWriter {
    /// A folder that is begun. `rules` are the classes for which a rule is run.
    pub fn create(out: &Path, questions: &[Question], rules: &[ScenarioId]) -> Result<Self, WriteError> {
        fs::create_dir_all(out).map_err(io(out))?;
        let path = part(out, TABLE);
        Ok(Self {
            episodes: Lines::create(out, EPISODES)?,
            pre_labels: Lines::create(out, PRE_LABELS)?,
            suggestions: Lines::create(out, SUGGESTIONS)?,
            clips: Lines::create(out, CLIPS)?,
            table: table(&path)?,
            out: out.to_owned(),
            waiting: Vec::new(),
            written: 0,
            answers: questions.iter().cloned().map(Answer::new).collect(),
            counts: Counts::new(rules),
        })
    }

    /// Adds what came of a drive; drives come in the order of their ids. Episodes that nobody asked for are counted, and
    /// not written.
    pub fn add(&mut self, drive: &MinedDrive) -> Result<(), WriteError> {
        self.counts.add(drive);
        let asked = |e: &&MinedEpisode| {
            let class = &e.record.scenario_id;
            self.answers.iter().any(|a| class.is_within(&a.question().scenario))
        };
        let episodes: Vec<MinedEpisode> = drive.episodes.iter().filter(asked).cloned().collect();
        for e in &episodes {
            let place = self.episodes.put(&e.record)?;
            self.answers.iter_mut().for_each(|answer| answer.add(&e.record, place));
            let (episode_id, clip_id) =
                (Some(e.record.episode_id.clone()), Some(e.record.clip_id.to_string()));
            // What no class explains has no class to propose.
            if e.record.scenario_id.l1 != OTHER {
                self.pre_labels.put(&ScenarioPreLabelMessage {
                    scenario_pre_label: e.pre_label.clone(),
                    episode_id: episode_id.clone(),
                    clip_id: clip_id.clone(),
                })?;
            }
            self.suggestions.put(&KeyframeSuggestionMessage {
                keyframe_suggestion: e.suggestion.clone(),
                episode_id,
                clip_id,
            })?;
        }
        for clip in &drive.clips {
            self.clips.put(&ClipMetadataMessage { clip_metadata: with_pre_labels(clip, &episodes) })?;
        }
        self.written += episodes.len();
        self.waiting.extend(episodes);
        if self.waiting.len() >= EPISODES_AT_ONCE { self.write_waiting() } else { Ok(()) }
    }

    fn write_waiting(&mut self) -> Result<(), WriteError> {
        let path = part(&self.out, TABLE);
        let waiting: Vec<&MinedEpisode> = self.waiting.iter().collect();
        let batch = episode_batch(&waiting).map_err(encoding(&path))?;
        self.table.write(&batch).map_err(encoding(&path))?;
        self.waiting.clear();
        Ok(())
    }

    /// Writes the results and the coverage, and puts everything in the place of what an earlier run left.
    pub fn finish(mut self, taxonomy: &Taxonomy, searched: Searched) -> Result<Summary, WriteError> {
        self.write_waiting()?;
        let out = self.out;
        self.table.close().map_err(encoding(&part(&out, TABLE)))?;
        for lines in [self.episodes, self.pre_labels, self.suggestions, self.clips] {
            lines.finish()?;
        }
        let results_dir = out.join("mining_results");
        fs::create_dir_all(&results_dir).map_err(io(&results_dir))?;
        clear(&results_dir)?;
        let single = out.join("mining_result.json");
        match fs::remove_file(&single) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(io(&single)(e)),
            _ => {}
        }
        for name in [EPISODES, PRE_LABELS, SUGGESTIONS, CLIPS, TABLE] {
            let path = out.join(name);
            fs::rename(part(&out, name), &path).map_err(io(&path))?;
        }
        let path = out.join(EPISODES);
        let episodes = RefCell::new(File::open(&path).map_err(io(&path))?);
        let alone = self.answers.len() == 1;
        for answer in &mut self.answers {
            answer.close();
            let message = answer.message(&self.counts, &episodes);
            write_json(&results_dir.join(format!("{}.json", answer.question().scenario)), &message)?;
            if alone {
                write_json(&single, &message)?;
            }
        }
        let of_one = self.answers.first().filter(|_| alone);
        let best = of_one.map_or(Ok(vec![]), |a| a.best(BEST, &mut episodes.borrow_mut()));
        let coverage = self.counts.coverage(taxonomy, searched);
        write_json(&out.join("coverage.json"), &coverage)?;
        Ok(Summary {
            drives: self.counts.drives(),
            episodes: self.written,
            coverage,
            best: best.map_err(io(&path))?,
            matched: of_one.map_or(0, Answer::total),
        })
    }
}

const EPISODES: &str = "episodes.jsonl";
const PRE_LABELS: &str = "pre_labels.jsonl";
const SUGGESTIONS: &str = "keyframe_suggestions.jsonl";
const CLIPS: &str = "clip_metadata.jsonl";
const TABLE: &str = "episodes.parquet";

fn part(out: &Path, name: &str) -> PathBuf {
    out.join(format!(".{name}.{PART}"))
}

/// A file of JSON lines that is being written.
struct Lines {
    path: PathBuf,
    out: BufWriter<File>,
    bytes: u64,
}

impl Lines {
    fn create(dir: &Path, name: &str) -> Result<Self, WriteError> {
        let path = part(dir, name);
        let file = File::create(&path).map_err(io(&path))?;
        Ok(Self { path, out: BufWriter::new(file), bytes: 0 })
    }

    fn put(&mut self, message: &impl Serialize) -> Result<LinePlace, WriteError> {
        let mut line = serde_json::to_vec(message).map_err(encoding(&self.path))?;
        let place = LinePlace { start: self.bytes, len: line.len() };
        line.push(b'\n');
        self.bytes += line.len() as u64;
        self.out.write_all(&line).map_err(io(&self.path))?;
        Ok(place)
    }

    fn finish(mut self) -> Result<(), WriteError> {
        self.out.flush().map_err(io(&self.path))
    }
}

/// A clip's pre-label is its best primary episode: the highest score, then the earliest keyframe.
fn with_pre_labels(clip: &ClipMetadata, episodes: &[MinedEpisode]) -> ClipMetadata {
    let of_clip = episodes
        .iter()
        .map(|e| &e.record)
        .filter(|r| r.clip_id.as_str() == clip.clip_id && r.is_primary && r.scenario_id.l1 != OTHER);
    let best = of_clip.reduce(|a, b| if b.score > a.score { b } else { a });
    let pre_labels = best.map(|r| PreLabels {
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

/// Results of an earlier run into the same folder would be taken for this one's.
fn clear(results: &Path) -> Result<(), WriteError> {
    for entry in fs::read_dir(results).map_err(io(results))?.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "json") {
            fs::remove_file(&path).map_err(io(&path))?;
        }
    }
    Ok(())
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> WriteError + '_ {
    |source| WriteError::Io { path: path.to_owned(), source }
}

fn encoding<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> WriteError + '_ {
    |e| WriteError::Encoding { path: path.to_owned(), reason: e.to_string() }
}

fn write_json(path: &Path, message: &impl Serialize) -> Result<(), WriteError> {
    let mut out = BufWriter::new(File::create(path).map_err(io(path))?);
    serde_json::to_writer_pretty(&mut out, message).map_err(encoding(path))?;
    out.write_all(b"\n").and_then(|()| out.flush()).map_err(io(path))
}

fn table(path: &Path) -> Result<ArrowWriter<File>, WriteError> {
    let schema = episode_batch(&[]).map_err(encoding(path))?.schema();
    let version = KeyValue::new("whyroad.episodes_version".to_owned(), EPISODES_VERSION.to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![version]))
        .set_max_row_group_row_count(Some(ROWS_A_GROUP))
        .build();
    let file = File::create(path).map_err(io(path))?;
    ArrowWriter::try_new(file, schema, Some(properties)).map_err(encoding(path))
}
