//! Drives, signals, mined folders and camera images of one lake, as a long-running service needs them: additions during
//! operation are visible at once, and drives in use stay in memory. Knows no HTTP; the binary passes it to the service.

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use whyroad_lake::mined::MinedFile;
use whyroad_lake::storage::{LinkedMedia, MediaStore, StorageUrl};
use whyroad_lake::{Lake, LakeError, MinedFolder, Stamp};
use whyroad_model::messages::{EpisodeCursor, EpisodeFilter, EpisodePage};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Drive, DriveId, Nanos, SignalTable};

/// Drives kept in memory: people who work at the same time mostly work on the same drives.
const DRIVES_IN_MEMORY: usize = 12;

/// A folder that was given as mining results is not one.
#[derive(Debug, thiserror::Error)]
pub enum MinedFolderError {
    /// No mining results in the folder or directly below it.
    #[error("{} has no {}; `whyroad mine --out DIR` writes it", .0.display(), MinedFile::Episodes.name())]
    NoResults(PathBuf),
    /// The folder cannot be listed.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// An object store with images cannot be used.
    #[error("{0}")]
    Storage(#[from] LakeError),
}

/// A camera image in an object store.
#[derive(Clone, Debug)]
pub struct StoredImage {
    /// The store.
    pub store: MediaStore,
    /// The image in it.
    pub media: LinkedMedia,
}

/// Recordings of one lake.
pub struct LakeRecordings {
    lake: Lake,
    mined: Vec<PathBuf>,
    media: Vec<PathBuf>,
    stores: Vec<MediaStore>,
    drives: Mutex<VecDeque<CachedDrive>>,
}

/// A drive in memory, with the stamp that it had on disk before it was read.
struct CachedDrive {
    id: DriveId,
    stamp: Stamp,
    drive: Arc<Drive>,
}

impl LakeRecordings {
    /// Drives of `lake`; `mined` are folders that `whyroad mine` wrote, or folders of such folders; `media` are
    /// folders, or URLs of prefixes in an object store, with the camera images that the lake names.
    pub fn open(lake: Lake, mined: &[PathBuf], media: &[PathBuf]) -> Result<Self, MinedFolderError> {
        for dir in mined {
            let found = MinedFolder::find(dir)
                .map_err(|source| MinedFolderError::Io { path: dir.clone(), source })?;
            if found.is_empty() {
                return Err(MinedFolderError::NoResults(dir.clone()));
            }
        }
        let (mut folders, mut stores) = (Vec::new(), Vec::new());
        for place in media {
            match StorageUrl::of(place) {
                Some(url) => stores.push(MediaStore::open(&url?, "")?),
                None => folders.push(place.clone()),
            }
        }
        folders.push(lake.media_dir());
        stores.extend(lake.stored_images());
        Ok(Self { lake, mined: mined.to_vec(), media: folders, stores, drives: Mutex::default() })
    }

    /// A drive.
    pub fn drive(&self, id: &DriveId) -> Result<Arc<Drive>, LakeError> {
        let stamp = self.lake.stamp(id)?;
        if let Some(cached) = self.cache().iter().find(|c| c.id == *id && c.stamp == stamp) {
            return Ok(Arc::clone(&cached.drive));
        }
        let drive = Arc::new(self.lake.read_drive(id)?);
        let mut cache = self.cache();
        cache.retain(|c| c.id != *id);
        cache.push_front(CachedDrive { id: id.clone(), stamp, drive: Arc::clone(&drive) });
        cache.truncate(DRIVES_IN_MEMORY);
        Ok(drive)
    }

    /// Frame times of a drive, read without its tracks and map.
    pub fn frame_times(&self, id: &DriveId) -> Result<Vec<Nanos>, LakeError> {
        let stamp = self.lake.stamp(id)?;
        if let Some(cached) = self.cache().iter().find(|c| c.id == *id && c.stamp == stamp) {
            return Ok(cached.drive.times.clone());
        }
        Ok(self.lake.outline(id)?.times)
    }

    /// Whether the lake's folder can be read.
    pub fn ready(&self) -> Result<(), LakeError> {
        self.lake.ready()
    }

    /// Changes whenever the drive on disk changes; empty for a drive that cannot be read.
    pub fn version(&self, id: &DriveId) -> String {
        self.lake.stamp(id).map_or_else(|_| String::new(), |stamp| format!("{stamp:?}"))
    }

    /// Signals of a drive that may be cut at a keyframe. Never the lake's stored tables: those were derived from the
    /// whole drive and contain its future.
    pub fn signals(&self, drive: &Drive) -> SignalTable {
        whyroad_signals::derive(drive)
    }

