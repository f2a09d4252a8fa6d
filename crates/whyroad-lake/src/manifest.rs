//! `drive.json`: what a drive states about itself that is not a table. Also the lake's own `whyroad-lake.json`.

use crate::{DriveEntry, LakeError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use whyroad_model::scene::DriveMeta;
use whyroad_model::{DriveId, Nanos};

/// Its name.
pub(crate) const MANIFEST: &str = "drive.json";

/// True for the folder of a loose drive: it has a `drive.json`. So does one that cannot be read, whose `drive.json` is
/// missing beside its tables, or that is a link to nowhere: such a drive is reported, and does not just disappear.
pub(crate) fn is_drive(dir: &Path) -> bool {
    use std::io::ErrorKind::{NotADirectory, NotFound};
    match fs::metadata(dir.join(MANIFEST)) {
        Ok(data) => data.is_file(),
        Err(e) if e.kind() == NotFound => {
            dir.join("frames.parquet").exists() || (dir.is_symlink() && !dir.exists())
        }
        Err(e) => e.kind() != NotADirectory,
    }
}

/// `whyroad-lake.json`.
#[derive(Serialize, Deserialize)]
pub(crate) struct LakeMarker {
    pub format: String,
    pub version: u32,
}

/// `drive.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DriveManifest {
    pub lake_version: u32,
    pub meta: DriveMeta,
    pub frames: usize,
    /// Rows of each table; a table that is not listed here is missing in the log.
    pub tables: BTreeMap<String, usize>,
}

impl DriveManifest {
    /// What a listing says about the drive as far as this file knows it: no pack, no bytes.
    pub fn entry(&self, start: Nanos, end: Nanos) -> DriveEntry {
        let rows = |n: usize| u64::try_from(n).unwrap_or(u64::MAX);
        let meta = &self.meta;
        DriveEntry {
            drive_id: meta.drive_id.clone(),
            pack: None,
            row: 0,
            content_hash: meta.content_hash.clone(),
            format: meta.format.clone(),
            place: meta.place.clone(),
            licence: meta.licence.clone(),
            session: meta.session.clone(),
            vehicle: meta.vehicle.clone(),
            dated: Some(meta.is_dated()),
            start,
            end,
            frames: rows(self.frames),
            object_rows: rows(self.tables.get("tracks").copied().unwrap_or(0)),
            bytes: 0,
        }
    }

    /// Reads the file of any version.
    pub fn read(path: &Path, id: &DriveId) -> Result<Self, LakeError> {
        let text = match fs::read_to_string(path) {
            Ok(t) => t,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return Err(match path.parent() {
                    Some(dir) if is_drive(dir) => LakeError::broken(path, "the file is missing"),
                    _ => LakeError::DriveMissing(id.clone()),
                });
            }
            Err(e) => return Err(LakeError::io(path)(e)),
        };
        serde_json::from_str(&text).map_err(|e| LakeError::broken(path, e))
    }
}
