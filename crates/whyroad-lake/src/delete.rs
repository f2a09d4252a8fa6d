//! Removing a drive from a lake: its tables, stored signals, findings and copied camera images.

use crate::lake::remove_dir;
use crate::{Lake, LakeError, leftovers, packs};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use whyroad_model::DriveId;

impl Lake {
    /// True where the lake holds anything of the drive, including leftovers of a killed process.
    pub fn holds(&self, id: &DriveId) -> bool {
        self.folders_of(id).is_ok_and(|folders| !folders.is_empty())
            || self.last_catalog().find(id).is_some()
            || self.mirror.as_ref().is_some_and(|m| m.has_images(id.as_str()).unwrap_or(false))
    }

    /// [`Lake::remove_drive`] of several drives: each pack that holds some of them is written again once.
    ///
    /// # Errors
    /// As [`Lake::remove_drive`].
    pub fn remove_drives(&self, ids: &BTreeSet<DriveId>) -> Result<(), LakeError> {
        for id in ids {
            self.checked_dir(id)?;
        }
        // First: without its folder, a replaced drive would be seen as its pack still has it.
        self.unpack_away(ids)?;
        if let Some(mirror) = &self.mirror {
            ids.iter().for_each(|id| mirror.forget_images(id.as_str()));
        }
        ids.iter().try_for_each(|id| self.remove_folders(id))
    }

    /// Removes the drive. Readers find all of it or none; a killed removal is finished by the next one.
    ///
    /// # Errors
    /// Where a folder cannot be removed, or the id is not one that a drive can have.
    pub fn remove_drive(&self, id: &DriveId) -> Result<(), LakeError> {
        self.remove_drives(&BTreeSet::from([id.clone()]))
    }

    fn remove_folders(&self, id: &DriveId) -> Result<(), LakeError> {
        let dir = self.checked_dir(id)?;
        if dir.exists() {
            let gone = self.aside(id, "gone")?;
            remove_dir(&gone)?;
            let _lock = packs::replacing(self.dir())?;
            fs::rename(&dir, &gone).map_err(LakeError::io(&dir))?;
        }
        for path in self.folders_of(id)? {
            let removed = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            removed.map_err(LakeError::io(&path))?;
        }
        Ok(())
    }

    /// The drive's folder, its images, and temporary folders of processes for it (`.new-<pid>-<id>` and the like).
    fn folders_of(&self, id: &DriveId) -> Result<Vec<PathBuf>, LakeError> {
        let dir = self.checked_dir(id)?;
        let aside = |name: &str| {
            let parts = name.strip_prefix('.').and_then(|n| n.strip_suffix(id.as_str())?.strip_suffix('-'));
            parts.and_then(|p| p.rsplit_once('-')).is_some_and(|(_, pid)| pid.parse::<u32>().is_ok())
        };
        let mut found = Vec::new();
        for folder in leftovers::FOLDERS.map(|name| self.dir().join(name)) {
            let entries = match fs::read_dir(&folder) {
                Err(e) if e.kind() == std::io::ErrorKind::NotFound => continue,
                entries => entries.map_err(LakeError::io(&folder))?.flatten(),
            };
            found.extend(entries.filter(|e| aside(&e.file_name().to_string_lossy())).map(|e| e.path()));
        }
        found.extend([dir, self.media_dir().join(id.as_str())].into_iter().filter(|p| p.exists()));
        found.sort();
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_of_the_drive_goes_and_nothing_of_another() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        let at = |p: &str| dir.path().join(p);
        let gone = [
            "drives/d1",
            "unfinished/.new-7-d1",
            "unfinished/.found.json-8-d1",
            "drives/.gone-9-d1",
            "media/d1",
        ];
        let kept = ["drives/d11", "drives/x-d1", "unfinished/.new-7-x-d1", "drives/.new-7-d11", "media/d11"];
        for path in gone.iter().chain(&kept) {
            fs::create_dir_all(at(path)).unwrap();
            fs::write(at(path).join("t"), "x").unwrap();
        }
        assert!(lake.holds(&"d1".into()) && !lake.holds(&"d2".into()));
        lake.remove_drive(&"d1".into()).unwrap();
        assert!(gone.iter().all(|p| !at(p).exists()) && kept.iter().all(|p| at(p).exists()));
        assert!(!lake.holds(&"d1".into()));
        lake.remove_drive(&"d1".into()).unwrap();
        for outside in ["..", "../x", ""] {
            assert!(lake.remove_drive(&outside.into()).is_err(), "{outside}");
        }
        assert!(kept.iter().all(|p| at(p).exists()));
    }
}
