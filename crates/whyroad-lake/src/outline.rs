//! What is known of a drive without reading its tables, and the signals that are stored beside it.

use crate::lake::{Lake, remove_dir};
use crate::signals::{SignalFile, write_signals};
use crate::tables::{frames, states};
use crate::{LakeError, clips, file};
use std::fs;
use std::path::PathBuf;
use whyroad_model::messages::clip::{ClipMetadata, DataSources};
use whyroad_model::scene::{ContextState, DriveMeta};
use whyroad_model::{DriveId, FrameRange, Nanos, SignalTable};

/// A drive's head: enough to say what its clips are and whether it has changed.
#[derive(Clone, Debug)]
pub struct Outline {
    /// What the drive states about itself.
    pub meta: DriveMeta,
    /// Frame times.
    pub times: Vec<Nanos>,
    /// Metadata of its clips, without pre-labels.
    pub clips: Vec<ClipMetadata>,
    /// Frames of each clip.
    pub clip_frames: Vec<FrameRange>,
}

impl Lake {
    /// Reads the head of a drive.
    pub fn outline(&self, id: &DriveId) -> Result<Outline, LakeError> {
        let manifest = self.manifest(id)?;
        let path = self.drive_dir(id).join("frames.parquet");
        let table = file::read_table(&path, frames::ROW_ORDER)?
            .ok_or_else(|| LakeError::broken(&path, "the file is missing"))?;
        let times = frames::from_table(&table)?;
        let meta = manifest.meta;
        let sources = DataSources {
            video: meta.video.clone(),
            sensor: meta.sensors.clone(),
            can: meta.can,
            map: manifest.tables.contains_key("map"),
        };
        let clips = clips::metadata(&meta, &times, &sources);
        let clip_frames = clips::clip_ranges(times.len());
        Ok(Outline { meta, times, clips, clip_frames })
    }

    /// What the log states of weather, surface and the like; `None` where it states nothing.
    pub fn stated_context(&self, id: &DriveId) -> Result<Option<Vec<ContextState>>, LakeError> {
        if !self.manifest(id)?.tables.contains_key("context") {
            return Ok(None);
        }
        let path = self.drive_dir(id).join("context.parquet");
        let table = file::read_table(&path, states::CONTEXT_ORDER)?
            .ok_or_else(|| LakeError::broken(&path, "the file is missing"))?;
        Ok(Some(states::context_from_table(&table)?))
    }

    fn signals_dir(&self, id: &DriveId) -> PathBuf {
        self.drive_dir(id).join("signals")
    }

    /// The stored signals of a drive, when there are any that were derived from its present content by this version.
    pub fn signals(&self, id: &DriveId, version: &str) -> Result<Option<SignalFile>, LakeError> {
        let hash = self.manifest(id)?.meta.content_hash;
        // A store that cannot be read is one that has to be made again.
        let Ok(Some(file)) = SignalFile::open(&self.signals_dir(id)) else { return Ok(None) };
        let contents = file.contents();
        let current = contents.version == version
            && contents.drives.iter().map(|d| (&d.drive_id, &d.content_hash)).eq([(id, &hash)])
            // Without a hash nobody can say that the content is the same.
            && !hash.is_empty();
        Ok(current.then_some(file))
    }

    /// Stores the signals of a drive beside it, whole or not at all; what was stored before is replaced.
    pub fn write_signals(&self, id: &DriveId, version: &str, table: &SignalTable) -> Result<(), LakeError> {
        let hash = self.manifest(id)?.meta.content_hash;
        let (target, fresh) = (self.signals_dir(id), self.aside(id, "signals"));
        remove_dir(&fresh)?;
        fs::create_dir_all(&fresh).map_err(LakeError::io(&fresh))?;
        write_signals(&fresh, version, &[(hash, table)]).inspect_err(|_| {
            // The error that made it fail is the one to report.
            let _ = fs::remove_dir_all(&fresh);
        })?;
        remove_dir(&target)?;
        fs::rename(&fresh, &target).map_err(LakeError::io(&target))
    }

    /// A small file kept beside a drive by a command that works on it; `None` without one.
    pub fn note(&self, id: &DriveId, name: &str) -> Option<Vec<u8>> {
        fs::read(self.drive_dir(id).join(name)).ok()
    }

    /// Keeps a small file beside a drive, whole or not at all.
    pub fn write_note(&self, id: &DriveId, name: &str, content: &[u8]) -> Result<(), LakeError> {
        self.manifest(id)?;
        let (target, fresh) = (self.drive_dir(id).join(name), self.aside(id, name));
        fs::write(&fresh, content).map_err(LakeError::io(&fresh))?;
        fs::rename(&fresh, &target).map_err(LakeError::io(&target))
    }

    /// A name that no reader takes for a drive, on the same file system.
    pub(crate) fn aside(&self, id: &DriveId, what: &str) -> PathBuf {
        self.dir().join("drives").join(format!(".{what}-{}-{id}", std::process::id()))
    }
}
