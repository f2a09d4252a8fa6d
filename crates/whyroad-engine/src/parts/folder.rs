//! A part folder: the results of one worker on its drives.
//!
//! | file | content |
//! |---|---|
//! | `work.json` | what the worker does: list, question, versions; written first |
//! | `drives.jsonl` | one line per begun and per finished drive, so that a worker that died names its suspects |
//! | `part.json` | written last: counts, and the hash of `drives.jsonl`; without it the part is not complete |

use super::wire::Exact;
use super::{Request, WorkList};
use crate::mine::MinedDrive;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use whyroad_framework::Taxonomy;
use whyroad_mining::RuleSet;
use whyroad_model::{Bilingual, Diagnostic, DriveId};

pub(super) const WORK: &str = "work.json";
pub(super) const DRIVES: &str = "drives.jsonl";
pub(super) const PART: &str = "part.json";
pub(super) const LOCK: &str = "lock";

/// A part cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The file system refused.
    #[error("{}: {source}", .path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// A file is not valid.
    #[error("{}: {reason}", .path.display())]
    Broken {
        /// File.
        path: PathBuf,
        /// Description of the error.
        reason: String,
    },
    /// The folder belongs to another list, question or version.
    #[error("{} holds a part of other work", .0.display())]
    OtherWork(PathBuf),
    /// Another worker writes this part.
    #[error("another worker is writing {}", .0.display())]
    Busy(PathBuf),
}

pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> PartError + '_ {
    |source| PartError::Io { path: path.to_owned(), source }
}

pub(super) fn broken(path: &Path, reason: impl ToString) -> PartError {
    PartError::Broken { path: path.to_owned(), reason: reason.to_string() }
}

/// Dependencies of results besides drives and question. Parts are only merged where all of it is equal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// The program.
    pub whyroad: String,
    /// Derivation of signals.
    pub signals: String,
    /// Evaluation of rules.
    pub mining: String,
    /// Hash of the classes, their order of precedence and calibration, and the framework's rules.
    pub framework: String,
    /// Hash of the rules that are run.
    pub rules: String,
}

impl Versions {
    /// Of this program with a framework, all of its rules, and those that are run.
    pub fn of(taxonomy: &Taxonomy, all: &RuleSet, run: &RuleSet) -> Self {
        let of_rules = |set: &RuleSet| {
            let keys: String = set.rules.iter().map(crate::mine::rule_key).collect();
            blake3::hash(keys.as_bytes()).to_hex()[..32].to_owned()
        };
        let text = format!(
            "{} {:?} {:?} {:?} {}",
            taxonomy.version,
            taxonomy.ids(),
            all.precedence,
            all.calibration,
            of_rules(all)
        );
        Self {
            whyroad: env!("CARGO_PKG_VERSION").to_owned(),
            signals: whyroad_signals::VERSION.to_owned(),
            mining: whyroad_mining::VERSION.to_owned(),
            framework: blake3::hash(text.as_bytes()).to_hex()[..32].to_owned(),
            rules: of_rules(run),
        }
    }
}

/// `work.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Work {
    /// `whyroad-part`.
    pub format: String,
    /// Versions.
    pub versions: Versions,
    /// The question.
    pub request: Request,
    /// The drives.
    pub list: WorkList,
}

pub(super) const FORMAT: &str = "whyroad-part";

/// A line of `drives.jsonl`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    /// Work on the drive begins.
    Begun(DriveId),
    /// The drive is finished.
    Done { drive_id: DriveId, content_hash: String, mined: Exact },
    /// The drive is set aside.
    Failed(Failed),
}

/// A drive without results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failed {
    /// The drive.
    pub drive_id: DriveId,
    /// Code of the diagnostic.
    pub code: String,
    /// What is wrong.
    pub message: Bilingual,
}

impl Failed {
    pub(super) fn of(drive_id: &DriveId, d: &Diagnostic) -> Self {
        Self { drive_id: drive_id.clone(), code: d.code.to_owned(), message: d.message.clone() }
    }

    /// The original diagnostic.
    pub fn diagnostic(&self) -> Diagnostic {
        let known = ["mine.drive.crashed", "mine.drive.kills_worker", "mine.drive.unknown"];
        let code = known.into_iter().find(|c| *c == self.code).unwrap_or("mine.drive.unreadable");
        Diagnostic::error(code, self.message.clone())
    }
}

/// `part.json`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Seal {
    /// Drives with results.
    pub drives: usize,
    /// Drives set aside.
    pub failed: usize,
    /// BLAKE3 of `drives.jsonl`.
    pub hash: String,
}

/// Where a finished drive is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub start: u64,
    pub len: usize,
}

