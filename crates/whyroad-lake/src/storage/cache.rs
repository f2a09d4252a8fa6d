//! The cache of one machine: objects by content, shared by all lakes and processes, and the folders in which processes
//! work. Both may be removed at any time when no process runs.

use super::Objects;
use super::manifest::StoredFile;
use crate::LakeError;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Names the folder of the cache.
const FOLDER_VARIABLE: &str = "WHYROAD_CACHE";
/// Maximum size of the cache, in GB.
const SIZE_VARIABLE: &str = "WHYROAD_CACHE_GB";
const DEFAULT_GB: u64 = 50;
/// A download that has not grown for so long belongs to a killed process.
const ABANDONED: Duration = Duration::from_secs(3600);

/// A cache.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    dir: PathBuf,
}

impl Cache {
    /// The cache of this user, reduced to its maximum size, without what killed processes left.
    pub fn open() -> Result<Self, LakeError> {
        let gigabytes = std::env::var(SIZE_VARIABLE).ok().and_then(|n| n.parse().ok()).unwrap_or(DEFAULT_GB);
        Self::at(folder(), gigabytes.saturating_mul(1_000_000_000))
    }

    /// A cache in this folder, of at most this many bytes.
    pub fn at(dir: PathBuf, most: u64) -> Result<Self, LakeError> {
        for sub in ["objects", "open"] {
            let path = dir.join(sub);
            fs::create_dir_all(&path).map_err(LakeError::io(&path))?;
        }
        let cache = Self { dir };
        cache.remove_left_over();
        cache.reduce(most);
        Ok(cache)
    }

    fn path(&self, hash: &str) -> PathBuf {
        self.dir.join("objects").join(hash.get(..2).unwrap_or("__")).join(hash)
    }

    /// Puts the file at `to`, from the cache or from the store; false where the store does not have the object.
    pub fn fetch(&self, objects: &dyn Objects, file: &StoredFile, to: &Path) -> Result<bool, LakeError> {
        let held = self.path(&file.blake3);
        // Of another length: written when the machine lost power.
        let whole = fs::metadata(&held).is_ok_and(|held| held.len() == file.bytes);
        if whole && place(&held, to).is_ok() {
            return Ok(true);
        }
        let part = self.dir.join("objects").join(format!(".{}", unique()));
        let found = objects.download(&file.key, file.bytes, &part).inspect_err(|_| {
            // The error that made it fail is the one to report.
            let _ = fs::remove_file(&part);
        })?;
        if !found {
            return Ok(false);
        }
        let hash = hash(&part)?;
        if hash != file.blake3 {
            let _ = fs::remove_file(&part);
            let reason =
                format!("the object {} does not have the content that the manifest states", file.key);
            return Err(LakeError::Storage { url: objects.url(), reason });
        }
        let _ = fs::remove_file(&held);
        self.keep(&part, &file.blake3);
        let placed = place(&held, to).or_else(|_| place(&part, to));
        let _ = fs::remove_file(&part);
        placed.map_err(LakeError::io(to))?;
        Ok(true)
    }

