//! The folder in which a process works on a lake in an object store: it looks like a lake on disk, and its files are
//! fetched when they are needed. `drive.json` of loose drives and the catalog are fetched at once, so that listing
//! works as usual; the folder of a drive or pack is there from the start, and empty until it is used.
//!
//! A file that was fetched is known by its identity (length, time, number): so changes by the process are found by
//! comparison, and functions that write need no knowledge of object stores.

use super::cache::{Cache, WorkFolder, hash, unique};
use super::manifest::{self, Manifest, StoredFile, folder};
use super::rebase::{Change, Changes};
use super::{ObjectVersion, Objects, PutOutcome, in_parallel};
use crate::LakeError;
use crate::lake::MANIFEST as DRIVE_JSON;
use crate::leftovers::UNFINISHED;
use crate::packs::fingerprint::identity;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Fetches of the same drive by several threads wait for each other.
const FETCH_LOCKS: usize = 64;
/// Maximum time until a service sees what others publish.
const REFRESH_EVERY: Duration = if cfg!(test) { Duration::ZERO } else { Duration::from_secs(10) };

/// A process's copy of a lake.
#[derive(Debug)]
pub(crate) struct Mirror {
    pub(super) objects: Arc<dyn Objects>,
    pub(super) cache: Cache,
    work: WorkFolder,
    /// In the names of the objects that this process writes.
    pub(super) run: String,
    state: Mutex<State>,
    fetching: Vec<Mutex<()>>,
    refreshed: Mutex<Instant>,
}

/// What the process knows about the store.
#[derive(Debug, Default)]
pub(super) struct State {
    /// The manifest on which the folder is based, and its version.
    pub base: Manifest,
    pub version: Option<ObjectVersion>,
    /// Files that were fetched or published, as they were then.
    pub known: BTreeMap<String, String>,
    /// Drives that were removed, whose images are to be removed.
    pub removed: BTreeSet<String>,
}

/// A file to be uploaded for a change.
pub(super) struct Upload {
    pub from: PathBuf,
    pub key: String,
}

impl Mirror {
    /// The lake under a prefix; `None` where there is none.
    pub fn open(objects: Arc<dyn Objects>) -> Result<Option<Self>, LakeError> {
        Self::open_with(objects, Cache::open()?)
    }

    /// [`Mirror::open`]; makes an empty lake where there is none.
    pub fn create_or_open(objects: Arc<dyn Objects>) -> Result<Self, LakeError> {
        Self::create_or_open_with(objects, Cache::open()?)
    }

    pub(super) fn open_with(objects: Arc<dyn Objects>, cache: Cache) -> Result<Option<Self>, LakeError> {
        let Some((text, version)) = objects.get(manifest::KEY)? else { return Ok(None) };
        let base = Manifest::parse(&text, &objects.url())?;
        let state = State { base: Manifest::default(), version: Some(version.clone()), ..State::default() };
        let mirror = Self {
            work: cache.folder()?,
            objects,
            cache,
            run: unique().chars().take(8).collect(),
            state: Mutex::new(state),
            fetching: (0..FETCH_LOCKS).map(|_| Mutex::new(())).collect(),
            refreshed: Mutex::new(Instant::now()),
        };
        let drives = mirror.work.dir.join("drives");
        fs::create_dir_all(&drives).map_err(LakeError::io(&drives))?;
        mirror.follow(&Manifest::default(), base, version)?;
        Ok(Some(mirror))
    }

    pub(super) fn create_or_open_with(objects: Arc<dyn Objects>, cache: Cache) -> Result<Self, LakeError> {
        if objects.get(manifest::KEY)?.is_none() {
            found_lake(&*objects)?;
        }
        let url = objects.url();
        Self::open_with(objects, cache)?.ok_or_else(|| LakeError::NotALake(PathBuf::from(url)))
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.work.dir
    }

    /// Takes over what others have published, from time to time: for a long-running process that writes nothing
    /// persistent.
    pub fn refresh(&self) -> Result<(), LakeError> {
        {
            let mut last = self.refreshed.lock().unwrap_or_else(PoisonError::into_inner);
            if last.elapsed() < REFRESH_EVERY {
                return Ok(());
            }
            *last = Instant::now();
        }
        let (next, version) = self.read()?;
        let known = {
            let state = self.state();
            if state.version.as_ref() == Some(&version) {
                return Ok(());
            }
            state.base.clone()
        };
        self.follow(&known, next, version)
    }

