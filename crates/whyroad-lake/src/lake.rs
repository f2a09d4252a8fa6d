//! A lake folder: which drives it holds, reading one, writing one atomically.

use crate::columns::Table;
pub(crate) use crate::manifest::MANIFEST;
use crate::manifest::{DriveManifest, LakeMarker, is_drive};
use crate::packs::fingerprint::identity;
use crate::packs::lock;
use crate::packs::places::{Packs, Place};
use crate::storage::{self, Intent, MediaStore, Mirror, StorageUrl};
use crate::tables::{clips, ego, frames, road_map, states, tracks};
use crate::{DriveFacts, LAKE_VERSION, LAYOUTS, LakeError, PACKED_VERSION};
use crate::{clip_metadata, file, leftovers, validity};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Once};
use whyroad_model::messages::clip::ClipMetadata;
use whyroad_model::scene::DriveMeta;
use whyroad_model::{Drive, DriveId, Nanos};

pub(crate) const MARKER: &str = "whyroad-lake.json";

/// An opened lake.
#[derive(Clone, Debug)]
pub struct Lake {
    dir: PathBuf,
    pub(crate) packs: Arc<Packs>,
    /// Of a lake in an object store, whose folder is then one of this process.
    pub(crate) mirror: Option<Arc<Mirror>>,
    /// Whether leftovers were removed.
    tidied: Arc<Once>,
}

/// What [`Lake::write_drive`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteOutcome {
    /// The drive is new.
    Written,
    /// A drive of the same id and content hash exists already; nothing was changed.
    Unchanged,
    /// A drive of the same id but other content was replaced.
    Replaced,
}

impl Lake {
    /// Opens an existing lake: a folder, or the URL of one in an object store (`s3://bucket/prefix`).
    ///
    /// # Errors
    /// Where it is not a lake, cannot be read, or is of a version that this build does not read.
    pub fn open(dir: impl AsRef<Path>) -> Result<Self, LakeError> {
        match StorageUrl::of(dir.as_ref()) {
            Some(url) => {
                let url = url?;
                let mirror = Mirror::open(storage::objects(&url)?)?;
                let none = || LakeError::NotALake(PathBuf::from(url.to_string()));
                // A creation that was interrupted has published nothing but the manifest.
                let named = |e| if matches!(e, LakeError::NotALake(_)) { none() } else { e };
                let mut lake = Self::open_folder(mirror.as_ref().ok_or_else(none)?.dir()).map_err(named)?;
                lake.mirror = mirror.map(Arc::new);
                Ok(lake)
            }
            None => Self::open_folder(dir.as_ref()),
        }
    }

