//! Writing a mined folder, episode by episode. Files are written under temporary names and moved into place at the end:
//! results of an earlier run stay until this one is done.

use super::columns::{EPISODES_VERSION, VERSION_KEY, episode_batch};
use super::error::{MinedWriteError, encoding, io};
use super::ledger::{LINES, LedgerWriter};
use super::lines::LineWriter;
use super::{DriveLines, Gaps, LedgerEntry, LineSpan, MinedFile, MiningQuestion};
use crate::Fingerprint;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use whyroad_model::messages::{
    ClipMetadataMessage, Coverage, EpisodeRecord, KeyframeSuggestionMessage, ScenarioPreLabelMessage,
};
use whyroad_model::{DriveId, ScenarioId};

/// Episodes that are written to the Parquet file together; also the number of rows per row group.
const EPISODES_PER_BATCH: usize = 512;
const ROWS_PER_GROUP: usize = 1 << 16;

/// What happens to results that are in the folder already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Results of the same question are replaced; those of another question are an error.
    #[default]
    ReplaceSameQuestion,
    /// Existing results are always replaced.
    Replace,
}

/// A mined folder that is being written.
pub struct MinedFolderWriter {
    dir: PathBuf,
    question: MiningQuestion,
    episodes: LineWriter,
    pre_labels: LineWriter,
    suggestions: LineWriter,
    clips: LineWriter,
    table: ArrowWriter<File>,
    /// Episodes that are not in the table yet.
    waiting: Vec<(EpisodeRecord, LineSpan)>,
    written: usize,
    ledger: Option<LedgerWriter>,
    /// Lengths of the files when the last drive was complete.
    accounted: [u64; 4],
}

/// A drive whose lines were written, for the ledger.
pub struct WrittenDrive<'a> {
    /// The drive.
    pub drive_id: &'a DriveId,
    /// Its location and state before it was mined.
    pub fingerprint: Fingerprint,
    /// Hash of what it stated about itself before it was mined.
    pub stated: Option<String>,
    /// What could not be decided, and its number: equal gaps share one, assigned in order from 0.
    pub gaps: (usize, &'a Gaps),
    /// By class: episodes found, and the primary ones among them.
    pub counts: Vec<(ScenarioId, u64, u64)>,
}

impl MinedFolderWriter {
    /// Begins a folder that answers `question`. Fails when it holds results of another one, unless they may be
    /// replaced.
    pub fn create(dir: &Path, question: MiningQuestion, existing: Existing) -> Result<Self, MinedWriteError> {
        if existing == Existing::ReplaceSameQuestion
            && let Some(folder) = super::MinedFolder::open(dir)
        {
            let found = folder.question();
            if found.as_ref() != Some(&question) {
                return Err(MinedWriteError::OtherQuestion {
                    dir: dir.to_owned(),
                    found: found.map(Box::new),
                });
            }
        }
        fs::create_dir_all(dir).map_err(io(dir))?;
        let lines = |file| LineWriter::create(part(dir, file));
        Ok(Self {
            question,
            episodes: lines(MinedFile::Episodes)?,
            pre_labels: lines(MinedFile::PreLabels)?,
            suggestions: lines(MinedFile::KeyframeSuggestions)?,
            clips: lines(MinedFile::Clips)?,
            table: table(&part(dir, MinedFile::EpisodeTable))?,
            dir: dir.to_owned(),
            waiting: Vec::new(),
            written: 0,
            ledger: None,
            accounted: [0; 4],
        })
    }

    /// Also writes a ledger. `of` is all that the results depend on besides the drives.
    pub fn keep_ledger(&mut self, of: &str) -> Result<(), MinedWriteError> {
        self.ledger = Some(LedgerWriter::create(&self.dir, of)?);
        Ok(())
    }

    /// Records a drive in the ledger; every line since the previous drive belongs to it.
    pub fn account(&mut self, drive: WrittenDrive<'_>) -> Result<(), MinedWriteError> {
        let bytes = [&self.episodes, &self.pre_labels, &self.suggestions, &self.clips].map(LineWriter::bytes);
        let before = std::mem::replace(&mut self.accounted, bytes);
        let Some(ledger) = &mut self.ledger else { return Ok(()) };
        let entry = LedgerEntry {
            drive_id: drive.drive_id.clone(),
            fingerprint: drive.fingerprint,
            stated: drive.stated,
            bytes: std::array::from_fn(|i| bytes[i] - before[i]),
            gaps: drive.gaps.0,
            counts: drive.counts,
        };
        ledger.drive(entry, drive.gaps.1)
    }

