//! A packed drive as a folder of its own again, for changes of its tables.

use super::Place;
use crate::lake::write_tables;
use crate::signals::write_signals;
use crate::{Lake, LakeError};
use std::fs;
use whyroad_model::DriveId;

impl Lake {
    /// Makes a drive loose, with its stored signals and small files; a loose drive is left unchanged. Readers find the
    /// drive at every moment.
    pub(crate) fn unpack(&self, id: &DriveId) -> Result<(), LakeError> {
        if matches!(self.place(id)?, Place::Loose(_)) {
            return Ok(());
        }
        let drive = self.read_drive(id)?;
        let fresh = self.aside(id, "new")?;
        crate::lake::remove_dir(&fresh)?;
        fs::create_dir_all(&fresh).map_err(LakeError::io(&fresh))?;
        write_tables(&fresh, &drive, drive.meta.clone())?;
        self.at_place(id, |place| {
            let Place::Packed(pack, row) = place else { return Ok(()) };
            for (name, content) in pack.notes(*row)? {
                let path = fresh.join(name);
                fs::write(&path, content).map_err(LakeError::io(&path))?;
            }
            let Some(file) = pack.signals(id) else { return Ok(()) };
            let (stored, dir) = (&file.contents().drives[0], fresh.join("signals"));
            fs::create_dir_all(&dir).map_err(LakeError::io(&dir))?;
            write_signals(
                &dir,
                &file.contents().version,
                &[(stored.content_hash.clone(), &file.read_table(0)?)],
            )
        })?;
        let _lock = super::replacing(self.dir())?;
        let target = self.drive_dir(id);
        // The overriding files are newer than those in the pack.
        for entry in fs::read_dir(&target).into_iter().flatten().flatten() {
            let to = fresh.join(entry.file_name());
            if to.is_dir() {
                crate::lake::remove_dir(&to)?;
            }
            fs::rename(entry.path(), &to).map_err(LakeError::io(&to))?;
        }
        crate::lake::remove_dir(&target)?;
        fs::rename(&fresh, &target).map_err(LakeError::io(&target))
    }
}