    /// Whether the store can be read now.
    pub fn ready(&self) -> Result<(), LakeError> {
        self.read().map(drop)
    }

    /// For messages.
    pub fn url(&self) -> String {
        self.objects.url()
    }

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Updates the folder from `known` (with its own changes) to `next`. A drive that others changed is fetched again
    /// when it is next used.
    pub(super) fn follow(
        &self,
        known: &Manifest,
        next: Manifest,
        version: ObjectVersion,
    ) -> Result<(), LakeError> {
        let differs = |path: &str| {
            let hash = |of: &Manifest| of.files.get(path).map(|f| f.blake3.clone());
            hash(known) != hash(&next)
        };
        let paths: BTreeSet<&String> = known.files.keys().chain(next.files.keys()).collect();
        let changed: BTreeSet<String> = paths
            .into_iter()
            .filter(|path| differs(path))
            .map(|path| folder(path).unwrap_or(path).to_owned())
            .collect();
        let mut eager = Vec::new();
        {
            let mut state = self.state();
            for unit in &changed {
                let at = self.work.dir.join(unit);
                let removed = if at.is_dir() { fs::remove_dir_all(&at) } else { fs::remove_file(&at) };
                removed
                    .or_else(|e| if e.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(e) })
                    .map_err(LakeError::io(&at))?;
                let below = format!("{unit}/");
                state.known.retain(|path, _| path != unit && !path.starts_with(&below));
                for (path, file) in next.below(unit).filter(|(p, _)| *p == unit || p.starts_with(&below)) {
                    let is_head =
                        folder(path).is_none() || path.strip_prefix(&below).is_some_and(|n| n == DRIVE_JSON);
                    if is_head {
                        eager.push((path.clone(), file.clone()));
                    }
                }
            }
            for path in next.files.keys() {
                if let Some(unit) = folder(path) {
                    let at = self.work.dir.join(unit);
                    if !at.is_dir() {
                        fs::create_dir_all(&at).map_err(LakeError::io(&at))?;
                    }
                }
            }
            state.base = next;
            state.version = Some(version);
        }
        self.fetch(eager)
    }

    /// Fetches what is missing of a drive or pack.
    pub fn fetch_folder(&self, folder: &str) -> Result<(), LakeError> {
        self.fetch_files(folder, |_| true)
    }

    /// Fetches the files of a drive or pack that are wanted by their path in it.
    pub fn fetch_files(&self, folder: &str, wanted: impl Fn(&str) -> bool) -> Result<(), LakeError> {
        let below = format!("{folder}/");
        let missing = || -> Vec<(String, StoredFile)> {
            let state = self.state();
            let of = state.base.below(&below).filter(|(path, _)| !state.known.contains_key(*path));
            let of = of.filter(|(path, _)| wanted(&path[below.len()..]));
            of.map(|(path, file)| (path.clone(), file.clone())).collect()
        };
        // A missing folder means that this process has removed the drive.
        if missing().is_empty() || !self.work.dir.join(folder).is_dir() {
            return Ok(());
        }
        let slot = blake3::hash(folder.as_bytes()).as_bytes()[0] as usize % FETCH_LOCKS;
        let _lock = self.fetching[slot].lock().unwrap_or_else(PoisonError::into_inner);
        self.fetch(missing())
    }

    /// Fetches the folders of all loose drives.
    pub fn fetch_loose(&self) -> Result<(), LakeError> {
        let loose: Vec<(String, StoredFile)> = {
            let state = self.state();
            let of = state.base.below("drives/").filter(|(path, _)| !state.known.contains_key(*path));
            of.filter(|(path, _)| folder(path).is_some_and(|f| self.work.dir.join(f).is_dir()))
                .map(|(path, file)| (path.clone(), file.clone()))
                .collect()
        };
        self.fetch(loose)
    }

    /// Hash of a file's content as the manifest states it, fetched or not.
    pub fn content(&self, path: &str) -> Option<String> {
        self.state().base.files.get(path).map(|file| file.blake3.clone())
    }

    /// Length of all files of a drive, fetched or not.
    pub fn bytes(&self, folder: &str) -> u64 {
        let (below, state) = (format!("{folder}/"), self.state());
        state.base.below(&below).map(|(_, file)| file.bytes).sum()
    }

    fn fetch(&self, files: Vec<(String, StoredFile)>) -> Result<(), LakeError> {
        in_parallel(&files, |(path, file)| {
            let to = self.work.dir.join(path);
            if let Some(parent) = to.parent() {
                fs::create_dir_all(parent).map_err(LakeError::io(parent))?;
            }
            let found = if folder(path).is_none() && !path.starts_with("packs/") {
                // Some files of the lake itself are added to in place, which would change the cache.
                self.objects
                    .get(&file.key)?
                    .map(|(text, _)| fs::write(&to, text))
                    .transpose()
                    .map_err(LakeError::io(&to))?
                    .is_some()
            } else {
                self.cache.fetch(&*self.objects, file, &to)?
            };
            if !found {
                return Err(LakeError::ChangedMeanwhile { url: self.url(), what: vec![path.clone()] });
            }
            self.state().known.insert(path.clone(), identity(&to));
            Ok(())
        })
    }

    /// What this process has changed, and the files to upload for that.
    pub(super) fn changes(&self) -> Result<(Changes, Vec<Upload>), LakeError> {
        let mut found = BTreeMap::new();
        collect(&self.work.dir, "", &mut found)?;
        let (mut changes, mut uploads) = (Changes::new(), Vec::new());
        let mut state = self.state();
        for (path, at) in &found {
            let now = identity(at);
            if state.known.get(path) == Some(&now) {
                continue;
            }
            let blake3 = hash(at)?;
            if state.base.files.get(path).is_some_and(|f| f.blake3 == blake3) {
                state.known.insert(path.clone(), now);
                continue;
            }
            let bytes = fs::metadata(at).map_err(LakeError::io(at))?.len();
            let key = self.key(path, &blake3);
            uploads.push(Upload { from: at.clone(), key: key.clone() });
            changes.insert(path.clone(), Change::Put(StoredFile { key, bytes, blake3 }));
        }
        let is_gone = |path: &str| {
            state.known.contains_key(path) || folder(path).is_some_and(|f| !self.work.dir.join(f).is_dir())
        };
        for path in state.base.files.keys() {
            if !found.contains_key(path) && is_gone(path) {
                changes.insert(path.clone(), Change::Remove);
            }
        }
        Ok((changes, uploads))
    }

    /// The object of a file: its path, made unique.
    fn key(&self, path: &str, blake3: &str) -> String {
        let mark = format!("{}-{}", blake3.get(..16).unwrap_or(blake3), self.run);
        let (folder, name) = path.rsplit_once('/').map_or(("", path), |(f, n)| (f, n));
        let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "bin"));
        let name = format!("{stem}.{mark}.{extension}");
        if folder.is_empty() { name } else { format!("{folder}/{name}") }
    }
}

