//! Compaction: loose drives into packs, small packs into larger ones; and removing drives from packs.
//!
//! Invariants at every moment, also after a kill: the drives are those of the catalog and those with a folder of
//! their own, each once. New packs are complete on the disk before the catalog names them; the folders that went into
//! them, and packs that the catalog no longer names, are removed after that. A folder is removed only while it is
//! still the one that was packed, which the pack records; a killed removal is finished by the next compaction.

use super::catalog::{Catalog, DriveEntry};
use super::member::Member;
use super::open_pack::{OpenPack, SIGNALS};
use super::splice::Schemas;
use super::{fingerprint, lock, write};
use crate::lake::remove_dir;
use crate::manifest::is_drive;
use crate::storage::Intent;
use crate::{Lake, LakeError};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use whyroad_model::DriveId;

/// How to pack.
#[derive(Clone, Copy, Debug)]
pub struct CompactionOptions {
    /// Maximum size of a pack, bytes over all its files.
    pub pack_bytes: u64,
    /// Maximum number of drives in a pack: the footers of its files grow with it.
    pub pack_drives: usize,
    /// Whether stored signals are kept; without them, the first evaluation of a rule derives them again.
    pub keep_signals: bool,
}

impl Default for CompactionOptions {
    fn default() -> Self {
        Self { pack_bytes: 400_000_000, pack_drives: 256, keep_signals: true }
    }
}

/// What a compaction did.
#[derive(Debug, Default)]
pub struct Compaction {
    /// Drives that were loose, or had something loose, and are in a pack now.
    pub packed: usize,
    /// Drives in packs.
    pub drives: usize,
    /// Packs.
    pub packs: usize,
    /// Packs written.
    pub written: usize,
    /// Packs that were replaced, or left over from a killed process, and are removed.
    pub removed: usize,
    /// Bytes of the row groups of all packs.
    pub bytes: u64,
    /// Drives that stay loose, with the reason.
    pub left: Vec<(DriveId, LakeError)>,
}

/// A folder of a drive.
#[derive(Clone, Debug)]
struct Folder {
    /// With a `drive.json`: all of the drive. Without: signals and small files that override those of a pack.
    whole: bool,
    fingerprint: String,
    bytes: u64,
}

/// New packs that the catalog does not name yet.
struct Written {
    packs: usize,
    /// Number of the next pack.
    next_pack: u64,
    entries: Vec<DriveEntry>,
    /// Drives, or files that override theirs, that cannot be read.
    left: Vec<(DriveId, LakeError)>,
    /// Folders that went into the packs.
    packed: BTreeMap<DriveId, Folder>,
}

/// Where a drive to be packed is now.
struct Source {
    id: DriveId,
    pack: Option<(Arc<OpenPack>, usize)>,
    folder: Option<Folder>,
    bytes: u64,
}

