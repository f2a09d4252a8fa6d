//! A pack that is being read: its drives, and the footers of its files, each read once.

use crate::columns::Table;
use crate::manifest::DriveManifest;
use crate::{LakeError, SignalFile, file};
use parquet::arrow::arrow_reader::ArrowReaderMetadata;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};
use whyroad_model::DriveId;

pub(crate) const DRIVES: &str = "drives.parquet";
pub(super) const DRIVES_ORDER: &str = "drive";
/// The table of small files kept beside drives.
pub(super) const NOTES: &str = "notes";
pub(super) const NOTES_ORDER: &str = "drive, name";
pub(super) const SIGNALS: &str = "signals";

/// An opened pack.
#[derive(Debug)]
pub(crate) struct OpenPack {
    /// Its folder.
    pub dir: PathBuf,
    /// `drive.json` of each drive, in the order of ids.
    pub manifests: Vec<DriveManifest>,
    /// Fingerprint of the folder from which each drive was packed; empty where there was none.
    pub fingerprints: Vec<String>,
    /// Number of small files of each drive.
    notes: Vec<u32>,
    footers: Mutex<BTreeMap<String, Option<ArrowReaderMetadata>>>,
    signals: OnceLock<Option<SignalFile>>,
}

impl OpenPack {
    pub fn read(dir: PathBuf) -> Result<Self, LakeError> {
        let path = dir.join(DRIVES);
        let table = file::read_table(&path, DRIVES_ORDER)?
            .ok_or_else(|| LakeError::broken(&path, "the file is missing, although the catalog names it"))?;
        let manifest = |text: &str| -> Result<DriveManifest, LakeError> {
            serde_json::from_str(text).map_err(|e| LakeError::broken(&path, e))
        };
        let manifests =
            table.texts("manifest")?.iter().flatten().map(manifest).collect::<Result<Vec<_>, _>>()?;
        let fingerprints = table.texts("fingerprint")?.iter().flatten().map(str::to_owned).collect();
        let notes = table.indices("notes")?;
        Ok(Self { dir, manifests, fingerprints, notes, footers: Mutex::default(), signals: OnceLock::new() })
    }

    pub fn path(&self, table: &str) -> PathBuf {
        self.dir.join(format!("{table}.parquet"))
    }

    /// The drive's row group in the file of a table; `None` where it has no rows.
    pub fn group(&self, table: &str, row: usize) -> Option<usize> {
        let has = |i: usize| match table {
            NOTES => self.notes[i] > 0,
            _ => self.manifests[i].tables.get(table).is_some_and(|rows| *rows > 0),
        };
        has(row).then(|| (0..row).filter(|i| has(*i)).count())
    }

    /// The footer of a table's file; `None` without a file.
    pub fn footer(&self, table: &str, order: &str) -> Result<Option<ArrowReaderMetadata>, LakeError> {
        let mut footers = self.footers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(footer) = footers.get(table) {
            return Ok(footer.clone());
        }
        let footer = file::open(&self.path(table), order)?.map(|(_, footer)| footer);
        footers.insert(table.to_owned(), footer.clone());
        Ok(footer)
    }

    /// A drive's rows of a table; `None` where no drive of the pack has the table.
    pub fn table(&self, table: &str, order: &str, row: usize) -> Result<Option<Table>, LakeError> {
        let path = self.path(table);
        let Some(footer) = self.footer(table, order)? else { return Ok(None) };
        let group = self.group(table, row);
        if group.is_some_and(|g| g >= footer.metadata().num_row_groups()) {
            return Err(LakeError::broken(&path, "it has fewer row groups than drives.parquet names"));
        }
        let file = File::open(&path).map_err(LakeError::io(&path))?;
        file::read_groups(&path, file, footer, group.into_iter().collect()).map(Some)
    }

    /// All small files of a drive: name and content.
    pub fn notes(&self, row: usize) -> Result<Vec<(String, Vec<u8>)>, LakeError> {
        if self.notes[row] == 0 {
            return Ok(Vec::new());
        }
        let Some(table) = self.table(NOTES, NOTES_ORDER, row)? else {
            return Err(LakeError::broken(&self.path(NOTES), "the file is missing"));
        };
        let contents = table.bytes("content")?;
        Ok(table.texts("name")?.iter().flatten().map(str::to_owned).zip(contents).collect())
    }

    /// The stored signals of all drives that have some; `None` where there are none or they cannot be read.
    pub fn all_signals(&self) -> Option<&SignalFile> {
        let open = || SignalFile::open(&self.dir.join(SIGNALS)).ok().flatten();
        self.signals.get_or_init(open).as_ref()
    }

    /// The stored signals of a drive, of any version.
    pub fn signals(&self, id: &DriveId) -> Option<SignalFile> {
        let all = self.all_signals()?;
        let drive = all.contents().drives.binary_search_by(|d| d.drive_id.cmp(id)).ok()?;
        all.of_drive(drive)
    }
}
