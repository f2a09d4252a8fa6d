//! Publishing a mined folder atomically: it is written beside its final path and moved there in one step.
//!
//! On Linux the new folder and the one in its place are exchanged by one system call. Where that does not exist (other
//! systems, some network file systems) the old folder is first renamed aside; a reader can then find none for a moment.

use super::{MinedFile, MinedFolder, MinedWriteError, MiningQuestion, error::io};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// A folder could not be published.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// The file system refused.
    #[error(transparent)]
    Write(#[from] MinedWriteError),
    /// The folder holds the results of another question.
    #[error("{} holds the results of another question", .0.display())]
    OtherQuestion(PathBuf),
    /// The folder holds files that no mining run wrote; publishing would remove them.
    #[error("{} holds '{}', which is not a file of a mined folder", .dir.display(), .name)]
    OtherFiles {
        /// The folder.
        dir: PathBuf,
        /// The first such file.
        name: String,
    },
    /// Another process publishes into the same place.
    #[error("another process is writing {}", .0.display())]
    Busy(PathBuf),
}

/// Name of the file in a mined folder that is locked while the folder is written.
const LOCK: &str = ".lock";

/// Held by the process that writes a mined folder, or replaces it.
pub struct FolderLock {
    path: PathBuf,
    file: File,
}

impl FolderLock {
    /// Locks a folder, which is made if it does not exist.
    ///
    /// # Errors
    /// [`PublishError::Busy`] where another process writes it.
    pub fn take(dir: &Path) -> Result<Self, PublishError> {
        fs::create_dir_all(dir).map_err(io(dir))?;
        Self::at(dir.join(LOCK), dir)
    }

