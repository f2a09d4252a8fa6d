//! What is known about a drive without reading its tables, and the signals that are stored beside it.

use crate::lake::{Lake, remove_dir};
use crate::packs::{self, Place};
use crate::signals::{SignalFile, write_signals};
use crate::tables::{frames, states};
use crate::{LakeError, clips, leftovers};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use whyroad_model::messages::clip::{ClipMetadata, DataSources};
use whyroad_model::scene::{ContextState, DriveMeta};
use whyroad_model::{DriveId, Nanos, SignalTable};

/// A drive's head: enough to list its clips and to see whether it has changed.
#[derive(Clone, Debug)]
pub struct Outline {
    /// What the drive states about itself.
    pub meta: DriveMeta,
    /// Frame times.
    pub times: Vec<Nanos>,
    /// Metadata of its clips, without pre-labels.
    pub clips: Vec<ClipMetadata>,
}

/// Context that a log states.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedContext {
    /// Weather, surface and the like; `None` where it states nothing.
    pub states: Option<Vec<ContextState>>,
    /// Whether its times are dates and times of day.
    pub dated: bool,
}

impl Lake {
    /// Reads the head of a drive.
    pub fn outline(&self, id: &DriveId) -> Result<Outline, LakeError> {
        let (manifest, times) = self.at_place(id, |place| {
            let manifest = self.current(id, place)?;
            let times = frames::from_table(&Self::needed_table(place, "frames", frames::ROW_ORDER)?)?;
            Ok((manifest, times))
        })?;
        let meta = manifest.meta;
        let sources = DataSources {
            video: meta.video.clone(),
            sensor: meta.sensors.clone(),
            can: meta.can,
            map: manifest.tables.contains_key("map"),
        };
        let clips = clips::metadata(&meta, &times, &sources);
        Ok(Outline { meta, times, clips })
    }

    /// What the log states about weather, surface and the like, and about its date.
    pub fn stated_context(&self, id: &DriveId) -> Result<StatedContext, LakeError> {
        self.at_place(id, |place| {
            let manifest = self.current(id, place)?;
            let states = if manifest.tables.contains_key("context") {
                let table = Self::needed_table(place, "context", states::CONTEXT_ORDER)?;
                Some(states::context_from_table(&table)?)
            } else {
                None
            };
            Ok(StatedContext { states, dated: manifest.meta.is_dated() })
        })
    }

    fn signals_dir(&self, id: &DriveId) -> PathBuf {
        self.drive_dir(id).join("signals")
    }

    /// The stored signals of a drive, when there are any that were derived from its present content by this version.
    pub fn signals(&self, id: &DriveId, version: &str) -> Result<Option<SignalFile>, LakeError> {
        self.at_place(id, |place| {
            let hash = self.current(id, place)?.meta.content_hash;
            let is_current = |file: &SignalFile| {
                let contents = file.contents();
                contents.version == version
                    && contents.drives.iter().map(|d| (&d.drive_id, &d.content_hash)).eq([(id, &hash)])
                    // Without a hash, equal content cannot be established.
                    && !hash.is_empty()
            };
            // A store that cannot be read has to be made again.
            let beside = SignalFile::open(&self.signals_dir(id)).ok().flatten().filter(is_current);
            Ok(match (beside, place) {
                (None, Place::Packed(pack, _)) => pack.signals(id).filter(is_current),
                (beside, _) => beside,
            })
        })
    }

    /// Stores the signals of a drive beside it, whole or not at all; what was stored before is replaced, also where
    /// several threads or processes store them at once. What killed processes left is removed the first time.
    pub fn write_signals(&self, id: &DriveId, version: &str, table: &SignalTable) -> Result<(), LakeError> {
        // Of this call: another thread may store the same drive's.
        static CALLS: AtomicU64 = AtomicU64::new(0);
        self.remove_leftovers();
        let hash = self.manifest(id)?.meta.content_hash;
        let what = format!("signals.{}", CALLS.fetch_add(1, Ordering::Relaxed));
        let (target, fresh) = (self.signals_dir(id), self.aside(id, &what)?);
        let write = || {
            remove_dir(&fresh)?;
            fs::create_dir_all(&fresh).map_err(LakeError::io(&fresh))?;
            write_signals(&fresh, version, &[(hash, table)])?;
            // Alone: between removing and moving, another process would put its own there.
            let _lock = packs::replacing(self.dir())?;
            self.make_folder(id)?;
            remove_dir(&target)?;
            fs::rename(&fresh, &target).map_err(LakeError::io(&target))
        };
        write().inspect_err(|_| {
            // The error that made it fail is the one to report.
            let _ = fs::remove_dir_all(&fresh);
        })
    }

    /// Excludes that the drive's folder is moved away, and makes the folder of a drive that has none: its content
    /// overrides that of the pack.
    fn lock_folder(&self, id: &DriveId) -> Result<Option<fs::File>, LakeError> {
        let lock = packs::changing(self.dir())?;
        self.make_folder(id)?;
        Ok(lock)
    }

    fn make_folder(&self, id: &DriveId) -> Result<(), LakeError> {
        let dir = self.drive_dir(id);
        if dir.is_dir() { Ok(()) } else { fs::create_dir_all(&dir).map_err(LakeError::io(&dir)) }
    }

    /// A small file kept beside a drive by a command that works on it; `None` without one.
    pub fn note(&self, id: &DriveId, name: &str) -> Option<Vec<u8>> {
        let beside = |id: &DriveId| fs::read(self.drive_dir(id).join(name)).ok();
        let read = |place: &Place| match place {
            Place::Loose(_) => Ok(beside(id)),
            Place::Packed(pack, row) => match beside(id) {
                Some(content) => Ok(Some(content)),
                None => {
                    Ok(pack.notes(*row)?.into_iter().find(|(n, _)| n == name).map(|(_, content)| content))
                }
            },
        };
        self.at_place(id, read).ok().flatten()
    }

    /// Keeps a small file beside a drive, whole or not at all.
    pub fn write_note(&self, id: &DriveId, name: &str, content: &[u8]) -> Result<(), LakeError> {
        self.remove_leftovers();
        self.manifest(id)?;
        let (target, fresh) = (self.drive_dir(id).join(name), self.aside(id, name)?);
        let write = || {
            fs::write(&fresh, content).map_err(LakeError::io(&fresh))?;
            let _lock = self.lock_folder(id)?;
            fs::rename(&fresh, &target).map_err(LakeError::io(&target))
        };
        write().inspect_err(|_| {
            let _ = fs::remove_file(&fresh);
        })
    }

    /// A path outside of the drives, so that no reader's pattern finds it, on the same file system.
    pub(crate) fn aside(&self, id: &DriveId, what: &str) -> Result<PathBuf, LakeError> {
        let dir = self.dir().join(leftovers::UNFINISHED);
        fs::create_dir_all(&dir).map_err(LakeError::io(&dir))?;
        Ok(dir.join(format!(".{what}-{}-{id}", std::process::id())))
    }
}
