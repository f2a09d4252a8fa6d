//! How large a drive is, from the catalog or its `drive.json` alone: used to plan several workers.

use crate::{Lake, LakeError};
use whyroad_model::DriveId;

/// A drive's size and content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriveSize {
    /// Hash of the content from which the drive was made; empty where the drive does not state it.
    pub content_hash: String,
    /// Frames.
    pub frames: u64,
    /// Rows of the tracks table: one per object and frame.
    pub object_rows: u64,
}

impl Lake {
    /// The size of a drive; no table is opened.
    pub fn size(&self, id: &DriveId) -> Result<DriveSize, LakeError> {
        // For a packed drive the catalog is enough.
        self.checked_dir(id)?;
        if !self.is_loose(id)
            && let Some((hash, frames, object_rows)) = self.packed_size(id)
        {
            return Ok(DriveSize { content_hash: hash, frames, object_rows });
        }
        let manifest = self.manifest(id)?;
        let rows = |n: usize| u64::try_from(n).unwrap_or(u64::MAX);
        Ok(DriveSize {
            frames: rows(manifest.frames),
            object_rows: rows(manifest.tables.get("tracks").copied().unwrap_or(0)),
            content_hash: manifest.meta.content_hash,
        })
    }

    fn packed_size(&self, id: &DriveId) -> Option<(String, u64, u64)> {
        let catalog = self.catalog().ok()?;
        let (hash, frames, object_rows) = catalog.size(catalog.find(id)?);
        Some((hash.to_owned(), frames, object_rows))
    }
}