/// Makes an empty lake, and tests the guarantee on which concurrent writers depend: some stores accept conditional puts
/// and ignore the condition.
fn found_lake(objects: &dyn Objects) -> Result<(), LakeError> {
    let empty = || Manifest::default().to_bytes();
    let PutOutcome::Done(version) = objects.put_if(manifest::KEY, empty(), None)? else {
        // Another process was first and runs the test.
        return Ok(());
    };
    let other = ObjectVersion(format!("\"{}\"", "0".repeat(32)));
    let keeps = other != version
        && objects.put_if(manifest::KEY, empty(), None)? == PutOutcome::Changed
        && objects.put_if(manifest::KEY, empty(), Some(&other))? == PutOutcome::Changed;
    if keeps { Ok(()) } else { Err(LakeError::Unconditional(objects.url())) }
}

/// The files of a lake's folder by path, without what is being written (among packs, a name with a leading dot); images
/// are not among the files of the manifest.
pub(super) fn collect(
    dir: &Path,
    prefix: &str,
    found: &mut BTreeMap<String, PathBuf>,
) -> Result<(), LakeError> {
    for entry in fs::read_dir(dir).map_err(LakeError::io(dir))? {
        let entry = entry.map_err(LakeError::io(dir))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') || (prefix.is_empty() && ["media", UNFINISHED].contains(&name.as_str())) {
            continue;
        }
        let path = format!("{prefix}{name}");
        if entry.file_type().map_err(LakeError::io(dir))?.is_dir() {
            collect(&entry.path(), &format!("{path}/"), found)?;
        } else {
            found.insert(path, entry.path());
        }
    }
    Ok(())
}