impl Lake {
    /// Packs all loose drives. Repeating it changes nothing. `done` is called with the number of drives written so far
    /// and of all to write, from any thread.
    ///
    /// # Errors
    /// Where a pack cannot be read or written; then the lake is as before. A loose drive that cannot be read stays
    /// loose and is in [`Compaction::left`].
    pub fn compact(
        &self,
        options: &CompactionOptions,
        done: impl Fn(usize, usize) + Sync,
    ) -> Result<Compaction, LakeError> {
        if let Some(mirror) = &self.mirror {
            mirror.fetch_loose()?;
        }
        self.remove_leftovers();
        self.mark_packed()?;
        let _lock = lock::packing(self.dir())?;
        let mut out = Compaction { removed: self.remove_unnamed()?, ..Compaction::default() };
        let catalog = self.catalog()?;
        let folders = self.remove_packed(self.folders()?)?;
        let packs = packs_of(&catalog);
        let is_dirty = |pack: &str, positions: &[usize]| {
            let drive = |at: &usize| folders.contains_key(&catalog.entry(*at).drive_id);
            positions.iter().any(drive)
                || (!options.keep_signals && self.packs_dir().join(pack).join(SIGNALS).exists())
        };
        let mut rewritten: BTreeSet<&str> =
            packs.iter().filter(|(name, at)| is_dirty(name, at)).map(|(name, _)| name.as_str()).collect();
        let loose = folders.iter().filter(|(id, f)| f.whole || catalog.find(id).is_some()).count();
        let small: Vec<(&str, usize, u64)> = packs
            .iter()
            .map(|(name, at)| {
                (name.as_str(), at.len(), at.iter().map(|i| catalog.entry(*i).bytes).sum::<u64>())
            })
            .filter(|(_, n, bytes)| *n < options.pack_drives / 2 && *bytes < options.pack_bytes / 4)
            .collect();
        let (drives, bytes) = small.iter().fold((0, 0), |(n, b), (_, drives, bytes)| (n + drives, b + bytes));
        let merged = drives
            .div_ceil(options.pack_drives.max(1))
            .max(usize::try_from(bytes.div_ceil(options.pack_bytes.max(1))).unwrap_or(usize::MAX));
        // Small packs are merged with what is new, or with each other where that makes fewer of them.
        if loose > 0 || merged < small.len() {
            rewritten.extend(small.iter().map(|(name, ..)| *name));
        }
        let rewritten: BTreeSet<String> = rewritten.into_iter().map(str::to_owned).collect();
        let sources = self.sources(&catalog, &rewritten, &folders, &BTreeSet::new())?;
        if sources.is_empty() && rewritten.is_empty() {
            out.count(&catalog);
            self.publish_as(Intent::Compact)?;
            return Ok(out);
        }
        let written = self.write_packs(&catalog, sources, options, &done)?;
        let catalog = self.put_catalog(&catalog, &rewritten, written.entries, written.next_pack)?;
        self.remove_packed(written.packed)?;
        out.removed += self.remove_unnamed()?;
        self.publish_as(Intent::Compact)?;
        out.written = written.packs;
        out.packed = loose - written.left.len();
        out.left = written.left;
        out.count(&catalog);
        Ok(out)
    }

    /// Takes drives out of the packs that hold them, by writing these packs again without them.
    pub(crate) fn unpack_away(&self, ids: &BTreeSet<DriveId>) -> Result<(), LakeError> {
        if !self.packs_dir().is_dir() {
            return Ok(());
        }
        let _lock = lock::packing(self.dir())?;
        self.remove_unnamed()?;
        let catalog = self.catalog()?;
        let mut rewritten = BTreeSet::new();
        for id in ids {
            if let Some(at) = catalog.find(id) {
                rewritten.insert(catalog.location(at).0.to_owned());
            }
        }
        if rewritten.is_empty() {
            return Ok(());
        }
        let sources = self.sources(&catalog, &rewritten, &BTreeMap::new(), ids)?;
        let options = CompactionOptions::default();
        let written = self.write_packs(&catalog, sources, &options, &|_, _| ())?;
        self.put_catalog(&catalog, &rewritten, written.entries, written.next_pack)?;
        self.remove_unnamed().map(drop)
    }

    /// Folders of drives, without those that are being written.
    fn folders(&self) -> Result<BTreeMap<DriveId, Folder>, LakeError> {
        let drives = self.dir().join("drives");
        let mut ids = Vec::new();
        for entry in fs::read_dir(&drives).map_err(LakeError::io(&drives))? {
            let entry = entry.map_err(LakeError::io(&drives))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if !name.starts_with('.') && entry.file_type().is_ok_and(|t| t.is_dir()) {
                ids.push(DriveId(name));
            }
        }
        let found = on_all_cores(&ids, |id| {
            let dir = self.drive_dir(id);
            let (fingerprint, bytes) = fingerprint::folder(&dir);
            Folder { whole: is_drive(&dir), fingerprint, bytes }
        });
        Ok(ids.into_iter().zip(found).collect())
    }