    fn open_folder(dir: &Path) -> Result<Self, LakeError> {
        let (lake, version) = Self::of_any_version(dir)?;
        // Otherwise it would seem to have no loose drives.
        let drives = lake.dir.join("drives");
        match fs::read_dir(&drives) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(LakeError::io(&drives)(e)),
            _ => {}
        }
        if !LAYOUTS.contains(&version) {
            let formats = lake.outdated_formats();
            return Err(LakeError::version(&lake.dir.join(MARKER), version, formats));
        }
        lake.catalog()?;
        Ok(lake)
    }

    /// Whether the lake can be read now.
    ///
    /// # Errors
    /// As [`Lake::open`].
    pub fn ready(&self) -> Result<(), LakeError> {
        if let Some(mirror) = &self.mirror {
            mirror.ready()?;
        }
        match Self::of_any_version(&self.dir)? {
            (_, version) if LAYOUTS.contains(&version) => self.catalog().map(drop),
            _ => Self::open_folder(&self.dir).map(drop),
        }
    }

    /// The lake and the version that its marker states.
    fn of_any_version(dir: &Path) -> Result<(Self, u32), LakeError> {
        let path = dir.join(MARKER);
        let text = match fs::read_to_string(&path) {
            Ok(t) => t,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                return Err(LakeError::NotALake(dir.to_owned()));
            }
            Err(e) => return Err(LakeError::io(&path)(e)),
        };
        let marker: LakeMarker = serde_json::from_str(&text).map_err(|e| LakeError::broken(&path, e))?;
        Ok((
            Self { dir: dir.to_owned(), packs: Arc::default(), mirror: None, tidied: Arc::new(Once::new()) },
            marker.version,
        ))
    }

    /// Removes what killed processes left, once for this lake and its copies.
    pub(crate) fn remove_leftovers(&self) {
        self.tidied.call_once(|| leftovers::remove(&self.dir));
    }

    /// Opens the lake for writing, making an empty one if it does not exist. Partial writes of a killed process are
    /// removed. An older lake becomes one of this version: each of its drives is refused by readers until it is written
    /// again.
    ///
    /// What is written into a lake in an object store is not visible before [`Lake::publish`].
    ///
    /// # Errors
    /// Those of [`Lake::open`], and when the lake cannot be written.
    pub fn create_or_open(dir: impl AsRef<Path>) -> Result<Self, LakeError> {
        let Some(url) = StorageUrl::of(dir.as_ref()) else {
            return Self::create_or_open_folder(dir.as_ref());
        };
        Self::over(Mirror::create_or_open(storage::objects(&url?)?)?)
    }

    /// The lake of a process's copy, made where it is empty.
    pub(crate) fn over(mirror: Mirror) -> Result<Self, LakeError> {
        let mut lake = Self::create_or_open_folder(mirror.dir())?;
        lake.mirror = Some(Arc::new(mirror));
        lake.publish()?;
        Ok(lake)
    }

    /// Publishes what was written into a lake in an object store since the last time: readers find all of it or none.
    /// Nothing to do for a lake in a folder.
    ///
    /// # Errors
    /// [`LakeError::ChangedMeanwhile`] names drives that another process changed at the same time; all others are
    /// published. After any other error, call it again: this is safe whether or not it was published.
    pub fn publish(&self) -> Result<(), LakeError> {
        self.publish_as(Intent::Write)
    }

    /// [`Lake::publish`] of a deletion: objects of what was removed are removed as well, at once.
    ///
    /// # Errors
    /// As [`Lake::publish`]; where another process changed one of the drives, nothing is deleted.
    pub fn publish_removal(&self) -> Result<(), LakeError> {
        self.publish_as(Intent::Delete)
    }

    pub(crate) fn publish_as(&self, intent: Intent) -> Result<(), LakeError> {
        self.mirror.as_ref().map_or(Ok(()), |mirror| mirror.publish(intent))
    }

    /// The images in a lake in an object store; `None` for a lake in a folder.
    pub fn stored_images(&self) -> Option<MediaStore> {
        self.mirror.as_ref().map(|mirror| mirror.images())
    }

    /// The lake's displayed name: its folder or its URL.
    pub fn name(&self) -> String {
        self.mirror.as_ref().map_or_else(|| self.dir.display().to_string(), |mirror| mirror.url())
    }

    fn create_or_open_folder(dir: &Path) -> Result<Self, LakeError> {
        match Self::of_any_version(dir) {
            Err(LakeError::NotALake(_)) => {
                fs::create_dir_all(dir.join("drives")).map_err(LakeError::io(dir))?
            }
            Ok((lake, version)) if LAYOUTS.contains(&version) => {
                leftovers::remove(&lake.dir);
                return Self::open_folder(dir);
            }
            Ok((lake, older)) if older < LAKE_VERSION => leftovers::remove(&lake.dir),
            Ok(_) => return Self::open_folder(dir),
            Err(e) => return Err(e),
        }
        write_marker(dir, LAKE_VERSION)?;
        Ok(Self { dir: dir.to_owned(), packs: Arc::default(), mirror: None, tidied: Arc::new(Once::new()) })
    }

    /// Makes the folder of packs; from now on, a build without support for packs refuses the lake.
    pub(crate) fn mark_packed(&self) -> Result<(), LakeError> {
        let packs = self.packs_dir();
        fs::create_dir_all(&packs).map_err(LakeError::io(&packs))?;
        if Self::of_any_version(&self.dir)?.1 == PACKED_VERSION {
            return Ok(());
        }
        write_marker(&self.dir, PACKED_VERSION)
    }

    /// Formats of the drives that this build does not read, or of all where it reads them; sorted.
    fn outdated_formats(&self) -> Vec<String> {
        let (mut outdated, mut all) = (BTreeSet::new(), BTreeSet::new());
        for manifest in self.drive_ids().iter().filter_map(|id| self.manifest_of_any_version(id).ok()) {
            if manifest.lake_version != LAKE_VERSION {
                outdated.insert(manifest.meta.format.clone());
            }
            all.insert(manifest.meta.format);
        }
        if outdated.is_empty() { all } else { outdated }.into_iter().collect()
    }

    /// The lake's folder; of a lake in an object store, a folder of this process.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The folder of camera images that were copied into the lake, one folder per drive; it need not exist.
    pub fn media_dir(&self) -> PathBuf {
        self.dir.join("media")
    }

    pub(crate) fn drive_dir(&self, id: &DriveId) -> PathBuf {
        self.dir.join("drives").join(id.as_str())
    }

    /// The folder of a drive. An id that is not a folder name cannot be in the lake, and must not be joined to a path.
    pub(crate) fn checked_dir(&self, id: &DriveId) -> Result<PathBuf, LakeError> {
        if !id.is_folder_safe() {
            return Err(LakeError::DriveMissing(id.clone()));
        }
        Ok(self.drive_dir(id))
    }

    /// True for a drive with a folder of its own, which overrides its copy in a pack.
    pub(crate) fn is_loose(&self, id: &DriveId) -> bool {
        is_drive(&self.drive_dir(id))
    }

    /// Ids of all drives, sorted: those of the catalog, and those with a folder of their own.
    pub fn drive_ids(&self) -> Vec<DriveId> {
        let mut loose = Vec::new();
        // Folders first: a drive that is being packed is in the catalog before its folder is gone.
        for entry in fs::read_dir(self.dir.join("drives")).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // A name with a leading dot is what an older version left of a drive being written.
            if !name.starts_with('.') {
                loose.push(DriveId(name));
            }
        }
        let catalog = self.last_catalog();
        loose.retain(|id| catalog.find(id).is_none() && is_drive(&self.drive_dir(id)));
        let mut ids: Vec<DriveId> = catalog.ids().map(DriveId::from).collect();
        ids.append(&mut loose);
        ids.sort();
        ids
    }

    pub(crate) fn manifest(&self, id: &DriveId) -> Result<DriveManifest, LakeError> {
        self.at_place(id, |place| self.current(id, place))
    }

    /// What the drive at this place states about itself, where this build reads it.
    pub(crate) fn current(&self, id: &DriveId, place: &Place) -> Result<DriveManifest, LakeError> {
        let path = match place {
            Place::Loose(dir) => dir.join(MANIFEST),
            Place::Packed(pack, row) => return Ok(pack.manifests[*row].clone()),
        };
        let manifest = DriveManifest::read(&path, id)?;
        if manifest.lake_version != LAKE_VERSION {
            return Err(LakeError::version(&path, manifest.lake_version, vec![manifest.meta.format]));
        }
        Ok(manifest)
    }

    /// Hash of the content from which the lake's drive of this id was made, also where this build does not read it.
    pub fn content_hash(&self, id: &DriveId) -> Option<String> {
        Some(self.manifest_of_any_version(id).ok()?.meta.content_hash)
    }

    fn manifest_of_any_version(&self, id: &DriveId) -> Result<DriveManifest, LakeError> {
        self.manifest_at(id)
    }

    /// The rows that a drive has of a table; `None` where it does not have the table.
    pub(crate) fn table(place: &Place, name: &str, order: &str) -> Result<Option<Table>, LakeError> {
        match place {
            Place::Loose(dir) => file::read_table(&dir.join(format!("{name}.parquet")), order),
            Place::Packed(pack, row) if pack.manifests[*row].tables.contains_key(name) => {
                pack.table(name, order, *row)
            }
            Place::Packed(..) => Ok(None),
        }
    }

    /// [`Lake::table`] of a table that the drive must have.
    pub(crate) fn needed_table(place: &Place, name: &str, order: &str) -> Result<Table, LakeError> {
        Self::table(place, name, order)?.ok_or_else(|| {
            let path = place.path(&format!("{name}.parquet"));
            LakeError::broken(&path, "the file is missing, although drive.json names the table")
        })
    }

    /// Reads one drive whole.
    pub fn read_drive(&self, id: &DriveId) -> Result<Drive, LakeError> {
        self.at_place(id, |place| self.read_at(id, place))
    }

    fn read_at(&self, id: &DriveId, place: &Place) -> Result<Drive, LakeError> {
        let manifest = self.current(id, place)?;
        let table = |name: &str, order: &str| -> Result<Option<_>, LakeError> {
            let Some(&rows) = manifest.tables.get(name) else { return Ok(None) };
            let t = Self::needed_table(place, name, order)?;
            if t.rows() != rows {
                return Err(LakeError::broken(
                    &t.path,
                    format!("{} rows, drive.json states {rows}", t.rows()),
                ));
            }
            Ok(Some(t))
        };
        let needed =
            |name: &str| LakeError::broken(&place.path(MANIFEST), format!("table '{name}' is not named"));

        let times =
            frames::from_table(&table("frames", frames::ROW_ORDER)?.ok_or_else(|| needed("frames"))?)?;
        let n = times.len();
        let tracks =
            tracks::from_table(&table("tracks", tracks::ROW_ORDER)?.ok_or_else(|| needed("tracks"))?, n)?;
        Ok(Drive {
            meta: manifest.meta.clone(),
            times,
            ego: table("ego", ego::ROW_ORDER)?.map(|t| ego::from_table(&t, n)).transpose()?,
            tracks,
            map: table("map", road_map::ROW_ORDER)?.map(|t| road_map::from_table(&t)).transpose()?,
            lights: table("lights", states::LIGHTS_ORDER)?
                .map(|t| states::lights_from_table(&t))
                .transpose()?,
            context: table("context", states::CONTEXT_ORDER)?
                .map(|t| states::context_from_table(&t))
                .transpose()?,
            media: table("media", states::MEDIA_ORDER)?.map(|t| states::media_from_table(&t)).transpose()?,
        })
    }

    /// Id, start and number of frames of a drive's clips, without reading the drive.
    pub fn clip_summaries(&self, id: &DriveId) -> Result<Vec<(String, Nanos, u32)>, LakeError> {
        self.at_place(id, |place| {
            self.current(id, place)?;
            clips::summaries(&Self::needed_table(place, "clips", clips::ROW_ORDER)?)
        })
    }

    /// Clip metadata of a drive.
    pub fn clips(&self, drive: &Drive) -> Vec<ClipMetadata> {
        clip_metadata(drive)
    }

    /// Writes one drive. A drive of the same id is replaced, unless its content hash is equal. Readers never see a
    /// part of a drive: the tables are written to a temporary folder, which is then renamed into place. (A process
    /// killed between the two renames of a replacement leaves no drive of that id; the next ingest writes it again.)
    pub fn write_drive(&self, drive: &Drive) -> Result<WriteOutcome, LakeError> {
        self.write_drive_with(drive, &[])
    }

    /// [`Lake::write_drive`] with small files (name, content) kept beside the drive, which become visible together with
    /// it; an unchanged drive keeps the files that it has.
    pub fn write_drive_with(
        &self,
        drive: &Drive,
        notes: &[(&str, &[u8])],
    ) -> Result<WriteOutcome, LakeError> {
        let id = &drive.meta.drive_id;
        if let Some(reason) = validity::broken_promise(drive) {
            return Err(LakeError::DriveInvalid { drive: id.clone(), reason });
        }
        let target = self.drive_dir(id);
        let state = || identity(&target.join(MANIFEST));
        let before = state();
        let hash = &drive.meta.content_hash;
        let is_same = || !hash.is_empty() && self.manifest(id).is_ok_and(|m| m.meta.content_hash == *hash);
        // A drive that is broken or of another version is replaced like any other.
        if is_same() && self.read_drive(id).is_ok() {
            return Ok(WriteOutcome::Unchanged);
        }
        let (fresh, old) = (self.aside(id, "new")?, self.aside(id, "old")?);
        for leftover in [&fresh, &old] {
            remove_dir(leftover)?;
        }
        fs::create_dir_all(&fresh).map_err(LakeError::io(&fresh))?;
        // Facts that were stated about the drive and that the log does not have are kept.
        let mut meta = drive.meta.clone();
        if let Ok(held) = self.manifest_of_any_version(id) {
            let own = DriveFacts::of(&meta);
            DriveFacts::of(&held.meta).state(&mut meta);
            own.state(&mut meta);
        }
        let keep = |&(name, content): &(&str, &[u8])| {
            let path = fresh.join(name);
            fs::write(&path, content).map_err(LakeError::io(&path))
        };
        let put = || -> Result<WriteOutcome, LakeError> {
            notes.iter().try_for_each(keep)?;
            write_tables(&fresh, drive, meta)?;
            // Alone: another process may write the same drive.
            let _lock = lock::replacing(&self.dir)?;
            if state() != before && is_same() {
                return Ok(WriteOutcome::Unchanged);
            }
            // Signals and small files that override those of a packed drive are removed with it.
            let (aside, packed) = (target.exists(), self.last_catalog().find(id).is_some());
            if aside {
                fs::rename(&target, &old).map_err(LakeError::io(&target))?;
            }
            fs::rename(&fresh, &target).map_err(LakeError::io(&target))?;
            Ok(if aside || packed { WriteOutcome::Replaced } else { WriteOutcome::Written })
        };
        let outcome = put();
        if !matches!(outcome, Ok(WriteOutcome::Written | WriteOutcome::Replaced)) {
            // The error that made it fail is the one to report.
            let _ = fs::remove_dir_all(&fresh);
        }
        let outcome = outcome?;
        remove_dir(&old)?;
        Ok(outcome)
    }
}

