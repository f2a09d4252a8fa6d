//! The drives of a lake as a list: of packed ones from the catalog, of the others from their `drive.json` and the
//! footer of their frames.

use crate::lake::Lake;
use crate::packs::{DriveEntry, Place};
use crate::tables::frames;
use crate::{LakeError, file};
use whyroad_model::DriveId;

impl Lake {
    /// A row for each drive, sorted by id; a drive that cannot be read is an error of its own.
    pub fn entries(&self) -> impl Iterator<Item = (DriveId, Result<DriveEntry, LakeError>)> + '_ {
        let catalog = self.last_catalog();
        self.drive_ids().into_iter().map(move |id| {
            let packed = catalog.find(&id).filter(|_| !self.is_loose(&id));
            let entry = packed.map_or_else(|| self.entry(&id), |at| Ok(catalog.entry(at)));
            (id, entry)
        })
    }

    /// The row of one drive.
    ///
    /// # Errors
    /// Where the drive is missing or cannot be read.
    pub fn entry(&self, id: &DriveId) -> Result<DriveEntry, LakeError> {
        let Some(mirror) = &self.mirror else { return self.at_place(id, |place| self.entry_at(id, place)) };
        // A listing fetches one small table of a drive, not the whole drive.
        let folder = format!("drives/{id}");
        self.checked_dir(id)?;
        mirror.fetch_files(&folder, |name| name == "frames.parquet")?;
        let entry = self.entry_at(id, &self.place_as_it_is(id)?)?;
        let bytes = if entry.pack.is_none() { mirror.bytes(&folder) } else { entry.bytes };
        Ok(DriveEntry { bytes, ..entry })
    }

    /// Whether the log of a listed drive states its date.
    ///
    /// # Errors
    /// Where only the drive itself knows, and it is missing or cannot be read.
    pub fn is_dated(&self, entry: &DriveEntry) -> Result<bool, LakeError> {
        entry.dated.map_or_else(|| Ok(self.manifest(&entry.drive_id)?.meta.is_dated()), Ok)
    }

    fn entry_at(&self, id: &DriveId, place: &Place) -> Result<DriveEntry, LakeError> {
        let Place::Loose(dir) = place else {
            let catalog = self.catalog()?;
            let at = catalog.find(id).ok_or_else(|| LakeError::DriveMissing(id.clone()))?;
            return Ok(catalog.entry(at));
        };
        let manifest = self.current(id, place)?;
        let path = dir.join("frames.parquet");
        let (_, footer) = file::open(&path, frames::ROW_ORDER)?
            .ok_or_else(|| LakeError::broken(&path, "the file is missing"))?;
        let (start, end) = file::span(&path, footer.metadata(), Some(0))?;
        Ok(DriveEntry { bytes: size_of(dir), ..manifest.entry(start, end) })
    }
}

/// Bytes of the files directly in a folder and in its folders.
fn size_of(dir: &std::path::Path) -> u64 {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    entries
        .map(|e| if e.path().is_dir() { size_of(&e.path()) } else { e.metadata().map_or(0, |m| m.len()) })
        .sum()
}
