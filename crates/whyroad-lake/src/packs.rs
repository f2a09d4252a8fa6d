//! Packs: many drives in few files, for lakes that are too large for a folder per drive.
//!
//! `packs/<number>/` has one Parquet file per table, with one row group per drive that has rows in it, and the drives'
//! `drive.json` in `drives.parquet`. `packs/catalogue.parquet` states where each drive is; replacing it by one rename
//! publishes a compaction or a deletion. Packs are never changed.
//!
//! Precedence: `drives/<id>/` with a `drive.json` is a loose drive, and its copy in a pack is outdated. Without one,
//! the signals and small files in `drives/<id>/` override those of the pack. So a drive is ingested, replaced, mined
//! and changed as if there were no packs, and the next compaction packs the changes.

mod catalog;
mod compact;
pub(crate) mod fingerprint;
pub(crate) mod lock;
mod member;
mod open_pack;
pub(crate) mod places;
mod splice;
mod unpack;
mod write;

pub use catalog::DriveEntry;
pub use compact::{Compaction, CompactionOptions};

pub(crate) use lock::{changing, replacing};
pub(crate) use open_pack::{DRIVES as DRIVES_FILE, OpenPack};
pub(crate) use places::Place;

use crate::manifest::DriveManifest;
use crate::manifest::{MANIFEST, is_drive};
use crate::{Lake, LakeError};
use catalog::Catalog;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use whyroad_model::DriveId;

/// A catalog that is in use.
pub(crate) type CatalogRef = Arc<Catalog>;

pub(crate) const FOLDER: &str = "packs";

/// Packs whose footers are kept in memory.
const OPEN_PACKS: usize = 8;

fn guard<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Lake {
    pub(crate) fn packs_dir(&self) -> PathBuf {
        self.dir().join(FOLDER)
    }

    /// The catalog as it is now; read again only when it was replaced.
    pub(crate) fn catalog(&self) -> Result<Arc<Catalog>, LakeError> {
        let path = self.packs_dir().join(catalog::FILE);
        let identity = fingerprint::identity(&path);
        let mut held = guard(&self.packs.catalog);
        if held.identity != identity {
            *held = Arc::new(Catalog::read(&path)?);
        }
        Ok(Arc::clone(&held))
    }

    /// The catalog as it is now, or as it was when it could last be read; opening a lake has read it.
    pub(crate) fn last_catalog(&self) -> Arc<Catalog> {
        self.catalog().unwrap_or_else(|_| Arc::clone(&guard(&self.packs.catalog)))
    }

    /// Fetches a drive's folder or a pack of a lake in an object store.
    pub(crate) fn fetch(&self, folder: &str) -> Result<(), LakeError> {
        self.mirror.as_ref().map_or(Ok(()), |mirror| mirror.fetch_folder(folder))
    }

    fn open_pack(&self, name: &str) -> Result<Arc<OpenPack>, LakeError> {
        let dir = self.packs_dir().join(name);
        self.fetch(&format!("{FOLDER}/{name}"))?;
        let mut open = guard(&self.packs.open);
        if let Some(at) = open.iter().position(|p| p.dir == dir) {
            let pack = open.remove(at);
            open.insert(0, Arc::clone(&pack));
            return Ok(pack);
        }
        let pack = Arc::new(OpenPack::read(dir)?);
        open.insert(0, Arc::clone(&pack));
        open.truncate(OPEN_PACKS);
        Ok(pack)
    }

    /// Where a drive is now.
    pub(crate) fn place(&self, id: &DriveId) -> Result<Place, LakeError> {
        self.checked_dir(id)?;
        self.fetch(&format!("drives/{id}"))?;
        self.place_as_it_is(id)
    }

    /// [`Lake::place`] without fetching anything from an object store but packs.
    pub(crate) fn place_as_it_is(&self, id: &DriveId) -> Result<Place, LakeError> {
        let dir = self.checked_dir(id)?;
        if is_drive(&dir) {
            return Ok(Place::Loose(dir));
        }
        let catalog = self.catalog()?;
        let Some(at) = catalog.find(id) else { return Err(LakeError::DriveMissing(id.clone())) };
        let (pack, row) = catalog.location(at);
        Ok(Place::Packed(self.open_pack(pack)?, row))
    }

    /// Calls `read` with the drive's place, and again if another process has moved the drive meanwhile.
    pub(crate) fn at_place<T>(
        &self,
        id: &DriveId,
        read: impl Fn(&Place) -> Result<T, LakeError>,
    ) -> Result<T, LakeError> {
        let mut place = self.place(id);
        for _ in 0..8 {
            let result = place.as_ref().map_err(|_| ()).and_then(|p| read(p).map_err(|_| ()));
            if let Ok(value) = result {
                return Ok(value);
            }
            let now = self.place(id);
            let moved = match (&place, &now) {
                (Ok(before), Ok(now)) => before != now,
                (Err(_), Ok(_)) => true,
                (_, Err(_)) => false,
            };
            if !moved {
                break;
            }
            place = now;
        }
        // The error of the place in which the drive is.
        read(&place?)
    }

    /// `drive.json` of a drive, wherever it is.
    pub(crate) fn manifest_at(&self, id: &DriveId) -> Result<DriveManifest, LakeError> {
        self.at_place(id, |place| match place {
            Place::Loose(dir) => DriveManifest::read(&dir.join(MANIFEST), id),
            Place::Packed(pack, row) => Ok(pack.manifests[*row].clone()),
        })
    }
}