/// Readers find the marker whole.
fn write_marker(dir: &Path, version: u32) -> Result<(), LakeError> {
    let (path, fresh) = (dir.join(MARKER), dir.join(format!(".{MARKER}-{}", std::process::id())));
    write_json(&fresh, &LakeMarker { format: "whyroad-lake".to_owned(), version })?;
    fs::rename(&fresh, &path).map_err(LakeError::io(&path))
}

pub(crate) fn write_tables(dir: &Path, drive: &Drive, meta: DriveMeta) -> Result<(), LakeError> {
    let mut tables = BTreeMap::new();
    let mut write = |name: &str, table, order: &str| -> Result<(), LakeError> {
        let rows = file::write_table(&dir.join(format!("{name}.parquet")), table, order)?;
        tables.insert(name.to_owned(), rows);
        Ok(())
    };
    write("clips", clips::to_table(&clip_metadata(drive)), clips::ROW_ORDER)?;
    write("frames", frames::to_table(drive), frames::ROW_ORDER)?;
    write("tracks", tracks::to_table(drive), tracks::ROW_ORDER)?;
    if let Some(e) = &drive.ego {
        write("ego", ego::to_table(drive, e), ego::ROW_ORDER)?;
    }
    if let Some(m) = &drive.map {
        write("map", road_map::to_table(m), road_map::ROW_ORDER)?;
    }
    if let Some(l) = &drive.lights {
        write("lights", states::lights_to_table(l), states::LIGHTS_ORDER)?;
    }
    if let Some(c) = &drive.context {
        write("context", states::context_to_table(c), states::CONTEXT_ORDER)?;
    }
    if let Some(m) = &drive.media {
        write("media", states::media_to_table(m), states::MEDIA_ORDER)?;
    }
    let manifest = DriveManifest { lake_version: LAKE_VERSION, meta, frames: drive.times.len(), tables };
    write_json(&dir.join(MANIFEST), &manifest)
}

