//! `manifest.json`: maps the lake's files to objects.

use crate::LakeError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

pub(super) const KEY: &str = "manifest.json";
const FORMAT: &str = "whyroad-objects";
/// Raised when a reader of the old layout would misread the new one.
const VERSION: u32 = 1;

/// The lake as it is at one moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Manifest {
    /// By path in the lake (`drives/d1/tracks.parquet`).
    pub files: BTreeMap<String, StoredFile>,
    /// Objects that no file uses any more, and since when; readers may still be reading them.
    pub retired: Vec<Retired>,
}

/// A file and its object.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct StoredFile {
    /// Key of the object under the prefix.
    pub key: String,
    /// Length.
    pub bytes: u64,
    /// Hash of the content.
    pub blake3: String,
}

/// An object to be removed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Retired {
    pub key: String,
    /// Seconds since 1970; 0 for what must be removed at once.
    pub at: u64,
}

#[derive(Serialize, Deserialize)]
struct Stored {
    format: String,
    version: u32,
    files: Vec<StoredPath>,
    #[serde(default)]
    retired: Vec<Retired>,
}

/// A list and not a map, so that SQL engines read it as a table.
#[derive(Serialize, Deserialize)]
struct StoredPath {
    path: String,
    #[serde(flatten)]
    file: StoredFile,
}

impl Manifest {
    pub fn parse(text: &[u8], url: &str) -> Result<Self, LakeError> {
        let place = Path::new(url).join(KEY);
        let stored: Stored = serde_json::from_slice(text).map_err(|e| LakeError::broken(&place, e))?;
        if stored.format != FORMAT {
            return Err(LakeError::broken(&place, format!("its format is not '{FORMAT}'")));
        }
        if stored.version != VERSION {
            return Err(LakeError::broken(
                &place,
                format!("its version is {}; this build reads {VERSION}", stored.version),
            ));
        }
        // A path becomes one of this machine.
        let leads_out = |path: &str| path.split('/').any(|part| part.is_empty() || part.starts_with(".."));
        if let Some(bad) = stored.files.iter().find(|f| leads_out(&f.path) || f.path.contains('\\')) {
            return Err(LakeError::broken(&place, format!("'{}' is not a path in a lake", bad.path)));
        }
        let files = stored.files.into_iter().map(|f| (f.path, f.file)).collect();
        Ok(Self { files, retired: stored.retired })
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        let paths =
            self.files.iter().map(|(path, file)| StoredPath { path: path.clone(), file: file.clone() });
        let stored = Stored {
            format: FORMAT.to_owned(),
            version: VERSION,
            files: paths.collect(),
            retired: self.retired.clone(),
        };
        serde_json::to_vec(&stored).unwrap_or_default()
    }

    /// The files whose path has this prefix.
    pub fn below<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = (&'a String, &'a StoredFile)> {
        self.files.range(prefix.to_owned()..).take_while(move |(path, _)| path.starts_with(prefix))
    }
}

/// A unit of change: a drive, all packs, or a single file.
pub(super) fn unit(path: &str) -> &str {
    if path.starts_with("packs/") {
        return "packs";
    }
    match path.strip_prefix("drives/").and_then(|rest| rest.find('/')) {
        Some(at) => &path[..at + "drives/".len()],
        None => path,
    }
}

/// The folder whose absence means that all of its files are removed; `None` for a file of the lake itself.
pub(super) fn folder(path: &str) -> Option<&str> {
    let first = path.find('/')?;
    let second = path[first + 1..].find('/')?;
    Some(&path[..first + 1 + second])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again_and_no_path_leads_out() {
        let file = StoredFile { key: "drives/d1/t.parquet".into(), bytes: 3, blake3: "ab".into() };
        let manifest = Manifest {
            files: BTreeMap::from([("drives/d1/tracks.parquet".into(), file)]),
            retired: vec![Retired { key: "x".into(), at: 7 }],
        };
        let text = manifest.to_bytes();
        assert_eq!(Manifest::parse(&text, "s3://b/p").unwrap(), manifest);
        let text = String::from_utf8(text).unwrap();
        for bad in ["../../etc/passwd", "/etc/passwd", "drives//x", "drives/..", r"drives\\..\\x"] {
            let changed = text.replace("drives/d1/tracks.parquet", bad);
            assert!(Manifest::parse(changed.as_bytes(), "s3://b/p").is_err(), "{bad}");
        }
        assert!(
            Manifest::parse(text.replace("\"version\":1", "\"version\":2").as_bytes(), "s3://b/p").is_err()
        );
    }

    #[test]
    fn a_drive_is_one_unit_and_so_are_all_packs() {
        assert_eq!(unit("drives/d1/signals/frames.parquet"), "drives/d1");
        assert_eq!(unit("packs/00000001/tracks.parquet"), unit("packs/catalogue.parquet"));
        assert_eq!(unit("whyroad-lake.json"), "whyroad-lake.json");
        assert_eq!(folder("packs/00000001/tracks.parquet"), Some("packs/00000001"));
        assert_eq!(folder("drives/d1/signals/frames.parquet"), Some("drives/d1"));
        assert_eq!((folder("packs/catalogue.parquet"), folder("whyroad-lake.json")), (None, None));
    }
}
