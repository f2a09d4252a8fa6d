//! The work folder `.<name>.partial` beside the output.

use crate::DatasetError;
use crate::aside::partial;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// A work folder, held by one build.
pub(super) struct Work {
    dir: PathBuf,
    /// Locked as long as the build runs; a killed build releases it.
    _lock: File,
}

impl Work {
    /// Opens or makes the folder. If another build is working in it, this one is refused.
    pub fn open(out: &Path) -> Result<Self, DatasetError> {
        let dir = partial(out);
        fs::create_dir_all(&dir).map_err(DatasetError::io(&dir))?;
        let path = dir.join("lock");
        let lock = File::create(&path).map_err(DatasetError::io(&path))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self { dir, _lock: lock }),
            Err(TryLockError::WouldBlock) => Err(DatasetError::Busy(dir)),
            Err(TryLockError::Error(e)) => Err(DatasetError::io(&path)(e)),
        }
    }

    /// Makes it the folder of a build with these inputs; leftovers of another build are refused or discarded.
    pub fn claim(&mut self, key: &str, restart: bool) -> Result<(), DatasetError> {
        let path = self.dir.join("inputs");
        match fs::read_to_string(&path) {
            Ok(found) if found == key => {}
            Ok(_) if !restart => return Err(DatasetError::OtherWork(self.dir.clone())),
            _ => {
                for part in [self.parts(), self.release()] {
                    remove(&part)?;
                }
                fs::write(&path, key).map_err(DatasetError::io(&path))?;
            }
        }
        for dir in [self.parts(), self.release()] {
            fs::create_dir_all(&dir).map_err(DatasetError::io(&dir))?;
        }
        Ok(())
    }

    /// Labels that were read.
    pub fn labels(&self) -> PathBuf {
        self.dir.join("labels.records")
    }

    fn parts(&self) -> PathBuf {
        self.dir.join("parts")
    }

    /// Samples of a drive.
    pub fn samples(&self, drive: usize) -> PathBuf {
        self.parts().join(format!("{drive:06}.records"))
    }

    /// What the later stages need of the samples of a drive; present when all of them are cut.
    pub fn facts(&self, drive: usize) -> PathBuf {
        self.parts().join(format!("{drive:06}.facts"))
    }

    /// The release under construction.
    pub fn release(&self) -> PathBuf {
        self.dir.join("release")
    }

    /// Renames the release into place and removes the rest.
    pub fn publish(self, out: &Path) -> Result<(), DatasetError> {
        if out.exists() {
            return Err(DatasetError::Exists(out.to_owned()));
        }
        fs::rename(self.release(), out).map_err(DatasetError::io(out))?;
        remove(&self.dir)
    }
}

fn remove(dir: &Path) -> Result<(), DatasetError> {
    match fs::remove_dir_all(dir) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(DatasetError::io(dir)(e)),
        _ => Ok(()),
    }
}