    /// The last frame of [`LakeRecordings::signals`]: those of `whyroad_signals::derive_last_frame`.
    pub fn last_frame(&self, drive: &Drive) -> SignalTable {
        whyroad_signals::derive_last_frame(drive)
    }

    /// Signals of a whole drive of this lake, with its future: those stored for the drive's content, or derived now.
    pub fn whole_signals(&self, drive: &Drive) -> SignalTable {
        self.stored_signals(drive).unwrap_or_else(|| whyroad_signals::derive(drive))
    }

    fn stored_signals(&self, drive: &Drive) -> Option<SignalTable> {
        let file = self.lake.signals(&drive.meta.drive_id, whyroad_signals::VERSION).ok()??;
        // The drive may have been replaced since it was read.
        let same = file.contents().drives.first()?.content_hash == drive.meta.content_hash;
        if same { file.read_table(0).ok() } else { None }
    }

    /// The drive with complete motion; it may be cut at a keyframe, and then nothing later affects it.
    pub fn estimated(&self, drive: &Arc<Drive>) -> Arc<Drive> {
        match whyroad_signals::estimate(drive) {
            Cow::Owned(complete) => Arc::new(complete),
            Cow::Borrowed(_) => Arc::clone(drive),
        }
    }

    /// Names of the mined folders, as they are now.
    pub fn mined(&self) -> Vec<String> {
        self.folders().into_keys().collect()
    }

    /// Number of episodes of a mined folder that match `filter`; `None` for an unknown name.
    pub fn episode_count(&self, name: &str, filter: &EpisodeFilter) -> Option<Result<u64, LakeError>> {
        let folder = self.folders().remove(name)?;
        Some(folder.index().and_then(|index| index.count(filter)))
    }

    /// A page of the episodes of a mined folder; `None` for an unknown name.
    pub fn episodes(
        &self,
        name: &str,
        filter: &EpisodeFilter,
        after: Option<EpisodeCursor>,
        limit: usize,
    ) -> Option<Result<EpisodePage, LakeError>> {
        let folder = self.folders().remove(name)?;
        Some(folder.index().and_then(|index| index.page(filter, after, limit)))
    }

    /// The file of a camera image, where it is on this machine and within a folder that the service may read.
    pub fn media(&self, drive: &DriveId, frame: &MediaFrame) -> Option<PathBuf> {
        crate::media::image_kind_by_extension(Path::new(&frame.uri))?;
        // As the log names it: from its own folder, or from the folder of all logs.
        let paths = |root: &PathBuf| [root.join(drive.as_str()).join(&frame.uri), root.join(&frame.uri)];
        // Looked up each time: the lake's own folder comes with the first `whyroad media add --copy`.
        let roots: Vec<PathBuf> = self.media.iter().filter_map(|d| d.canonicalize().ok()).collect();
        let found = roots.iter().flat_map(|root| paths(root).map(|p| (root, p)));
        // A name with `..` or a link must not lead out of the folder that the service may read.
        found
            .filter_map(|(root, path)| Some((root, path.canonicalize().ok()?)))
            .find(|(root, path)| path.starts_with(root) && path.is_file())
            .map(|(_, path)| path)
    }

    /// A camera image in one of the object stores: one image per object, never a video.
    ///
    /// # Errors
    /// When a store cannot be reached.
    pub fn stored_image(
        &self,
        drive: &DriveId,
        frame: &MediaFrame,
    ) -> Result<Option<StoredImage>, LakeError> {
        if self.stores.is_empty() || crate::media::image_kind_by_extension(Path::new(&frame.uri)).is_none() {
            return Ok(None);
        }
        for store in &self.stores {
            for name in [format!("{drive}/{}", frame.uri), frame.uri.clone()] {
                if let Some(media) = store.find(&name)? {
                    return Ok(Some(StoredImage { store: store.clone(), media }));
                }
            }
        }
        Ok(None)
    }

    /// Targets of links to images in object stores: scheme, host and port.
    ///
    /// # Errors
    /// Where credentials are missing.
    pub fn image_origins(&self) -> Result<Vec<String>, LakeError> {
        let mut origins: Vec<String> =
            self.stores.iter().map(MediaStore::origin).collect::<Result<_, _>>()?;
        origins.sort();
        origins.dedup();
        Ok(origins)
    }

    /// Mined folders by name, as they are now. One that cannot be read at the moment is left out.
    fn folders(&self) -> BTreeMap<String, MinedFolder> {
        self.mined.iter().filter_map(|dir| MinedFolder::find(dir).ok()).flatten().collect()
    }

    /// The drives in memory. They stay consistent even when a thread that held the lock has panicked.
    fn cache(&self) -> MutexGuard<'_, VecDeque<CachedDrive>> {
        self.drives.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests;
