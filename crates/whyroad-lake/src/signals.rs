//! Signal tables on disk: what was derived from a drive, kept so that it is derived once. Two Parquet files, `frames`
//! (one row per frame) and `targets` (one row per object and frame), plain enough for SQL; only the columns asked for
//! are read.
//!
//! Invariants, recorded in the files and checked on reading: a row group holds a whole drive, its rows in the
//! order of target, then frame, without a hole; `whyroad.signals` in the metadata of `frames` names the drive's
//! content, the version of the signals, the objects with their frames, and the words of each category; in that of
//! `targets` it is the hash of that text.
//!
//! Numbers are 64 bits wide as they were derived: a value exactly on a rule's threshold stays on its side, so results
//! are the same with and without stored signals. Flags are bits, categories at most one byte per row (dictionary).
//! Unknown is null on disk.

pub(crate) mod bitmap;
mod column;
mod encodings;
mod equal;
pub(crate) mod pages;
mod read;
mod steps;
mod table;
mod write;

pub use column::StoredColumn;
pub use read::{Range, SignalFile, TableKind};
pub use write::write_signals;

use crate::LakeError;
use bytes::Bytes;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::path::Path;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{DriveId, FrameRange, Need, ObjectClass, TrackId};

/// Order of the rows, as the files' metadata state it.
pub(crate) const ROW_ORDER: &str = "drive, target, frame";
pub(crate) const KEY: &str = "whyroad.signals";

/// What `targets` states instead of the text of `frames`: it is long, and mostly the same for every drive.
pub(crate) fn digest(contents: &str) -> String {
    format!("blake3:{}", &blake3::hash(contents.as_bytes()).to_hex()[..32])
}

/// Contents of one of the two files of a store, from bytes in memory: the text of the contents can be read, or is a
/// hash. The number of columns that can be read.
pub(crate) fn read_bytes(bytes: &[u8]) -> Result<usize, LakeError> {
    let path = Path::new("memory");
    let (mut table, contents) = table::Table::of(path, &Bytes::copy_from_slice(bytes))?;
    if let Ok(contents) = serde_json::from_str::<Contents>(&contents) {
        table.divide(&contents.drives.iter().map(|drive| drive.frames).collect::<Vec<_>>());
        let rows = contents.drives.iter().map(StoredDrive::target_rows);
        table.divide(&rows.collect::<Vec<_>>());
    }
    Ok(table.read_all(&mut Cursor::new(bytes)).len())
}

/// Columns before the signals: object and time.
pub(crate) const FRAME: &str = "frame";
pub(crate) const TIME: &str = "time_ns";

/// What the files of one store state about themselves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contents {
    /// Version of what derived the signals.
    pub version: String,
    /// The drives, a row group each.
    pub drives: Vec<StoredDrive>,
}

/// One drive in a store.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredDrive {
    /// The drive.
    pub drive_id: DriveId,
    /// Content hash of the scene tables from which the signals were derived.
    pub content_hash: String,
    /// Number of frames.
    pub frames: usize,
    /// The objects, each with the rows that it has in the targets' row group.
    #[serde(with = "spans")]
    pub targets: Vec<TargetSpan>,
    /// Signals that the log cannot support, with what it would need.
    pub unavailable: BTreeMap<String, Vec<Need>>,
    /// Signals that are known only where other data proves them, with what the log would need.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub partial: BTreeMap<String, Vec<Need>>,
    /// Classes of objects of which no box is known.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub without_boxes: BTreeSet<ObjectClass>,
    /// The words of each category signal, in the order of their codes.
    pub words: BTreeMap<String, Vec<String>>,
    /// Columns that other drives of the same files have and this one lacks, although they are not unavailable.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absent: Vec<String>,
    /// Version of what derived the signals of this drive, where it is not that of the files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
}

impl StoredDrive {
    /// Rows of the targets' row group.
    pub fn target_rows(&self) -> usize {
        self.targets.iter().map(|t| t.frames.len()).sum()
    }

    /// True for a signal that the drive does not have, regardless of the columns of the files.
    pub(crate) fn lacks(&self, signal: &str) -> bool {
        self.unavailable.contains_key(signal) || self.absent.iter().any(|name| name == signal)
    }
}

/// Objects as the files state them: where their rows begin follows from their order.
mod spans {
    use super::{FrameRange, ObjectClass, TargetSpan, TrackId};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Stated {
        id: TrackId,
        class: ObjectClass,
        first: usize,
        end: usize,
    }

    pub fn serialize<S: Serializer>(spans: &[TargetSpan], to: S) -> Result<S::Ok, S::Error> {
        let stated = |t: &TargetSpan| {
            let (id, frames) = (t.id.clone(), t.frames);
            Stated { id, class: t.class, first: frames.start, end: frames.end }
        };
        spans.iter().map(stated).collect::<Vec<_>>().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<TargetSpan>, D::Error> {
        let stated = Vec::<Stated>::deserialize(from)?;
        let mut first_row = 0;
        let span = |t: Stated| {
            let frames = FrameRange::new(t.first, t.end);
            let span = TargetSpan { id: t.id, class: t.class, first_row, frames };
            first_row += frames.len();
            span
        };
        Ok(stated.into_iter().map(span).collect())
    }
}
