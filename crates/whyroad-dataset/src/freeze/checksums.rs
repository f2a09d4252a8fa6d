//! SHA-256 of files, and the list of them.

use super::manifest::FileEntry;
use crate::DatasetError;
use crate::item::hex;
use crate::release::open_file;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::io::Read;
use std::path::Path;

/// Every file below `dir` as a path with `/`, sorted.
pub(crate) fn files_below(dir: &Path) -> Result<BTreeSet<String>, DatasetError> {
    fn walk(dir: &Path, prefix: &str, out: &mut BTreeSet<String>) -> Result<(), DatasetError> {
        for entry in fs::read_dir(dir).map_err(DatasetError::io(dir))? {
            let entry = entry.map_err(DatasetError::io(dir))?;
            let path = format!("{prefix}{}", entry.file_name().to_string_lossy());
            // A link to a folder is not followed: it may lead out of the release, or in a circle.
            if entry.file_type().map_err(DatasetError::io(&entry.path()))?.is_dir() {
                walk(&entry.path(), &format!("{path}/"), out)?;
            } else {
                out.insert(path);
            }
        }
        Ok(())
    }
    let mut out = BTreeSet::new();
    walk(dir, "", &mut out)?;
    Ok(out)
}

/// Length and SHA-256.
pub(crate) fn sum(path: &Path) -> Result<(u64, String), DatasetError> {
    let mut file = open_file(path)?;
    let (mut hash, mut bytes, mut buffer) = (Sha256::new(), 0, vec![0; 1 << 16]);
    loop {
        let n = file.read(&mut buffer).map_err(DatasetError::io(path))?;
        if n == 0 {
            return Ok((bytes, hex(&hash.finalize())));
        }
        bytes += n as u64;
        hash.update(&buffer[..n]);
    }
}

/// Entries of these files, in their order.
pub(crate) fn entries(dir: &Path, paths: &BTreeSet<String>) -> Result<Vec<FileEntry>, DatasetError> {
    let paths: Vec<&String> = paths.iter().collect();
    paths
        .par_iter()
        .map(|path| {
            let (bytes, sha256) = sum(&dir.join(path))?;
            Ok(FileEntry { path: (*path).clone(), bytes, sha256, samples: None })
        })
        .collect()
}

/// The list as `sha256sum -c` reads it.
pub(crate) fn listing(files: &[FileEntry]) -> String {
    files.iter().map(|f| format!("{}  {}\n", f.sha256, f.path)).collect()
}
