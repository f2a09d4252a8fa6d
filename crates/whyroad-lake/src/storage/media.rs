//! Camera images in an object store: one object per image, served by short-lived links. Access is checked before a link
//! is made; a link opens only its one object.

use super::mirror::{Mirror, collect};
use super::{Objects, StorageUrl, in_parallel, objects};
use crate::LakeError;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Objects that are remembered as existing.
const MOST_KNOWN: usize = 100_000;

/// An image in an object store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkedMedia {
    /// Key of the object under the prefix of its store.
    pub key: String,
}

/// A prefix with images.
#[derive(Clone, Debug)]
pub struct MediaStore {
    objects: Arc<dyn Objects>,
    /// Folder of the images in the store, with a slash; may be empty.
    folder: String,
    known: Arc<Mutex<BTreeSet<String>>>,
}

impl MediaStore {
    /// Images at a URL; `folder` is below its prefix.
    ///
    /// # Errors
    /// Where this build has no object stores, or credentials are missing.
    pub fn open(url: &StorageUrl, folder: &str) -> Result<Self, LakeError> {
        let folder = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        Ok(Self { objects: objects(url)?, folder, known: Arc::default() })
    }

    /// The image of this name, if it is in the store. A name that leads out of the folder is not.
    ///
    /// # Errors
    /// When the store cannot be reached.
    pub fn find(&self, name: &str) -> Result<Option<LinkedMedia>, LakeError> {
        let leads_out = |part: &str| part.is_empty() || part == "." || part == "..";
        if name.split('/').any(leads_out) || name.contains(['\\', '?', '#']) {
            return Ok(None);
        }
        let key = format!("{}{name}", self.folder);
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if !known().contains(&key) {
            if !self.objects.exists(&key)? {
                return Ok(None);
            }
            let mut known = known();
            if known.len() >= MOST_KNOWN {
                known.clear();
            }
            known.insert(key.clone());
        }
        Ok(Some(LinkedMedia { key }))
    }

    /// Scheme, host and port of the links: where a page must be allowed to load images from.
    ///
    /// # Errors
    /// Where credentials are missing.
    pub fn origin(&self) -> Result<String, LakeError> {
        let link = self.objects.link("x", Duration::from_secs(1))?;
        let end = link.find("://").and_then(|at| link[at + 3..].find('/').map(|end| at + 3 + end));
        Ok(link.get(..end.unwrap_or(link.len())).unwrap_or_default().to_owned())
    }

    /// An address that opens this one image for this long.
    ///
    /// # Errors
    /// Where credentials are missing.
    pub fn link(&self, media: &LinkedMedia, lifetime: Duration) -> Result<String, LakeError> {
        self.objects.link(&media.key, lifetime)
    }

    /// The image itself; `None` where it no longer exists.
    ///
    /// # Errors
    /// When the store cannot be reached.
    pub fn read(&self, media: &LinkedMedia) -> Result<Option<Vec<u8>>, LakeError> {
        Ok(self.objects.get(&media.key)?.map(|(content, _)| content))
    }
}

impl Mirror {
    /// The images that were copied into the lake.
    pub(crate) fn images(&self) -> MediaStore {
        MediaStore { objects: Arc::clone(&self.objects), folder: "media/".to_owned(), known: Arc::default() }
    }

    /// Uploads the images that this process has copied into the lake. Before the table that names them is published.
    pub(super) fn publish_images(&self) -> Result<(), LakeError> {
        let dir = self.dir().join("media");
        let mut images = BTreeMap::new();
        if dir.is_dir() {
            collect(&dir, "media/", &mut images)?;
        }
        let images: Vec<(String, PathBuf)> = images.into_iter().collect();
        in_parallel(&images, |(key, file)| {
            self.objects.upload(file, key)?;
            fs::remove_file(file).map_err(LakeError::io(file))
        })
    }

    /// Whether the store has images of a drive, which the manifest does not state.
    pub(crate) fn has_images(&self, id: &str) -> Result<bool, LakeError> {
        Ok(!self.objects.list(&format!("media/{id}/"))?.is_empty())
    }

    /// Has the images of a drive removed with the next deletion that is published.
    pub(crate) fn forget_images(&self, id: &str) {
        self.state().removed.insert(id.to_owned());
    }
}