    /// Removes the folders that went into the packs of the catalog as they are now; gives the others.
    fn remove_packed(
        &self,
        folders: BTreeMap<DriveId, Folder>,
    ) -> Result<BTreeMap<DriveId, Folder>, LakeError> {
        let catalog = self.catalog()?;
        let mut packed: BTreeMap<&str, Vec<(usize, &DriveId)>> = BTreeMap::new();
        for id in folders.keys() {
            if let Some((pack, row)) = catalog.find(id).map(|at| catalog.location(at)) {
                packed.entry(pack).or_default().push((row, id));
            }
        }
        let mut same = BTreeSet::new();
        for (name, drives) in packed {
            let pack = self.open_pack(name)?;
            same.extend(
                drives.into_iter().filter(|(row, id)| pack.fingerprints[*row] == folders[*id].fingerprint),
            );
        }
        let same: Vec<&DriveId> = same.into_iter().map(|(_, id)| id).collect();
        let removed = on_all_cores(&same, |id| -> Result<bool, LakeError> {
            let (dir, gone) = (self.drive_dir(id), self.aside(id, "gone")?);
            {
                let _lock = lock::replacing(self.dir())?;
                if fingerprint::folder(&dir).0 != folders[*id].fingerprint {
                    return Ok(false);
                }
                remove_dir(&gone)?;
                fs::rename(&dir, &gone).map_err(LakeError::io(&dir))?;
            }
            remove_dir(&gone)?;
            Ok(true)
        });
        let mut left = folders.clone();
        for (id, removed) in same.into_iter().zip(removed) {
            if removed? {
                left.remove(id);
            }
        }
        Ok(left)
    }

    /// The drives to write, by id: those of the packs to write again, and those with a folder.
    fn sources(
        &self,
        catalog: &Catalog,
        rewritten: &BTreeSet<String>,
        folders: &BTreeMap<DriveId, Folder>,
        without: &BTreeSet<DriveId>,
    ) -> Result<Vec<Source>, LakeError> {
        let mut sources = BTreeMap::new();
        for (name, positions) in packs_of(catalog) {
            if !rewritten.contains(&name) {
                continue;
            }
            // Not through the cache: every pack is needed once.
            self.fetch(&format!("{}/{name}", super::FOLDER))?;
            let pack = Arc::new(OpenPack::read(self.packs_dir().join(&name))?);
            for at in positions {
                let entry = catalog.entry(at);
                let folder = folders.get(&entry.drive_id).cloned();
                // What a pack has of a drive with a folder of its own is outdated.
                if without.contains(&entry.drive_id) || folder.as_ref().is_some_and(|f| f.whole) {
                    continue;
                }
                let bytes = entry.bytes + folder.as_ref().map_or(0, |f| f.bytes);
                let place = Some((Arc::clone(&pack), entry.row as usize));
                let id = entry.drive_id;
                sources.insert(id.clone(), Source { id, pack: place, folder, bytes });
            }
        }
        for (id, folder) in folders.iter().filter(|(_, f)| f.whole) {
            let (id, bytes) = (id.clone(), folder.bytes);
            sources.insert(id.clone(), Source { id, pack: None, folder: Some(folder.clone()), bytes });
        }
        Ok(sources.into_values().collect())
    }