    /// Adds a drive's lines of an earlier run as they are, but for its episodes, which
    /// [`MinedFolderWriter::same_episode`] adds.
    pub fn same_lines(&mut self, lines: &DriveLines) -> Result<(), MinedWriteError> {
        for (i, file) in LINES.into_iter().enumerate() {
            match file {
                MinedFile::PreLabels => self.pre_labels.copy_all(lines.text(i))?,
                MinedFile::KeyframeSuggestions => self.suggestions.copy_all(lines.text(i))?,
                MinedFile::Clips => self.clips.copy_all(lines.text(i))?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds an episode with its line of an earlier run.
    pub fn same_episode(&mut self, record: &EpisodeRecord, line: &[u8]) -> Result<LineSpan, MinedWriteError> {
        let span = LineSpan { start: self.episodes.bytes(), len: line.len() };
        self.episodes.copy_all(line)?;
        self.episodes.copy_all(b"\n")?;
        self.wait(record.clone(), span)?;
        Ok(span)
    }

    fn wait(&mut self, record: EpisodeRecord, span: LineSpan) -> Result<(), MinedWriteError> {
        self.written += 1;
        self.waiting.push((record, span));
        if self.waiting.len() >= EPISODES_PER_BATCH { self.write_waiting() } else { Ok(()) }
    }

    /// Adds an episode; they come in the order of drive, keyframe, class, target.
    pub fn episode(&mut self, record: &EpisodeRecord) -> Result<LineSpan, MinedWriteError> {
        let line = serde_json::to_vec(record).map_err(encoding(&part(&self.dir, MinedFile::Episodes)))?;
        self.episode_line(record, line)
    }

    /// The same with the episode's line of another folder, which is written unchanged: numbers keep all their digits.
    pub fn episode_line(
        &mut self,
        record: &EpisodeRecord,
        line: Vec<u8>,
    ) -> Result<LineSpan, MinedWriteError> {
        let span = self.episodes.copy(line)?;
        self.wait(record.clone(), span)?;
        Ok(span)
    }

    /// Adds a proposal for the class of an episode.
    pub fn pre_label(&mut self, message: &ScenarioPreLabelMessage) -> Result<(), MinedWriteError> {
        self.pre_labels.put(message).map(drop)
    }

    /// Adds a proposal for the keyframe of an episode.
    pub fn keyframe_suggestion(
        &mut self,
        message: &KeyframeSuggestionMessage,
    ) -> Result<(), MinedWriteError> {
        self.suggestions.put(message).map(drop)
    }

    /// Adds a clip.
    pub fn clip(&mut self, message: &ClipMetadataMessage) -> Result<(), MinedWriteError> {
        self.clips.put(message).map(drop)
    }

    /// Adds a line of another folder's pre-labels, keyframe suggestions or clips unchanged. Other files have no lines.
    pub fn line(&mut self, file: MinedFile, line: Vec<u8>) -> Result<(), MinedWriteError> {
        match file {
            MinedFile::PreLabels => self.pre_labels.copy(line).map(drop),
            MinedFile::KeyframeSuggestions => self.suggestions.copy(line).map(drop),
            MinedFile::Clips => self.clips.copy(line).map(drop),
            _ => Ok(()),
        }
    }

    /// Number of episodes so far.
    pub fn episodes(&self) -> usize {
        self.written
    }

    fn write_waiting(&mut self) -> Result<(), MinedWriteError> {
        let path = part(&self.dir, MinedFile::EpisodeTable);
        let batch = episode_batch(&self.waiting).map_err(encoding(&path))?;
        self.table.write(&batch).map_err(encoding(&path))?;
        self.waiting.clear();
        Ok(())
    }

    /// Puts the tables and lines in place of those of an earlier run, whose results are removed. The folder then lacks
    /// its results and its coverage.
    pub fn finish(mut self) -> Result<FinishedEpisodes, MinedWriteError> {
        self.write_waiting()?;
        let dir = self.dir;
        self.table.close().map_err(encoding(&part(&dir, MinedFile::EpisodeTable)))?;
        for lines in [self.episodes, self.pre_labels, self.suggestions, self.clips] {
            lines.finish()?;
        }
        json(&part(&dir, MinedFile::Question), &self.question)?;
        let results = MinedFile::Results.path(&dir);
        fs::create_dir_all(&results).map_err(io(&results))?;
        clear(&results)?;
        // It would refer to other files.
        for file in [MinedFile::SingleResult, MinedFile::Ledger] {
            let path = file.path(&dir);
            match fs::remove_file(&path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(io(&path)(e)),
                _ => {}
            }
        }
        // The question first: after a kill in between, the folder never shows results under another question.
        for file in [
            MinedFile::Question,
            MinedFile::Episodes,
            MinedFile::PreLabels,
            MinedFile::KeyframeSuggestions,
            MinedFile::Clips,
            MinedFile::EpisodeTable,
        ] {
            let path = file.path(&dir);
            fs::rename(part(&dir, file), &path).map_err(io(&path))?;
        }
        Ok(FinishedEpisodes { dir, ledger: self.ledger })
    }
}

/// A folder whose episodes are in place: results and coverage follow.
pub struct FinishedEpisodes {
    dir: PathBuf,
    ledger: Option<LedgerWriter>,
}

impl FinishedEpisodes {
    /// The episodes' lines, to be read by their [`LineSpan`].
    pub fn open_episodes(&self) -> Result<File, MinedWriteError> {
        let path = MinedFile::Episodes.path(&self.dir);
        File::open(&path).map_err(io(&path))
    }

    /// An error of reading what [`Self::open_episodes`] opened.
    pub fn unreadable(&self, e: std::io::Error) -> MinedWriteError {
        io(&MinedFile::Episodes.path(&self.dir))(e)
    }

    /// Writes the `mining_result` of a class; for a single question also under a fixed name.
    pub fn result(
        &self,
        class: &ScenarioId,
        message: &impl Serialize,
        only: bool,
    ) -> Result<(), MinedWriteError> {
        json(&MinedFile::Results.path(&self.dir).join(format!("{class}.json")), message)?;
        if only { json(&MinedFile::SingleResult.path(&self.dir), message) } else { Ok(()) }
    }

    /// Moves the ledger into place, after everything else.
    pub fn seal(self) -> Result<(), MinedWriteError> {
        self.ledger.map_or(Ok(()), LedgerWriter::finish)
    }

    /// Writes the coverage.
    pub fn coverage(&self, coverage: &Coverage) -> Result<(), MinedWriteError> {
        json(&MinedFile::Coverage.path(&self.dir), coverage)
    }
}

/// Name of a file that is not finished.
fn part(dir: &Path, file: MinedFile) -> PathBuf {
    dir.join(format!(".{}.part", file.name()))
}

/// Results of an earlier run into the same folder would be mistaken for results of this one.
fn clear(results: &Path) -> Result<(), MinedWriteError> {
    for entry in fs::read_dir(results).map_err(io(results))?.flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "json") {
            fs::remove_file(&path).map_err(io(&path))?;
        }
    }
    Ok(())
}

fn json(path: &Path, message: &impl Serialize) -> Result<(), MinedWriteError> {
    let mut out = BufWriter::new(File::create(path).map_err(io(path))?);
    serde_json::to_writer_pretty(&mut out, message).map_err(encoding(path))?;
    out.write_all(b"\n").and_then(|()| out.flush()).map_err(io(path))
}

fn table(path: &Path) -> Result<ArrowWriter<File>, MinedWriteError> {
    let schema = episode_batch(&[]).map_err(encoding(path))?.schema();
    let version = KeyValue::new(VERSION_KEY.to_owned(), EPISODES_VERSION.to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![version]))
        .set_max_row_group_row_count(Some(ROWS_PER_GROUP))
        .build();
    let file = File::create(path).map_err(io(path))?;
    ArrowWriter::try_new(file, schema, Some(properties)).map_err(encoding(path))
}