    /// Locks a file; `of` is the folder that it stands for.
    fn at(path: PathBuf, of: &Path) -> Result<Self, PublishError> {
        let file = File::create(&path).map_err(io(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(PublishError::Busy(of.to_owned())),
            // A file system without locks: there, one process at a time must write.
            Err(TryLockError::Error(_)) => {}
        }
        // The process that held it may have removed the file between opening and locking.
        if is_at(&file, &path) { Ok(Self { path, file }) } else { Err(PublishError::Busy(of.to_owned())) }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // In a folder that was replaced meanwhile there may be that of another process.
        if is_at(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// A path for which a folder is being written. An unfinished folder is removed when this is dropped.
pub struct Publication {
    out: PathBuf,
    fresh: PathBuf,
    /// Beside the path: excludes others that publish there.
    _beside: FolderLock,
    /// In the folder that is there already: excludes a run that writes into it.
    _inside: Option<FolderLock>,
}

impl Publication {
    /// Checks the path `out` and makes an empty folder beside it. With `replace`, results of another question may be
    /// there.
    pub fn begin(out: &Path, question: &MiningQuestion, replace: bool) -> Result<Self, PublishError> {
        if let Some(folder) = MinedFolder::open(out)
            && !replace
            && folder.question().as_ref() != Some(question)
        {
            return Err(PublishError::OtherQuestion(out.to_owned()));
        }
        if let Some(name) = other_file(out) {
            return Err(PublishError::OtherFiles { dir: out.to_owned(), name });
        }
        let place = Self::lock(out)?;
        fs::create_dir(&place.fresh).map_err(io(&place.fresh))?;
        Ok(place)
    }

    /// Removes what a killed process left beside the path.
    pub fn sweep(out: &Path) -> Result<(), PublishError> {
        Self::lock(out).map(drop)
    }

    /// Locks the path and removes what a killed process left.
    fn lock(out: &Path) -> Result<Self, PublishError> {
        let parent = match out.parent() {
            Some(p) if !p.as_os_str().is_empty() => p.to_owned(),
            _ => PathBuf::from("."),
        };
        fs::create_dir_all(&parent).map_err(io(&parent))?;
        let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let beside = |what: &str| parent.join(format!(".{name}.{what}"));
        let (locked, fresh, old) = (beside("lock"), beside("new"), beside("old"));
        let beside_it = FolderLock::at(locked, out)?;
        // Moved aside for a folder that was never completed: it is the only copy.
        if old.exists() && !out.exists() {
            fs::rename(&old, out).map_err(io(out))?;
        }
        let inside = out.is_dir().then(|| FolderLock::take(out)).transpose()?;
        remove(&fresh)?;
        remove(&old)?;
        Ok(Self { out: out.to_owned(), fresh, _beside: beside_it, _inside: inside })
    }

    /// The folder to write to.
    pub fn folder(&self) -> &Path {
        &self.fresh
    }

    /// Moves the folder into place.
    pub fn publish(self) -> Result<(), PublishError> {
        if !self.out.exists() {
            fs::rename(&self.fresh, &self.out).map_err(io(&self.out))?;
        } else if !exchange(&self.fresh, &self.out) {
            let old = self.fresh.with_extension("old");
            fs::rename(&self.out, &old).map_err(io(&self.out))?;
            fs::rename(&self.fresh, &self.out).map_err(io(&self.out))?;
            remove(&old)?;
        }
        Ok(())
    }
}

impl Drop for Publication {
    fn drop(&mut self) {
        // After an exchange this is the folder that was replaced.
        let _ = fs::remove_dir_all(&self.fresh);
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |m: fs::Metadata| (m.dev(), m.ino());
    matches!((file.metadata().map(id), fs::metadata(path).map(id)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(target_os = "linux")]
fn exchange(a: &Path, b: &Path) -> bool {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE).is_ok()
}

#[cfg(not(target_os = "linux"))]
fn exchange(_: &Path, _: &Path) -> bool {
    false
}

/// The first file that no mining run writes, by name.
fn other_file(dir: &Path) -> Option<String> {
    const ALL: [MinedFile; 10] = [
        MinedFile::Question,
        MinedFile::Episodes,
        MinedFile::EpisodeTable,
        MinedFile::PreLabels,
        MinedFile::KeyframeSuggestions,
        MinedFile::Clips,
        MinedFile::Coverage,
        MinedFile::Results,
        MinedFile::SingleResult,
        MinedFile::Ledger,
    ];
    let known = |name: &str| {
        name == LOCK
            || ALL
                .iter()
                .any(|f| name == f.name() || name.strip_prefix('.') == Some(&format!("{}.part", f.name())))
    };
    let names = fs::read_dir(dir).into_iter().flatten().flatten();
    names.map(|e| e.file_name().to_string_lossy().into_owned()).filter(|n| !known(n)).min()
}

fn remove(dir: &Path) -> Result<(), MinedWriteError> {
    match fs::remove_dir_all(dir) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(io(dir)(e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn question() -> MiningQuestion {
        MiningQuestion::Framework { scenarios: vec![] }
    }

    fn put(out: &Path, text: &str) {
        let new = Publication::begin(out, &question(), false).unwrap();
        fs::write(MinedFile::Episodes.path(new.folder()), text).unwrap();
        fs::write(MinedFile::Question.path(new.folder()), serde_json::to_vec(&question()).unwrap()).unwrap();
        new.publish().unwrap();
    }

    #[test]
    fn a_folder_takes_its_place_whole_and_leaves_nothing_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("mined");
        put(&out, "one");
        put(&out, "two");
        assert_eq!(fs::read_to_string(out.join("episodes.jsonl")).unwrap(), "two");
        drop(Publication::begin(&out, &question(), false).unwrap());
        assert_eq!(fs::read_to_string(out.join("episodes.jsonl")).unwrap(), "two", "not published");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_a_killed_process_left_is_cleared_away_or_put_back() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("mined");
        put(&out, "one");
        fs::create_dir(dir.path().join(".mined.new")).unwrap();
        fs::rename(&out, dir.path().join(".mined.old")).unwrap();
        Publication::sweep(&out).unwrap();
        assert_eq!(fs::read_to_string(out.join("episodes.jsonl")).unwrap(), "one");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert_eq!(MinedFolder::find(dir.path()).unwrap().len(), 1);
        fs::rename(&out, dir.path().join(".mined.new")).unwrap();
        assert!(MinedFolder::find(dir.path()).unwrap().is_empty(), "what is being written is not there yet");
    }

    #[test]
    fn a_folder_that_a_run_writes_is_neither_written_nor_replaced_by_another() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("mined");
        put(&out, "one");
        let held = FolderLock::take(&out).unwrap();
        assert!(matches!(FolderLock::take(&out), Err(PublishError::Busy(_))));
        assert!(matches!(Publication::begin(&out, &question(), true), Err(PublishError::Busy(_))));
        drop(held);
        // What a killed process left does not lock.
        fs::write(out.join(LOCK), "").unwrap();
        let new = Publication::begin(&out, &question(), false).unwrap();
        assert!(matches!(FolderLock::take(&out), Err(PublishError::Busy(_))));
        new.publish().unwrap();
        // The lock of a folder that was replaced is not that of the new one.
        let held = FolderLock::take(&out).unwrap();
        let other = dir.path().join("other");
        fs::rename(&out, &other).unwrap();
        let new = FolderLock::take(&out).unwrap();
        drop(held);
        assert!(matches!(FolderLock::take(&out), Err(PublishError::Busy(_))));
        drop(new);
        assert!(!out.join(LOCK).exists() && FolderLock::take(&out).is_ok());
    }

    #[test]
    fn what_would_be_lost_is_not_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("mined");
        put(&out, "one");
        let other = MiningQuestion::Framework { scenarios: vec!["safety".parse().unwrap()] };
        let refused = |question: &MiningQuestion, replace| Publication::begin(&out, question, replace).err();
        assert!(matches!(refused(&other, false), Some(PublishError::OtherQuestion(_))));
        assert!(refused(&other, true).is_none());
        let busy = Publication::begin(&out, &question(), false).unwrap();
        assert!(matches!(refused(&question(), false), Some(PublishError::Busy(_))));
        drop(busy);
        fs::write(out.join("notes.txt"), "mine").unwrap();
        let found = refused(&question(), true);
        assert!(matches!(found, Some(PublishError::OtherFiles { name, .. }) if name == "notes.txt"));
    }
}