    /// Writes the drives into new packs.
    fn write_packs(
        &self,
        catalog: &Catalog,
        sources: Vec<Source>,
        options: &CompactionOptions,
        done: &(impl Fn(usize, usize) + Sync),
    ) -> Result<Written, LakeError> {
        let total = sources.len();
        let (finished, next) = (AtomicUsize::new(0), Mutex::new(catalog.next_pack));
        let one = |sources: &Vec<Source>| {
            let (mut members, mut left) = (Vec::new(), Vec::new());
            for source in sources {
                match (self.member(source, options), &source.pack) {
                    (Ok(member), _) => members.push(member),
                    (Err(e), None) => left.push((source.id.clone(), e)),
                    // Files that override those of a packed drive cannot be read: they stay.
                    (Err(e), Some((pack, row))) => {
                        members.push(Member::packed(pack, *row)?);
                        left.push((source.id.clone(), e));
                    }
                }
            }
            let mut schemas = Schemas::default();
            let mut packs = Vec::new();
            for alike in write::alike(members, &mut schemas)? {
                let number = {
                    let mut next = next.lock().unwrap_or_else(PoisonError::into_inner);
                    *next += 1;
                    *next - 1
                };
                packs.push(write::pack(&self.packs_dir(), &format!("{number:08}"), &alike, &mut schemas)?);
            }
            done(finished.fetch_add(sources.len(), Ordering::Relaxed) + sources.len(), total);
            Ok((packs, left))
        };
        let (mut packs, mut entries, mut left) = (0, Vec::new(), Vec::new());
        let mut packed = BTreeMap::new();
        let parts = divided(sources, options);
        for result in on_all_cores(&parts, one) {
            let (written, unreadable) = result?;
            packs += written.len();
            entries.extend(written.into_iter().flatten());
            left.extend(unreadable);
        }
        let skipped: BTreeSet<&DriveId> = left.iter().map(|(id, _)| id).collect();
        for source in parts.into_iter().flatten().filter(|s| !skipped.contains(&s.id)) {
            if let Some(folder) = source.folder {
                packed.insert(source.id, folder);
            }
        }
        let next_pack = next.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Written { packs, next_pack, entries, left, packed })
    }

    fn member(&self, source: &Source, options: &CompactionOptions) -> Result<Member, LakeError> {
        let dir = self.drive_dir(&source.id);
        let mut member = match (&source.pack, &source.folder) {
            (Some((pack, row)), None) => Member::packed(pack, *row)?,
            (Some((pack, row)), Some(folder)) => {
                let mut member = Member::packed(pack, *row)?;
                member.overlay(&dir, folder.fingerprint.clone())?;
                member
            }
            (None, folder) => {
                let fingerprint = folder.as_ref().map(|f| f.fingerprint.clone()).unwrap_or_default();
                Member::loose(&dir, &source.id, fingerprint)?
            }
        };
        if !options.keep_signals {
            member.signals = None;
        }
        Ok(member)
    }

    /// Publishes a catalog that has `entries` instead of the drives of the packs written again.
    fn put_catalog(
        &self,
        old: &Catalog,
        rewritten: &BTreeSet<String>,
        mut entries: Vec<DriveEntry>,
        next_pack: u64,
    ) -> Result<Arc<Catalog>, LakeError> {
        let kept = (0..old.len()).filter(|at| !rewritten.contains(old.location(*at).0));
        entries.extend(kept.map(|at| old.entry(at)));
        entries.sort_by(|a, b| a.drive_id.cmp(&b.drive_id));
        Catalog::publish(&self.packs_dir(), &entries, next_pack)?;
        self.catalog()
    }

    /// Removes packs that the catalog does not name; how many.
    fn remove_unnamed(&self) -> Result<usize, LakeError> {
        let (dir, catalog) = (self.packs_dir(), self.catalog()?);
        let named = packs_of(&catalog);
        let mut removed = 0;
        for entry in fs::read_dir(&dir).map_err(LakeError::io(&dir))? {
            let entry = entry.map_err(LakeError::io(&dir))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if entry.path().is_dir() && !named.contains_key(&name) {
                remove_dir(&entry.path())?;
                removed += 1;
            } else if name.starts_with('.') && entry.path().is_file() {
                fs::remove_file(entry.path()).map_err(LakeError::io(&entry.path()))?;
            }
        }
        Ok(removed)
    }
}

impl Compaction {
    fn count(&mut self, catalog: &Catalog) {
        let packs = packs_of(catalog);
        self.drives = catalog.len();
        self.packs = packs.len();
        self.bytes = packs.values().flatten().map(|at| catalog.entry(*at).bytes).sum();
    }
}

/// Positions in the catalog of each pack's drives, in the order of their rows.
fn packs_of(catalog: &Catalog) -> BTreeMap<String, Vec<usize>> {
    let mut packs: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for at in 0..catalog.len() {
        let (pack, _) = catalog.location(at);
        match packs.get_mut(pack) {
            Some(positions) => positions.push(at),
            None => drop(packs.insert(pack.to_owned(), vec![at])),
        }
    }
    packs
}

/// Divides the drives in their order into packs of bounded size.
fn divided(sources: Vec<Source>, options: &CompactionOptions) -> Vec<Vec<Source>> {
    let mut packs: Vec<Vec<Source>> = Vec::new();
    let mut bytes = 0;
    for source in sources {
        let full = packs.last().is_none_or(|p| {
            p.len() >= options.pack_drives.max(1) || bytes + source.bytes > options.pack_bytes
        });
        if full {
            packs.push(Vec::new());
            bytes = 0;
        }
        bytes += source.bytes;
        if let Some(pack) = packs.last_mut() {
            pack.push(source);
        }
    }
    packs
}

/// Does the work on every item, on all cores; results in the order of the items.
fn on_all_cores<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(items.len())));
    let run = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(at) else { break };
            let result = work(item);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
        }
    };
    std::thread::scope(|scope| (0..cores).for_each(|_| drop(scope.spawn(run))));
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(at, _)| *at);
    results.into_iter().map(|(_, result)| result).collect()
}