pub(crate) fn write_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<(), LakeError> {
    let mut text = serde_json::to_string_pretty(value).map_err(|e| LakeError::broken(path, e))?;
    text.push('\n');
    let mut file = fs::File::create(path).map_err(LakeError::io(path))?;
    file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(LakeError::io(path))
}

pub(crate) fn remove_dir(path: &Path) -> Result<(), LakeError> {
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(LakeError::io(path)(e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_that_cannot_be_read_does_not_disappear() {
        let dir = tempfile::tempdir().unwrap();
        let lake = Lake::create_or_open(dir.path()).unwrap();
        let drives = dir.path().join("drives");
        for id in ["overlay", "part"] {
            fs::create_dir(drives.join(id)).unwrap();
        }
        fs::write(drives.join("overlay/found.json"), "{}").unwrap();
        fs::write(drives.join("part/frames.parquet"), "").unwrap();
        fs::write(drives.join("notes.txt"), "").unwrap();
        // Links that lead to themselves or to nowhere: nobody can read them, not even root.
        for (id, to) in [("loop", "loop"), ("lost", "nowhere")] {
            std::os::unix::fs::symlink(to, drives.join(id)).unwrap();
        }
        let ids: Vec<String> = lake.drive_ids().iter().map(ToString::to_string).collect();
        assert_eq!(ids, ["loop", "lost", "part"]);
        let code = |id: &str| lake.read_drive(&id.into()).unwrap_err().code();
        assert_eq!(
            ["loop", "lost", "part", "overlay"].map(code),
            ["lake.io", "lake.table_broken", "lake.table_broken", "lake.drive_missing"]
        );
        assert_eq!(lake.entries().filter(|(_, entry)| entry.is_err()).count(), 3);
        let compacted = lake.compact(&crate::CompactionOptions::default(), |_, _| ()).unwrap();
        assert_eq!(compacted.left.len(), 1, "of those, one is a folder: {:?}", compacted.left);
        fs::rename(&drives, dir.path().join("other")).unwrap();
        fs::write(&drives, "").unwrap();
        assert_eq!(Lake::open(dir.path()).unwrap_err().code(), "lake.io");
    }
}
