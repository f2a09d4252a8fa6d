//! Which changes may run at the same time: writers of drives share the lake, and only moving a drive's folder away
//! excludes them; compaction and deletion of packed drives exclude each other. Readers take no lock.

use crate::LakeError;
use std::fs::File;
use std::path::Path;

/// `EBADF`.
const BAD_DESCRIPTOR: i32 = 9;

/// Held while a folder or file of a drive is moved into place.
pub(crate) fn changing(lake: &Path) -> Result<Option<File>, LakeError> {
    held(&lake.join("drives"), File::lock_shared)
}

/// Held while a drive's folder is compared, and moved away or replaced.
pub(crate) fn replacing(lake: &Path) -> Result<Option<File>, LakeError> {
    held(&lake.join("drives"), File::lock)
}

/// Held while packs are written and published.
pub(super) fn packing(lake: &Path) -> Result<Option<File>, LakeError> {
    held(&lake.join(super::FOLDER), File::lock)
}

/// A lock on a folder; it ends when the file is closed. Without one where folders cannot be opened: there, one process
/// at a time must write.
fn held(folder: &Path, lock: fn(&File) -> std::io::Result<()>) -> Result<Option<File>, LakeError> {
    if !cfg!(unix) {
        return Ok(None);
    }
    let file = File::open(folder).map_err(LakeError::io(folder))?;
    match lock(&file) {
        Ok(()) => Ok(Some(file)),
        // Some network file systems lock only files that are open for writing, which a folder cannot be.
        Err(e) if e.kind() == std::io::ErrorKind::Unsupported || e.raw_os_error() == Some(BAD_DESCRIPTOR) => {
            Ok(None)
        }
        Err(e) => Err(LakeError::io(folder)(e)),
    }
}
