//! Whether a drive is still the one that was mined, without opening it: where it is, and the identity of its files.
//!
//! In a folder, a file's identity is its length, its time of change and its number in the file system; in an object
//! store, the hash of its content, which the manifest of the lake states. Files that commands keep beside a drive
//! (stored signals, results) are not checked: they follow from the tables.

use crate::lake::MANIFEST;
use crate::packs::{self, DRIVES_FILE, fingerprint};
use crate::tables::SCENE;
use crate::{Lake, LakeError};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use whyroad_model::DriveId;

/// A drive on disk as it was at one moment.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    /// Its pack and which drive of the pack it is; empty for a drive with a folder of its own.
    pub place: String,
    /// Identity of what the drive states about itself: `drive.json`, or `drives.parquet` of its pack.
    pub head: String,
    /// Identities of its tables, or of those of its pack, hashed.
    pub tables: String,
}

/// The fingerprints of a lake's drives: what they have in common is read once.
pub struct Fingerprints<'a> {
    lake: &'a Lake,
    /// Names in the folder of loose drives.
    folders: BTreeSet<String>,
    catalog: packs::CatalogRef,
    /// Of each pack: identity of `drives.parquet` and of the tables.
    packs: BTreeMap<String, (String, String)>,
}

impl Lake {
    /// Reads what the fingerprints of drives have in common.
    pub fn fingerprints(&self) -> Fingerprints<'_> {
        let names = fs::read_dir(self.dir().join("drives")).into_iter().flatten().flatten();
        // Before the catalog: a drive that is being packed is in the catalog before its folder is gone.
        let folders = names.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        let catalog = self.last_catalog();
        let mut packs = BTreeMap::new();
        for at in 0..catalog.len() {
            let (pack, _) = catalog.location(at);
            if !packs.contains_key(pack) {
                let below = format!("{}/{pack}", packs::FOLDER);
                let head = self.identity(&format!("{below}/{DRIVES_FILE}"));
                packs.insert(pack.to_owned(), (head, self.tables(&below)));
            }
        }
        Fingerprints { lake: self, folders, catalog, packs }
    }

    /// Hash of what a drive states about itself, wherever it is; `None` where it cannot be read, or does not state the
    /// hash of its content: then equal content cannot be established.
    pub fn stated(&self, id: &DriveId) -> Option<String> {
        let manifest = self.manifest(id).ok().filter(|m| !m.meta.content_hash.is_empty())?;
        let text = serde_json::to_vec(&manifest).ok()?;
        Some(short(&text))
    }

    /// Identity of a file by its path in the lake.
    fn identity(&self, path: &str) -> String {
        match &self.mirror {
            Some(mirror) => mirror.content(path).unwrap_or_default(),
            None => fingerprint::identity(&self.dir().join(path)),
        }
    }

    fn tables(&self, folder: &str) -> String {
        let all = SCENE.map(|(table, _)| self.identity(&format!("{folder}/{table}.parquet")));
        short(all.join("\n").as_bytes())
    }
}

impl Fingerprints<'_> {
    /// The fingerprint of a drive.
    ///
    /// # Errors
    /// Where there is no such drive.
    pub fn of(&self, id: &DriveId) -> Result<Fingerprint, LakeError> {
        if self.folders.contains(id.as_str()) && self.lake.is_loose(id) {
            let folder = format!("drives/{id}");
            let head = self.lake.identity(&format!("{folder}/{MANIFEST}"));
            return Ok(Fingerprint { place: String::new(), head, tables: self.lake.tables(&folder) });
        }
        let missing = || LakeError::DriveMissing(id.clone());
        let (pack, row) = self.catalog.location(self.catalog.find(id).ok_or_else(missing)?);
        let (head, tables) = self.packs.get(pack).cloned().unwrap_or_default();
        Ok(Fingerprint { place: format!("{pack}/{row}"), head, tables })
    }
}

fn short(text: &[u8]) -> String {
    blake3::hash(text).to_hex()[..24].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CompactionOptions;
    use whyroad_model::scene::DriveMeta;
    use whyroad_model::{Drive, Nanos};

    fn drive(id: &str, hash: &str) -> Drive {
        let meta = DriveMeta { drive_id: id.into(), content_hash: hash.into(), ..DriveMeta::default() };
        Drive { meta, times: vec![Nanos(0), Nanos(100_000_000)], ..Drive::default() }
    }

    #[test]
    fn it_changes_with_the_drive_and_not_with_what_is_kept_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
        for id in ["a", "b"] {
            lake.write_drive(&drive(id, "1")).unwrap();
        }
        let of = |id: &str| lake.fingerprints().of(&id.into()).unwrap();
        let (a, stated) = (of("a"), lake.stated(&"a".into()));
        lake.write_note(&"a".into(), "found.json", b"{}").unwrap();
        assert_eq!((of("a"), lake.stated(&"a".into())), (a.clone(), stated.clone()));

        // A table that was changed in its place.
        let tracks = lake.dir().join("drives/a/tracks.parquet");
        let bytes = fs::read(&tracks).unwrap();
        fs::write(&tracks, [bytes.as_slice(), b" "].concat()).unwrap();
        let changed = of("a");
        assert_eq!((&changed.place, &changed.head), (&a.place, &a.head));
        assert_ne!(changed.tables, a.tables);
        fs::write(&tracks, bytes).unwrap();

        // After packing, the drive is elsewhere and states the same; notes override the pack.
        lake.compact(&CompactionOptions::default(), |_, _| ()).unwrap();
        let packed = of("a");
        assert!(!packed.place.is_empty() && !packed.head.is_empty() && packed.place != of("b").place);
        assert_eq!(lake.stated(&"a".into()), stated);
        lake.write_note(&"a".into(), "found.json", b"{}").unwrap();
        assert_eq!(of("a"), packed);

        // Replaced.
        lake.write_drive(&drive("a", "2")).unwrap();
        assert_eq!(of("a").place, "");
        assert_ne!(lake.stated(&"a".into()), stated);
        lake.write_drive(&drive("c", "")).unwrap();
        assert_eq!(lake.stated(&"c".into()), None);
        assert!(matches!(lake.fingerprints().of(&"x".into()), Err(LakeError::DriveMissing(_))));
    }
}
