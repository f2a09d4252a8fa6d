//! A drive on its way into a pack: where its tables, signals and small files are now. Its footers are read and
//! checked; the rows are not.

use super::open_pack::OpenPack;
use super::splice::Part;
use crate::lake::MANIFEST;
use crate::manifest::DriveManifest;
use crate::signals::{SignalFile, StoredDrive, TableKind};
use crate::tables::SCENE;
use crate::{LAKE_VERSION, LakeError, file};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use whyroad_model::{DriveId, Nanos};

/// A drive and all that is kept of it.
pub(super) struct Member {
    pub id: DriveId,
    pub manifest: DriveManifest,
    pub tables: BTreeMap<&'static str, Part>,
    pub signals: Option<MemberSignals>,
    /// Small files by name.
    pub notes: BTreeMap<String, Vec<u8>>,
    /// Of the drive's folder; empty where there is none.
    pub fingerprint: String,
}

/// Stored signals of a drive.
pub(super) struct MemberSignals {
    pub version: String,
    pub stored: StoredDrive,
    pub frames: Part,
    pub targets: Part,
}

impl Member {
    /// A drive with a folder of its own.
    pub fn loose(dir: &Path, id: &DriveId, fingerprint: String) -> Result<Self, LakeError> {
        let path = dir.join(MANIFEST);
        let manifest = DriveManifest::read(&path, id)?;
        if manifest.lake_version != LAKE_VERSION {
            return Err(LakeError::version(&path, manifest.lake_version, vec![manifest.meta.format]));
        }
        if manifest.meta.drive_id != *id {
            return Err(LakeError::broken(&path, format!("it is of drive '{}'", manifest.meta.drive_id)));
        }
        let mut tables = BTreeMap::new();
        for (name, order) in SCENE {
            let path = dir.join(format!("{name}.parquet"));
            let Some(&rows) = manifest.tables.get(name) else {
                if path.exists() {
                    let reason =
                        "drive.json does not name this table: a change of it was interrupted; repeat it";
                    return Err(LakeError::broken(&path, reason));
                }
                continue;
            };
            let missing =
                || LakeError::broken(&path, "the file is missing, although drive.json names the table");
            let (_, footer) = file::open(&path, order)?.ok_or_else(missing)?;
            let metadata = footer.metadata().clone();
            let found: i64 = metadata.row_groups().iter().map(|g| g.num_rows()).sum();
            if metadata.num_row_groups() > 1 || usize::try_from(found).ok() != Some(rows) {
                return Err(LakeError::broken(&path, format!("{found} rows, drive.json states {rows}")));
            }
            tables.insert(name, Part { path, metadata, group: (rows > 0).then_some(0) });
        }
        let mut member = Self {
            id: id.clone(),
            manifest,
            tables,
            signals: None,
            notes: BTreeMap::new(),
            fingerprint: String::new(),
        };
        member.overlay(dir, fingerprint)?;
        Ok(member)
    }

    /// A drive of a pack.
    pub fn packed(pack: &OpenPack, row: usize) -> Result<Self, LakeError> {
        let manifest = pack.manifests[row].clone();
        let id = manifest.meta.drive_id.clone();
        let mut tables = BTreeMap::new();
        for (name, order) in SCENE.iter().filter(|(name, _)| manifest.tables.contains_key(*name)) {
            let path = pack.path(name);
            let missing =
                || LakeError::broken(&path, "the file is missing, although drives.parquet names the table");
            let metadata = pack.footer(name, order)?.ok_or_else(missing)?.metadata().clone();
            let group = pack.group(name, row);
            if group.is_some_and(|g| g >= metadata.num_row_groups()) {
                return Err(LakeError::broken(&path, "it has fewer row groups than drives.parquet names"));
            }
            tables.insert(*name, Part { path, metadata, group });
        }
        Ok(Self {
            signals: pack.signals(&id).map(|file| MemberSignals::of(&file)),
            notes: pack.notes(row)?.into_iter().collect(),
            fingerprint: pack.fingerprints[row].clone(),
            id,
            manifest,
            tables,
        })
    }

    /// Uses the signals and small files of a folder instead of those of the drive.
    pub fn overlay(&mut self, dir: &Path, fingerprint: String) -> Result<(), LakeError> {
        self.fingerprint = fingerprint;
        let current = |file: &SignalFile| {
            let mut drives = file.contents().drives.iter().map(|d| (&d.drive_id, &d.content_hash));
            drives.next() == Some((&self.id, &self.manifest.meta.content_hash)) && drives.next().is_none()
        };
        // A store that cannot be read, or is of other content, has to be made again.
        let found = SignalFile::open(&dir.join("signals")).ok().flatten().filter(current);
        if let Some(file) = found {
            self.signals = Some(MemberSignals::of(&file));
        }
        for entry in fs::read_dir(dir).map_err(LakeError::io(dir))? {
            let entry = entry.map_err(LakeError::io(dir))?;
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let table = SCENE.iter().any(|(t, _)| name.strip_suffix(".parquet") == Some(t));
            if name == MANIFEST || name == "signals" || table {
                continue;
            }
            if path.is_dir() {
                return Err(LakeError::broken(&path, "this folder is not part of a drive"));
            }
            self.notes.insert(name, fs::read(&path).map_err(LakeError::io(&path))?);
        }
        Ok(())
    }

    /// Bytes that it takes in a pack.
    pub fn bytes(&self) -> u64 {
        let signals = self.signals.iter().flat_map(|s| [&s.frames, &s.targets]);
        let parts = self.tables.values().chain(signals).map(Part::bytes).sum::<u64>();
        parts + self.notes.values().map(|n| n.len() as u64).sum::<u64>()
    }

    /// Times of the first and the last frame, from the statistics of the file.
    pub fn span(&self) -> Result<(Nanos, Nanos), LakeError> {
        let Some(frames) = self.tables.get("frames") else { return Ok((Nanos(0), Nanos(0))) };
        file::span(&frames.path, &frames.metadata, frames.group)
    }
}

impl MemberSignals {
    /// The signals of a store of one drive.
    fn of(file: &SignalFile) -> Self {
        let part = |kind: TableKind| {
            let (path, metadata, group) = file.part(kind);
            Part { path, metadata, group }
        };
        Self {
            version: file.contents().version.clone(),
            stored: file.contents().drives[0].clone(),
            frames: part(TableKind::Frames),
            targets: part(TableKind::Targets),
        }
    }
}