    /// Keeps a file that this process has written, so that it need not be fetched. It is never changed in place.
    pub fn keep(&self, file: &Path, hash: &str) {
        let held = self.path(hash);
        let kept = held.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| {
            // Elsewhere, a file without this right could not be removed.
            if cfg!(unix) {
                let mut permissions = fs::metadata(file)?.permissions();
                permissions.set_readonly(true);
                fs::set_permissions(file, permissions)?;
            }
            place(file, &held)
        });
        // A cache that cannot keep it costs time only.
        drop(kept);
    }

    /// Removes every object except those with these hashes, and what killed processes left of downloads. Earlier forms
    /// of a drive are cached under hashes that no manifest names any more.
    pub fn retain(&self, hashes: &BTreeSet<&str>) -> Result<(), LakeError> {
        let objects = self.dir.join("objects");
        let abandoned = |path: &Path| {
            let modified = fs::metadata(path).and_then(|data| data.modified());
            modified.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > ABANDONED))
        };
        for sub in fs::read_dir(&objects).map_err(LakeError::io(&objects))?.flatten().map(|e| e.path()) {
            let held = match fs::read_dir(&sub) {
                Ok(held) => held.flatten().map(|e| e.path()).collect(),
                Err(_) => vec![sub],
            };
            for path in held {
                let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                if hashes.contains(name) || (name.starts_with('.') && !abandoned(&path)) {
                    continue;
                }
                match fs::remove_file(&path) {
                    Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(LakeError::io(&path)(e)),
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// An empty folder for this process.
    pub fn folder(&self) -> Result<WorkFolder, LakeError> {
        let dir = self.dir.join("open").join(unique());
        fs::create_dir_all(&dir).map_err(LakeError::io(&dir))?;
        let lock = lock_of(&dir);
        let file = File::create(&lock).map_err(LakeError::io(&lock))?;
        // Where locks are not supported, leftovers are not removed.
        let _ = file.try_lock();
        Ok(WorkFolder { dir, lock: Some(file) })
    }

    /// Removes the folders of processes that were killed: their locks are free.
    fn remove_left_over(&self) {
        let open = self.dir.join("open");
        for entry in fs::read_dir(&open).into_iter().flatten().flatten() {
            let dir = entry.path();
            if !dir.is_dir() {
                continue;
            }
            let Ok(file) = File::open(lock_of(&dir)) else { continue };
            if file.try_lock().is_ok() {
                let _ = fs::remove_dir_all(&dir);
                let _ = fs::remove_file(lock_of(&dir));
            }
        }
    }

    /// Removes the oldest objects until the rest is at most `most` bytes. What a process uses stays in its folder.
    fn reduce(&self, most: u64) {
        let mut held = Vec::new();
        for sub in fs::read_dir(self.dir.join("objects")).into_iter().flatten().flatten() {
            for entry in fs::read_dir(sub.path()).into_iter().flatten().flatten() {
                if let Ok(data) = entry.metadata() {
                    held.push((data.modified().unwrap_or(UNIX_EPOCH), data.len(), entry.path()));
                }
            }
        }
        let mut total: u64 = held.iter().map(|(_, bytes, _)| bytes).sum();
        held.sort();
        for (_, bytes, path) in held {
            if total <= most {
                break;
            }
            if fs::remove_file(path).is_ok() {
                total -= bytes;
            }
        }
    }
}

/// A folder that is removed with the process.
#[derive(Debug)]
pub(super) struct WorkFolder {
    pub dir: PathBuf,
    lock: Option<File>,
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        // Remaining files are removed by the next process.
        let _ = fs::remove_dir_all(&self.dir);
        drop(self.lock.take());
        let _ = fs::remove_file(lock_of(&self.dir));
    }
}

fn lock_of(dir: &Path) -> PathBuf {
    dir.with_extension("lock")
}

fn folder() -> PathBuf {
    let named = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    named(FOLDER_VARIABLE)
        .or_else(|| named("XDG_CACHE_HOME").map(|d| d.join("whyroad")))
        .or_else(|| named("HOME").map(|d| d.join(".cache").join("whyroad")))
        .or_else(|| named("LOCALAPPDATA").map(|d| d.join("whyroad").join("cache")))
        .unwrap_or_else(|| std::env::temp_dir().join("whyroad-cache"))
}

/// The file under another name, without a copy where the file system can.
fn place(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Err(e),
        Err(_) => {
            let part = to.with_file_name(format!(".{}", unique()));
            fs::copy(from, &part)?;
            fs::rename(&part, to)
        }
        Ok(()) => Ok(()),
    }
}

pub(super) fn hash(path: &Path) -> Result<String, LakeError> {
    let mut hasher = blake3::Hasher::new();
    let mut file = File::open(path).map_err(LakeError::io(path))?;
    io::copy(&mut file, &mut hasher).map_err(LakeError::io(path))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// A name that no other process or call has.
pub(super) fn unique() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let nanos = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos());
    // The address of a fresh allocation differs between machines that share a clock and process ids.
    let place = std::ptr::from_ref(&nanos).addr();
    let seed = format!("{nanos} {} {} {place}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let host = fs::read_to_string("/etc/hostname").unwrap_or_default();
    blake3::hash(format!("{seed} {host}").as_bytes()).to_hex().chars().take(16).collect()
}
