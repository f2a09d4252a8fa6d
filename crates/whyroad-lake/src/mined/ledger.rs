//! `ledger.jsonl`: the drives that a mined folder was made from, their state, and the positions of their lines, so that
//! the next run into the folder opens only drives that are new or have changed.
//!
//! The last line seals the ledger: it names the files of the folder by their identity (length, time of change, number).
//! A ledger that is not sealed, or whose files were changed, copied or half replaced by a killed run, does not count:
//! then all drives are opened. It covers only results that depend on the drive and on what the run stated about itself
//! in `of`.

use super::error::{MinedWriteError, encoding, io};
use super::{MinedFile, MinedFolder};
use crate::Fingerprint;
use crate::packs::fingerprint::identity;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use whyroad_model::{DriveId, ScenarioId};

/// The files that have lines of drives, in the order of [`LedgerEntry::bytes`].
pub(super) const LINES: [MinedFile; 4] =
    [MinedFile::Episodes, MinedFile::PreLabels, MinedFile::KeyframeSuggestions, MinedFile::Clips];

/// For each rule, by its class: the signals for lack of which it could not be decided.
pub type Gaps = BTreeMap<ScenarioId, Vec<String>>;

/// A drive that was mined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LedgerEntry {
    /// The drive.
    pub drive_id: DriveId,
    /// Its location and state.
    pub fingerprint: Fingerprint,
    /// Hash of what it stated about itself ([`crate::Lake::stated`]).
    pub stated: Option<String>,
    /// Length of its lines in the files of the folder.
    pub bytes: [u64; 4],
    /// Which of [`Ledger::gaps`] are its own.
    pub gaps: usize,
    /// By class: episodes found, and the primary ones among them; also of classes that were not requested.
    pub counts: Vec<(ScenarioId, u64, u64)>,
}

/// Results of an earlier run.
#[derive(Debug)]
pub struct Ledger {
    /// Undecided rules and missing signals, shared by many drives.
    pub gaps: Vec<Gaps>,
    /// The drives, by id.
    pub entries: Vec<LedgerEntry>,
    /// Where the lines of each drive begin.
    starts: Vec<[u64; 4]>,
    files: [File; 4],
    dir: PathBuf,
}

/// The lines of a drive in the files of a folder.
#[derive(Debug, Default)]
pub struct DriveLines([Vec<u8>; 4]);

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Of(String),
    Gaps(Gaps),
    Drive(LedgerEntry),
    Sealed { drives: usize, files: BTreeMap<String, String> },
}

impl Ledger {
    /// The ledger of a folder; `None` without a valid one.
    pub fn open(folder: &MinedFolder, of: &str) -> Option<Self> {
        let text = fs::read(folder.path(MinedFile::Ledger)).ok()?;
        let (mut gaps, mut entries, mut starts) = (Vec::new(), Vec::<LedgerEntry>::new(), Vec::new());
        let (mut stated, mut sealed, mut at) = (None, None, [0_u64; 4]);
        for line in text.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
            if sealed.is_some() {
                return None;
            }
            match serde_json::from_slice(line).ok()? {
                Line::Of(text) => stated = Some(text),
                Line::Gaps(some) => gaps.push(some),
                Line::Drive(entry) => {
                    let sorted = entries.last().is_none_or(|last| last.drive_id < entry.drive_id);
                    if !sorted || entry.gaps >= gaps.len() {
                        return None;
                    }
                    starts.push(at);
                    at = std::array::from_fn(|i| at[i].saturating_add(entry.bytes[i]));
                    entries.push(entry);
                }
                Line::Sealed { drives, files } => sealed = Some((drives, files)),
            }
        }
        let (drives, files) = sealed?;
        if stated.as_deref() != Some(of) || drives != entries.len() || files != identities(folder.dir()) {
            return None;
        }
        let open = LINES.map(|file| File::open(folder.path(file)));
        let [Ok(a), Ok(b), Ok(c), Ok(d)] = open else { return None };
        let files = [a, b, c, d];
        // Every byte of the files belongs to one of the drives.
        let whole = files.iter().zip(at).all(|(f, bytes)| f.metadata().is_ok_and(|m| m.len() == bytes));
        let dir = folder.dir().to_owned();
        whole.then(|| Self { gaps, entries, starts, files, dir })
    }

    /// Position of a drive.
    pub fn find(&self, id: &DriveId) -> Option<usize> {
        self.entries.binary_search_by(|e| e.drive_id.cmp(id)).ok()
    }

    /// The lines of the drive at a position; may be called from several threads.
    ///
    /// # Errors
    /// Where a file cannot be read.
    pub fn lines(&self, at: usize) -> Result<DriveLines, MinedWriteError> {
        let mut out = DriveLines::default();
        for (i, text) in out.0.iter_mut().enumerate() {
            let path = LINES[i].path(&self.dir);
            let bytes = usize::try_from(self.entries[at].bytes[i]).unwrap_or(0);
            *text = read_at(&self.files[i], &path, self.starts[at][i], bytes).map_err(io(&path))?;
        }
        Ok(out)
    }
}

