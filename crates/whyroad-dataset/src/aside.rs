//! Folders that are written beside their final path and renamed to it when complete.

use crate::DatasetError;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// `.<name>.partial` beside `out`.
pub(crate) fn partial(out: &Path) -> PathBuf {
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    out.with_file_name(format!(".{name}.partial"))
}

/// The same, without leftovers of an earlier run.
///
/// # Errors
/// When the old folder cannot be removed.
pub(crate) fn empty_partial(out: &Path) -> Result<PathBuf, DatasetError> {
    let aside = partial(out);
    match fs::remove_dir_all(&aside) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(DatasetError::io(&aside)(e)),
        _ => Ok(aside),
    }
}
