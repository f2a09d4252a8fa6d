//! JSON Lines files of a mined folder: written with the place of each line, read one line at a time. A line that cannot
//! be read is reported and does not stop the rest.

use super::error::{MinedWriteError, encoding, io};
use super::mine_again;
use crate::LakeError;
use serde::Serialize;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use whyroad_model::messages::EpisodeRecord;
use whyroad_model::{Bilingual, Diagnostic, Location};

/// Where a line is in its file, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineSpan {
    /// From the start of the file.
    pub start: u64,
    /// Length without the line's end.
    pub len: usize,
}

/// A JSON Lines file that is being written.
pub(super) struct LineWriter {
    path: PathBuf,
    out: BufWriter<File>,
    bytes: u64,
}

impl LineWriter {
    pub fn create(path: PathBuf) -> Result<Self, MinedWriteError> {
        let file = File::create(&path).map_err(io(&path))?;
        Ok(Self { path, out: BufWriter::new(file), bytes: 0 })
    }

    pub fn put(&mut self, message: &impl Serialize) -> Result<LineSpan, MinedWriteError> {
        self.copy(serde_json::to_vec(message).map_err(encoding(&self.path))?)
    }

    /// Writes a line of another file unchanged, given without its end.
    pub fn copy(&mut self, mut line: Vec<u8>) -> Result<LineSpan, MinedWriteError> {
        let span = LineSpan { start: self.bytes, len: line.len() };
        line.push(b'\n');
        self.bytes += line.len() as u64;
        self.out.write_all(&line).map_err(io(&self.path))?;
        Ok(span)
    }

    /// Writes complete lines of another file unchanged.
    pub fn copy_all(&mut self, text: &[u8]) -> Result<(), MinedWriteError> {
        self.bytes += text.len() as u64;
        self.out.write_all(text).map_err(io(&self.path))
    }

    /// Length so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    pub fn finish(mut self) -> Result<(), MinedWriteError> {
        self.out.flush().map_err(io(&self.path))
    }
}

/// The episodes of a file, read one at a time. A line that is not an episode yields an error at its position; after a
/// file system error the iteration ends.
pub struct EpisodeLines {
    path: PathBuf,
    lines: BufReader<File>,
    number: usize,
    failed: bool,
}

impl EpisodeLines {
    pub(super) fn open(path: &Path) -> Result<Self, LakeError> {
        let file = File::open(path).map_err(LakeError::io(path))?;
        Ok(Self { path: path.to_owned(), lines: BufReader::new(file), number: 0, failed: false })
    }
}

impl Iterator for EpisodeLines {
    type Item = Result<EpisodeRecord, Box<Diagnostic>>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut line = Vec::new();
        while !self.failed {
            line.clear();
            match self.lines.read_until(b'\n', &mut line) {
                Ok(0) => return None,
                Ok(_) => {}
                Err(e) => {
                    self.failed = true;
                    return Some(Err(Box::new(LakeError::io(&self.path)(e).diagnostic())));
                }
            }
            self.number += 1;
            if !line.trim_ascii().is_empty() {
                let record = serde_json::from_slice(line.trim_ascii_end());
                return Some(record.map_err(|e| self.unreadable(&e)));
            }
        }
        None
    }
}

impl EpisodeLines {
    fn unreadable(&self, e: &serde_json::Error) -> Box<Diagnostic> {
        let message = Bilingual::new(
            format!("该行不是事件记录，已跳过：{e}"),
            format!("this line is not an episode and is ignored: {e}"),
        );
        let place =
            Location { line: Some(self.number), column: Some(e.column().max(1)), ..Location::default() };
        Box::new(
            Diagnostic::error("report.episode.unreadable", message)
                .with_hint(mine_again())
                .at(place)
                .in_file(self.path.display().to_string()),
        )
    }
}
