//! Camera pictures of a drive that is in the lake already: what its `media` table names, and another table in its
//! place.

use crate::lake::{Lake, MANIFEST, write_json};
use crate::tables::states;
use crate::{LakeError, file, packs};
use std::fs;
use whyroad_model::scene::MediaFrame;
use whyroad_model::{DriveId, Need};

/// The name that adapters use for missing images (`drive.json`, `missing`).
const NO_PICTURES: Need = Need::CameraPictures;
const TABLE: &str = "media";

impl Lake {
    /// Camera frames of a drive; none where the table is missing.
    pub fn media(&self, id: &DriveId) -> Result<Vec<MediaFrame>, LakeError> {
        self.at_place(id, |place| {
            self.current(id, place)?;
            // By the file and not by what drive.json names: a replacement that was killed leaves the old frames in
            // the file.
            let table = Self::table(place, TABLE, states::MEDIA_ORDER)?;
            table.map_or(Ok(vec![]), |t| states::media_from_table(&t))
        })
    }

    /// Replaces the drive's camera frames with `frames`, sorted by camera, then time. The drive stays readable if this
    /// is killed: until the next call it has no images, and that call still has the old ones.
    pub fn write_media(&self, id: &DriveId, frames: &[MediaFrame]) -> Result<(), LakeError> {
        self.unpack(id)?;
        let mut manifest = self.manifest(id)?;
        let mut sorted = frames.to_vec();
        sorted.sort_by(|a, b| (&a.camera, a.time).cmp(&(&b.camera, b.time)));
        let (target, fresh) = (self.drive_dir(id).join("media.parquet"), self.aside(id, "media.parquet")?);
        let rows = file::write_table(&fresh, states::media_to_table(&sorted), states::MEDIA_ORDER)
            .inspect_err(|_| {
                // The error that made it fail is the one to report.
                let _ = fs::remove_file(&fresh);
            })?;
        let state = |manifest: &crate::manifest::DriveManifest| {
            let aside = self.aside(id, MANIFEST)?;
            write_json(&aside, manifest)?;
            let path = self.drive_dir(id).join(MANIFEST);
            fs::rename(&aside, &path).map_err(LakeError::io(&path))
        };
        let _lock = packs::changing(self.dir())?;
        // Table and manifest must agree on the number of rows and cannot be renamed as one: in between, no table is
        // named.
        if manifest.tables.remove(TABLE).is_some() {
            state(&manifest)?;
        }
        fs::rename(&fresh, &target).map_err(LakeError::io(&target))?;
        manifest.tables.insert(TABLE.to_owned(), rows);
        manifest.meta.missing.retain(|need| *need != NO_PICTURES);
        state(&manifest)
    }
}