impl DriveLines {
    /// The lines of a file, without their ends; none where the file has no lines of drives.
    pub fn of(&self, file: MinedFile) -> impl Iterator<Item = &[u8]> {
        let text = LINES.iter().position(|f| *f == file).map_or(&[][..], |i| &self.0[i]);
        text.split(|byte| *byte == b'\n').filter(|line| !line.is_empty())
    }

    pub(super) fn text(&self, file: usize) -> &[u8] {
        &self.0[file]
    }
}

#[cfg(unix)]
fn read_at(file: &File, _: &Path, start: u64, bytes: usize) -> std::io::Result<Vec<u8>> {
    let mut text = vec![0; bytes];
    std::os::unix::fs::FileExt::read_exact_at(file, &mut text, start)?;
    Ok(text)
}

#[cfg(not(unix))]
fn read_at(_: &File, path: &Path, start: u64, bytes: usize) -> std::io::Result<Vec<u8>> {
    use std::io::{Read, Seek, SeekFrom};
    let (mut file, mut text) = (File::open(path)?, vec![0; bytes]);
    file.seek(SeekFrom::Start(start))?;
    file.read_exact(&mut text)?;
    Ok(text)
}

/// The files that a ledger is about, as they are now.
fn identities(dir: &Path) -> BTreeMap<String, String> {
    let files = LINES.into_iter().chain([MinedFile::Question]);
    files.map(|file| (file.name().to_owned(), identity(&file.path(dir)))).collect()
}

/// A ledger that is being written.
pub(super) struct LedgerWriter {
    dir: PathBuf,
    out: BufWriter<File>,
    gaps: usize,
    drives: usize,
}

fn part(dir: &Path) -> PathBuf {
    dir.join(format!(".{}.part", MinedFile::Ledger.name()))
}

impl LedgerWriter {
    pub fn create(dir: &Path, of: &str) -> Result<Self, MinedWriteError> {
        let path = part(dir);
        let out = BufWriter::new(File::create(&path).map_err(io(&path))?);
        let mut ledger = Self { dir: dir.to_owned(), out, gaps: 0, drives: 0 };
        ledger.put(&Line::Of(of.to_owned()))?;
        Ok(ledger)
    }

    /// Records a drive. Its undecided rules are written when their number is new; numbers are assigned in order.
    pub fn drive(&mut self, entry: LedgerEntry, gaps: &Gaps) -> Result<(), MinedWriteError> {
        if entry.gaps == self.gaps {
            self.gaps += 1;
            self.put(&Line::Gaps(gaps.clone()))?;
        }
        self.drives += 1;
        self.put(&Line::Drive(entry))
    }

    /// Seals the ledger of the folder, whose files are in place.
    pub fn finish(mut self) -> Result<(), MinedWriteError> {
        self.put(&Line::Sealed { drives: self.drives, files: identities(&self.dir) })?;
        let (path, place) = (part(&self.dir), MinedFile::Ledger.path(&self.dir));
        self.out.flush().map_err(io(&path))?;
        drop(self.out);
        fs::rename(&path, &place).map_err(io(&place))
    }

    fn put(&mut self, line: &Line) -> Result<(), MinedWriteError> {
        let path = part(&self.dir);
        serde_json::to_writer(&mut self.out, line).map_err(encoding(&path))?;
        self.out.write_all(b"\n").map_err(io(&path))
    }
}
