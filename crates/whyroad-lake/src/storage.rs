//! A lake in an object store (`s3://bucket/prefix`): the same files, each an object, and one manifest that names them.
//!
//! - `manifest.json` under the prefix names every file of the lake with its object, length and BLAKE3 hash. What it
//!   does not name is not part of the lake, so readers never see half a drive. It is replaced by a *conditional* put:
//!   of two writers the second reads what the first published, adds its own changes ([`rebase`]) and puts again.
//! - Objects are never changed. Their names hold the hash of the content and a number of the run that wrote them, so
//!   that removing what one writer replaced can never remove what another has just named.
//! - A process works in a folder of its own ([`mirror`]): files are fetched when a drive is first used, from a cache by
//!   content where they are in it ([`cache`]); what was written there is published by [`crate::Lake::publish`].
//! - Camera images are objects under `media/<drive>/`, outside the manifest: there can be millions of them.
//!
//! [`Objects`] is the complete interface to a store. Only `s3` (a cargo feature) uses a network.

mod cache;
mod manifest;
mod media;
mod mirror;
mod publish;
mod rebase;
#[cfg(feature = "s3")]
mod s3;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod url;

pub use media::{LinkedMedia, MediaStore};
pub(crate) use mirror::Mirror;
pub use url::StorageUrl;

use crate::LakeError;
use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, SystemTime};

/// What distinguishes the versions of one object (an ETag).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ObjectVersion(pub String);

/// The kind of change that a writer makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Intent {
    /// Drives, or what was derived from them: each drive by itself.
    Write,
    /// Moves drives into packs: all or nothing; a drive that was replaced meanwhile keeps its folder over the packs.
    Compact,
    /// Removes drives: all or nothing, and the objects at once.
    Delete,
}

/// Result of a conditional put.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PutOutcome {
    /// The object is written and has this version.
    Done(ObjectVersion),
    /// The object is not the expected one; nothing was written.
    Changed,
}

/// An object store under one prefix. Keys are relative to it. Every call blocks.
pub(crate) trait Objects: Debug + Send + Sync {
    /// For messages: without anything secret.
    fn url(&self) -> String;

    /// An object whole; `None` where it does not exist.
    fn get(&self, key: &str) -> Result<Option<(Vec<u8>, ObjectVersion)>, LakeError>;

    /// An object of this length into a new file; false where it does not exist.
    fn download(&self, key: &str, bytes: u64, to: &Path) -> Result<bool, LakeError>;

    /// Writes an object only if it is still the one expected (`None`: only if it does not exist).
    fn put_if(
        &self,
        key: &str,
        content: Vec<u8>,
        expected: Option<&ObjectVersion>,
    ) -> Result<PutOutcome, LakeError>;

    /// Writes an object from a file.
    fn upload(&self, from: &Path, key: &str) -> Result<(), LakeError>;

    /// Removes objects; one that does not exist is not an error.
    fn remove(&self, keys: &[String]) -> Result<(), LakeError>;

    /// Keys that begin with `prefix`, with the time when each was written.
    fn list(&self, prefix: &str) -> Result<Vec<(String, SystemTime)>, LakeError>;

    /// Whether an object exists.
    fn exists(&self, key: &str) -> Result<bool, LakeError>;

    /// An address with which anybody can read this one object, for this long.
    fn link(&self, key: &str, lifetime: Duration) -> Result<String, LakeError>;
}

/// The store that a URL names.
#[cfg(feature = "s3")]
pub(crate) fn objects(url: &StorageUrl) -> Result<Arc<dyn Objects>, LakeError> {
    Ok(Arc::new(s3::S3Objects::open(url)?))
}

/// The store that a URL names: none in a build without the feature.
#[cfg(not(feature = "s3"))]
pub(crate) fn objects(url: &StorageUrl) -> Result<Arc<dyn Objects>, LakeError> {
    Err(LakeError::NoS3(url.to_string()))
}

/// Maximum number of concurrent calls.
const PARALLEL_CALLS: usize = 16;

/// Does the work on every item, several at once: the work waits for a network. The first error stops it.
pub(crate) fn in_parallel<T: Sync>(
    items: &[T],
    work: impl Fn(&T) -> Result<(), LakeError> + Sync,
) -> Result<(), LakeError> {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::{Mutex, PoisonError};
    if let [one] = items {
        return work(one);
    }
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
    let run = || {
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            if let Err(e) = work(item) {
                next.store(items.len(), Ordering::Relaxed);
                failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(e);
            }
        }
    };
    std::thread::scope(|scope| {
        (0..PARALLEL_CALLS.min(items.len())).for_each(|_| drop(scope.spawn(run)));
    });
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}
