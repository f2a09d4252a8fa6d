//! A mined folder: what `whyroad mine --out` writes and every later command reads. The only place that knows its file
//! names and columns (`docs/reference/rules.md` lists the files).
//!
//! Episodes are read in two ways, neither of which holds all of them in memory: from the first to the last
//! ([`MinedFolder::episodes`], JSON Lines), or page by page with a filter ([`EpisodeIndex`], Parquet).

mod columns;
mod error;
mod index;
mod ledger;
mod lines;
mod publish;
mod question;
mod summary;
mod write;

pub use columns::{EPISODES_VERSION, episode_table};
pub use error::MinedWriteError;
pub use index::EpisodeIndex;
pub use ledger::{DriveLines, Gaps, Ledger, LedgerEntry};
pub use lines::{EpisodeLines, LineSpan};
pub use publish::{FolderLock, Publication, PublishError};
pub use question::MiningQuestion;
pub use summary::{DriveSummary, EpisodeSummary};
pub use write::{Existing, FinishedEpisodes, MinedFolderWriter, WrittenDrive};

use crate::LakeError;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_model::messages::Coverage;
use whyroad_model::{Bilingual, Diagnostic, Location};

/// Codes of the diagnostics about mined folders; each has a page in the documentation.
pub const CODES: &[&str] = &["report.coverage.unreadable", "report.episode.unreadable"];

/// The files of a mined folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MinedFile {
    /// The question that was asked.
    Question,
    /// All episodes with their evidence, one JSON object per line.
    Episodes,
    /// All episodes as a table, which is also the index of [`MinedFile::Episodes`].
    EpisodeTable,
    /// `scenario_pre_label` messages, one per line.
    PreLabels,
    /// `keyframe_suggestion` messages, one per line.
    KeyframeSuggestions,
    /// `clip_metadata` messages, one per line.
    Clips,
    /// What was searched for and what was found, for every leaf.
    Coverage,
    /// Folder with a `mining_result` message for each requested class.
    Results,
    /// The `mining_result` message of a single question.
    SingleResult,
    /// Which drives the folder was made from.
    Ledger,
}

impl MinedFile {
    /// Its name in the folder.
    pub fn name(self) -> &'static str {
        match self {
            MinedFile::Question => "question.json",
            MinedFile::Episodes => "episodes.jsonl",
            MinedFile::EpisodeTable => "episodes.parquet",
            MinedFile::PreLabels => "pre_labels.jsonl",
            MinedFile::KeyframeSuggestions => "keyframe_suggestions.jsonl",
            MinedFile::Clips => "clip_metadata.jsonl",
            MinedFile::Coverage => "coverage.json",
            MinedFile::Results => "mining_results",
            MinedFile::SingleResult => "mining_result.json",
            MinedFile::Ledger => "ledger.jsonl",
        }
    }

    /// Its path in the folder `dir`.
    pub fn path(self, dir: &Path) -> PathBuf {
        dir.join(self.name())
    }
}

/// A folder that holds mining results.
#[derive(Clone, Debug)]
pub struct MinedFolder {
    dir: PathBuf,
}

impl MinedFolder {
    /// The mined folder `dir`; `None` when it holds no episodes file.
    pub fn open(dir: impl AsRef<Path>) -> Option<Self> {
        let dir = dir.as_ref();
        MinedFile::Episodes.path(dir).is_file().then(|| Self { dir: dir.to_owned() })
    }

    /// The mined folders at or directly below `dir`, by the name of their folder.
    pub fn find(dir: &Path) -> std::io::Result<BTreeMap<String, Self>> {
        if let Some(folder) = Self::open(dir) {
            return Ok([(folder.folder_name(), folder)].into());
        }
        // A name with a leading dot is a folder being written.
        let visible = |e: &fs::DirEntry| !e.file_name().to_string_lossy().starts_with('.');
        let below = fs::read_dir(dir)?.flatten().filter(visible).filter_map(|e| Self::open(e.path()));
        Ok(below.map(|folder| (folder.folder_name(), folder)).collect())
    }

    fn folder_name(&self) -> String {
        // `mined/.` and `mined/` have no name of their own, the folder that they lead to has.
        let real = self.dir.canonicalize().unwrap_or_else(|_| self.dir.clone());
        real.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The path of one of its files, whether it exists or not.
    pub fn path(&self, file: MinedFile) -> PathBuf {
        file.path(&self.dir)
    }

    /// All episodes from the first to the last, one at a time.
    pub fn episodes(&self) -> Result<EpisodeLines, LakeError> {
        EpisodeLines::open(&self.path(MinedFile::Episodes))
    }

    /// The index of the episodes: counts and pages.
    pub fn index(&self) -> Result<EpisodeIndex, LakeError> {
        EpisodeIndex::open(&self.path(MinedFile::EpisodeTable), &self.path(MinedFile::Episodes))
    }

    /// The question that the folder answers; `None` when it does not record one.
    pub fn question(&self) -> Option<MiningQuestion> {
        MiningQuestion::read(&self.path(MinedFile::Question))
    }

    /// Coverage over all leaves.
    pub fn coverage(&self) -> Result<Coverage, Box<Diagnostic>> {
        let path = self.path(MinedFile::Coverage);
        let text = fs::read_to_string(&path).map_err(|e| Box::new(LakeError::io(&path)(e).diagnostic()))?;
        parse_coverage(&text, &path.display().to_string())
    }
}

fn parse_coverage(text: &str, file: &str) -> Result<Coverage, Box<Diagnostic>> {
    serde_json::from_str(text).map_err(|e| {
        let message =
            Bilingual::new(format!("覆盖统计无法读取：{e}"), format!("the coverage cannot be read: {e}"));
        Box::new(
            Diagnostic::error("report.coverage.unreadable", message)
                .with_hint(mine_again())
                .at(Location { line: Some(e.line()), column: Some(e.column().max(1)), ..Location::default() })
                .in_file(file),
        )
    })
}

fn mine_again() -> Bilingual {
    Bilingual::new("重新运行 `whyroad mine` 生成该文件夹", "run `whyroad mine` again to write the folder")
}

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
