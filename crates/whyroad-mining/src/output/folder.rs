//! The folder that `whyroad mine --out` writes.

use super::coverage::coverage;
use super::episode_table::{EPISODES_VERSION, episode_batch};
use super::record::MinedEpisode;
use super::result::mining_result;
use crate::engine::MinedLake;
use crate::rule::OTHER;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use whyroad_framework::Taxonomy;
use whyroad_model::ScenarioId;
use whyroad_model::messages::{
    ClipMetadata, ClipMetadataMessage, Coverage, KeyframeSuggestionMessage, MiningResultMessage,
    PreLabelScenario, PreLabels, ScenarioPreLabelMessage,
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

/// A question that was asked: a `mining_result` is written for each.
#[derive(Clone, Debug)]
pub struct Question {
    /// Repeated in the result.
    pub query_id: String,
    /// Class asked for.
    pub scenario: ScenarioId,
    /// At most so many clips.
    pub limit: Option<u32>,
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Summary {
    /// One result a question.
    pub results: Vec<MiningResultMessage>,
    /// All leaves.
    pub coverage: Coverage,
}

/// Writes everything. A single question's result is also `mining_result.json`.
pub fn write_folder(
    out: &Path,
    mined: &MinedLake,
    questions: &[Question],
    taxonomy: &Taxonomy,
    rules: &[ScenarioId],
) -> Result<Summary, WriteError> {
    let results_dir = out.join("mining_results");
    fs::create_dir_all(&results_dir).map_err(io(&results_dir))?;
    clear(&results_dir)?;
    let single = out.join("mining_result.json");
    match fs::remove_file(&single) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(io(&single)(e)),
        _ => {}
    }
    let mut results = Vec::new();
    for q in questions {
        let message = mining_result(mined, &q.query_id, &q.scenario, q.limit);
        write_json(&results_dir.join(format!("{}.json", q.scenario)), &message)?;
        if questions.len() == 1 {
            write_json(&single, &message)?;
        }
        results.push(message);
    }
    let episodes: Vec<&MinedEpisode> = mined.drives.iter().flat_map(|d| &d.episodes).collect();
    write_lines(&out.join("episodes.jsonl"), episodes.iter().map(|e| &e.record))?;
    write_lines(
        &out.join("pre_labels.jsonl"),
        // What no class explains has no class to propose.
        episodes.iter().filter(|e| e.record.scenario_id.l1 != OTHER).map(|e| ScenarioPreLabelMessage {
            scenario_pre_label: e.pre_label.clone(),
            episode_id: Some(e.record.episode_id.clone()),
            clip_id: Some(e.record.clip_id.to_string()),
        }),
    )?;
    write_lines(
        &out.join("keyframe_suggestions.jsonl"),
        episodes.iter().map(|e| KeyframeSuggestionMessage {
            keyframe_suggestion: e.suggestion.clone(),
            episode_id: Some(e.record.episode_id.clone()),
            clip_id: Some(e.record.clip_id.to_string()),
        }),
    )?;
    let clips = mined.drives.iter().flat_map(|d| d.clips.iter().map(|c| with_pre_labels(c, &d.episodes)));
    write_lines(
        &out.join("clip_metadata.jsonl"),
        clips.map(|clip_metadata| ClipMetadataMessage { clip_metadata }),
    )?;
    write_parquet(&out.join("episodes.parquet"), &episodes)?;
    let coverage = coverage(mined, taxonomy, rules);
    write_json(&out.join("coverage.json"), &coverage)?;
    Ok(Summary { results, coverage })
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
    let mut text = serde_json::to_string_pretty(message).map_err(encoding(path))?;
    text.push('\n');
    fs::write(path, text).map_err(io(path))
}

fn write_lines<M: Serialize>(path: &Path, messages: impl Iterator<Item = M>) -> Result<(), WriteError> {
    let mut out = BufWriter::new(File::create(path).map_err(io(path))?);
    for m in messages {
        serde_json::to_writer(&mut out, &m).map_err(encoding(path))?;
        out.write_all(b"\n").map_err(io(path))?;
    }
    out.flush().map_err(io(path))
}

fn write_parquet(path: &Path, episodes: &[&MinedEpisode]) -> Result<(), WriteError> {
    let batch = episode_batch(episodes).map_err(encoding(path))?;
    let version = KeyValue::new("whyroad.episodes_version".to_owned(), EPISODES_VERSION.to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![version]))
        .build();
    let file = File::create(path).map_err(io(path))?;
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).map_err(encoding(path))?;
    writer.write(&batch).map_err(encoding(path))?;
    writer.close().map_err(encoding(path))?;
    Ok(())
}