/// Contents of the lines of a part so far.
#[derive(Debug, Default)]
pub(super) struct Progress {
    /// Finished drives: content and position.
    pub done: BTreeMap<DriveId, (String, Span)>,
    pub failed: BTreeMap<DriveId, Failed>,
    /// Number of starts of each drive.
    pub begun: BTreeMap<DriveId, usize>,
    /// Length of the complete lines, bytes.
    pub length: u64,
}

impl Progress {
    /// Reads the lines; a last line that a killed worker left incomplete does not count.
    pub fn read(path: &Path) -> Result<Self, PartError> {
        let mut out = Self::default();
        let file = match File::open(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(out),
            opened => opened.map_err(io(path))?,
        };
        let (mut file, mut line) = (BufReader::new(file), Vec::new());
        loop {
            line.clear();
            let len = file.read_until(b'\n', &mut line).map_err(io(path))?;
            if len == 0 || line.last() != Some(&b'\n') {
                return Ok(out);
            }
            let span = Span { start: out.length, len };
            out.length += len as u64;
            match serde_json::from_slice(&line).map_err(|e| broken(path, e))? {
                Line::Begun(id) => *out.begun.entry(id).or_default() += 1,
                Line::Done { drive_id, content_hash, .. } => {
                    out.done.insert(drive_id, (content_hash, span));
                }
                Line::Failed(failed) => {
                    out.failed.insert(failed.drive_id.clone(), failed);
                }
            }
        }
    }
}

/// A complete part.
pub struct Part {
    pub(super) dir: PathBuf,
    /// Its summary.
    pub work: Work,
    pub(super) progress: Progress,
    drives: File,
}

impl Part {
    /// Opens a part; `None` where it is not complete.
    pub fn open(dir: &Path) -> Result<Option<Self>, PartError> {
        let path = dir.join(DRIVES);
        let work = read_json::<Work>(&dir.join(WORK))?;
        let seal = dir.join(PART);
        if !seal.exists() {
            return Ok(None);
        }
        let seal: Seal = read_json(&seal)?;
        if hash(&path)? != seal.hash {
            return Err(broken(&path, "its content differs from part.json"));
        }
        let progress = Progress::read(&path)?;
        let drives = File::open(&path).map_err(io(&path))?;
        Ok(Some(Self { dir: dir.to_owned(), work, progress, drives }))
    }

    /// The part folders at or directly below `dir`, by path.
    pub fn find(dir: &Path) -> Result<Vec<PathBuf>, PartError> {
        if dir.join(WORK).is_file() {
            return Ok(vec![dir.to_owned()]);
        }
        let below = fs::read_dir(dir).map_err(io(dir))?.flatten().map(|e| e.path());
        let mut found: Vec<PathBuf> = below.filter(|p| p.join(WORK).is_file()).collect();
        found.sort();
        if found.is_empty() { Err(broken(dir, "there is no part in this folder")) } else { Ok(found) }
    }

    /// True where the part of this folder, complete or not, names one of these drives.
    pub fn names_any(dir: &Path, drives: &BTreeSet<DriveId>) -> Result<bool, PartError> {
        let work: Work = read_json(&dir.join(WORK))?;
        Ok(work.list.drives.iter().any(|d| drives.contains(&d.drive_id)))
    }

    /// The results of a finished drive.
    pub(super) fn mined(&mut self, span: Span) -> Result<MinedDrive, PartError> {
        let path = self.dir.join(DRIVES);
        let mut line = vec![0; span.len];
        self.drives.seek(SeekFrom::Start(span.start)).map_err(io(&path))?;
        self.drives.read_exact(&mut line).map_err(io(&path))?;
        match serde_json::from_slice(&line).map_err(|e| broken(&path, e))? {
            Line::Done { mined, .. } => mined.read().map_err(|e| broken(&path, e)),
            _ => Err(broken(&path, "a line is not a finished drive")),
        }
    }
}

pub(super) fn hash(path: &Path) -> Result<String, PartError> {
    let mut hasher = blake3::Hasher::new();
    let mut file = File::open(path).map_err(io(path))?;
    std::io::copy(&mut file, &mut hasher).map_err(io(path))?;
    Ok(hasher.finalize().to_hex().to_string())
}

pub(super) fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, PartError> {
    let text = fs::read(path).map_err(io(path))?;
    serde_json::from_slice(&text).map_err(|e| broken(path, e))
}

/// Writes a file atomically.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), PartError> {
    let aside = path.with_extension("json.new");
    let mut text = serde_json::to_vec_pretty(value).map_err(|e| broken(path, e))?;
    text.push(b'\n');
    fs::write(&aside, text).map_err(io(&aside))?;
    fs::rename(&aside, path).map_err(io(path))
}
