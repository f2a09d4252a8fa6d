//! `packs/catalogue.parquet`: one row per packed drive, sorted by id, with what a listing, a plan or a filter needs, so
//! that none of them opens a pack. A row group has 65,536 drives; its statistics let a query skip it.

use super::fingerprint;
use crate::columns::{Table, TableBuilder};
use crate::{LakeError, file};
use arrow_array::cast::AsArray;
use arrow_array::{Array, StringArray};
use parquet::file::metadata::KeyValue;
use std::fs::File;
use std::path::Path;
use whyroad_model::{DriveId, Nanos};

pub(super) const FILE: &str = "catalogue.parquet";
const ROW_ORDER: &str = "drive";
const NEXT: &str = "whyroad.next_pack";
const DRIVES_PER_ROW_GROUP: usize = 65_536;

/// A drive as shown in a listing.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct DriveEntry {
    /// The drive.
    pub drive_id: DriveId,
    /// Its pack; `None` for a drive with a folder of its own.
    pub pack: Option<String>,
    /// Which drive of the pack it is.
    pub row: u32,
    /// Hash of the content from which the drive was made; empty where that is unknown.
    pub content_hash: String,
    /// Format of the log.
    pub format: String,
    /// City or road network.
    pub place: Option<String>,
    /// License of the data.
    pub licence: Option<String>,
    /// Recording session.
    pub session: Option<String>,
    /// Vehicle.
    pub vehicle: Option<String>,
    /// Whether the log states its date; without one, `start` and `end` count from an invented start. `None` in
    /// catalogs of earlier versions (see [`crate::Lake::is_dated`]).
    pub dated: Option<bool>,
    /// Time of the first frame.
    pub start: Nanos,
    /// Time of the last frame.
    pub end: Nanos,
    /// Frames.
    pub frames: u64,
    /// Rows of the tracks table: one per object and frame.
    pub object_rows: u64,
    /// Bytes of its row groups in the pack, or of its folder.
    pub bytes: u64,
}

/// A catalog in memory, in columns: a million drives take some 200 MB.
#[derive(Debug)]
pub(crate) struct Catalog {
    /// Of the file from which it was read.
    pub identity: String,
    /// Number of the next pack; a number is never used twice.
    pub next_pack: u64,
    table: Option<Table>,
    numbers: Numbers,
}

#[derive(Debug, Default)]
struct Numbers {
    rows: Vec<u32>,
    dated: Vec<Option<bool>>,
    starts: Vec<i64>,
    ends: Vec<i64>,
    frames: Vec<i64>,
    object_rows: Vec<i64>,
    bytes: Vec<i64>,
}

impl Default for Catalog {
    fn default() -> Self {
        Self { identity: String::new(), next_pack: 1, table: None, numbers: Numbers::default() }
    }
}

impl Catalog {
    /// Reads the file; a lake without one has no packed drive.
    pub fn read(path: &Path) -> Result<Self, LakeError> {
        // Taken first, so it is never newer than the data read.
        let identity = fingerprint::identity(path);
        let Some((file, footer)) = file::open(path, ROW_ORDER)? else { return Ok(Self::default()) };
        let next = file::stated(&footer, NEXT).and_then(|n| n.parse().ok());
        let next_pack = next.ok_or_else(|| LakeError::broken(path, format!("'{NEXT}' is missing")))?;
        let groups = (0..footer.metadata().num_row_groups()).collect();
        let table = file::read_groups(path, file, footer, groups)?;
        for name in ["drive_id", "pack", "content_hash", "format"] {
            table.texts(name)?;
        }
        for name in ["place", "licence", "session", "vehicle"] {
            table.texts_or_null(name)?;
        }
        let numbers = Numbers {
            rows: table.indices("row")?,
            // Earlier versions wrote no such column.
            dated: if table.has("dated") { table.flags("dated")? } else { vec![None; table.rows()] },
            starts: table.integers("start_ns")?,
            ends: table.integers("end_ns")?,
            frames: table.integers("frames")?,
            object_rows: table.integers("object_rows")?,
            bytes: table.integers("bytes")?,
        };
        let ids = table.texts("drive_id")?;
        if let Some(row) = (1..ids.len()).find(|i| ids.value(i - 1) >= ids.value(*i)) {
            return Err(LakeError::RowOrder { path: path.to_owned(), row });
        }
        Ok(Self { identity, next_pack, table: Some(table), numbers })
    }

    /// Writes a catalog to a temporary file and moves it into place by one rename.
    pub fn publish(dir: &Path, entries: &[DriveEntry], next_pack: u64) -> Result<(), LakeError> {
        let whole = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
        let all = || entries.iter();
        let table = TableBuilder::default()
            .texts("drive_id", all().map(|e| e.drive_id.as_str()))
            .texts("pack", all().map(|e| e.pack.as_deref().unwrap_or_default()))
            .indices("row", all().map(|e| e.row))
            .texts("content_hash", all().map(|e| &e.content_hash))
            .texts("format", all().map(|e| &e.format))
            .texts_or_null("place", all().map(|e| e.place.as_ref()))
            .texts_or_null("licence", all().map(|e| e.licence.as_ref()))
            .texts_or_null("session", all().map(|e| e.session.as_ref()))
            .texts_or_null("vehicle", all().map(|e| e.vehicle.as_ref()))
            .flags("dated", all().map(|e| e.dated))
            .integers("start_ns", all().map(|e| e.start.0))
            .integers("end_ns", all().map(|e| e.end.0))
            .integers("frames", all().map(|e| whole(e.frames)))
            .integers("object_rows", all().map(|e| whole(e.object_rows)))
            .integers("bytes", all().map(|e| whole(e.bytes)));
        let (path, fresh) = (dir.join(FILE), dir.join(format!(".{FILE}-{}", std::process::id())));
        let batch = table.finish().map_err(|e| LakeError::broken(&path, e))?;
        let properties =
            file::properties(ROW_ORDER, vec![KeyValue::new(NEXT.to_owned(), next_pack.to_string())])
                .set_max_row_group_row_count(Some(DRIVES_PER_ROW_GROUP))
                .build();
        file::write_batches(&fresh, &batch.schema(), [&batch], properties)?;
        std::fs::rename(&fresh, &path).map_err(LakeError::io(&path))?;
        sync_folder(dir)
    }

    /// Number of drives.
    pub fn len(&self) -> usize {
        self.numbers.rows.len()
    }

    fn text(&self, name: &str) -> Option<&StringArray> {
        self.table.as_ref()?.batch.column_by_name(name)?.as_string_opt()
    }

    /// Ids, sorted.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.text("drive_id").into_iter().flat_map(|ids| ids.iter().flatten())
    }

    /// Position of a drive.
    pub fn find(&self, id: &DriveId) -> Option<usize> {
        let ids = self.text("drive_id")?;
        let (mut low, mut high) = (0, ids.len());
        while low < high {
            let middle = low + (high - low) / 2;
            match ids.value(middle).cmp(id.as_str()) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some(middle),
            }
        }
        None
    }

    /// Pack of the drive at a position, and which drive of the pack it is.
    pub fn location(&self, at: usize) -> (&str, usize) {
        (self.text("pack").map_or("", |t| t.value(at)), self.numbers.rows[at] as usize)
    }

    /// Hash, frames and rows of objects of the drive at a position.
    pub fn size(&self, at: usize) -> (&str, u64, u64) {
        let number = |n: i64| u64::try_from(n).unwrap_or(0);
        let hash = self.text("content_hash").map_or("", |t| t.value(at));
        (hash, number(self.numbers.frames[at]), number(self.numbers.object_rows[at]))
    }

    /// All of a row.
    pub fn entry(&self, at: usize) -> DriveEntry {
        let text = |name: &str| self.text(name).map_or_else(String::new, |t| t.value(at).to_owned());
        let maybe = |name: &str| self.text(name).filter(|t| t.is_valid(at)).map(|t| t.value(at).to_owned());
        let (_, frames, object_rows) = self.size(at);
        DriveEntry {
            drive_id: DriveId(text("drive_id")),
            pack: Some(text("pack")),
            row: self.numbers.rows[at],
            content_hash: text("content_hash"),
            format: text("format"),
            place: maybe("place"),
            licence: maybe("licence"),
            session: maybe("session"),
            vehicle: maybe("vehicle"),
            dated: self.numbers.dated[at],
            start: Nanos(self.numbers.starts[at]),
            end: Nanos(self.numbers.ends[at]),
            frames,
            object_rows,
            bytes: u64::try_from(self.numbers.bytes[at]).unwrap_or(0),
        }
    }
}

/// Makes a rename in a folder outlast a power failure.
pub(super) fn sync_folder(dir: &Path) -> Result<(), LakeError> {
    if !cfg!(unix) {
        return Ok(());
    }
    File::open(dir).and_then(|f| f.sync_all()).map_err(LakeError::io(dir))
}
