//! One writer's changes on top of what others have published meanwhile: a pure function. Drives that others wrote are
//! kept; where both changed the same drive, nothing of either is lost silently.

use super::Intent;
use super::manifest::{Manifest, Retired, StoredFile, unit};
use crate::lake::MANIFEST as DRIVE_JSON;
use std::collections::{BTreeMap, BTreeSet};

/// What happened to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Change {
    Put(StoredFile),
    Remove,
}

/// Changes by path.
pub(super) type Changes = BTreeMap<String, Change>;

/// The outcome.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Rebased {
    pub manifest: Manifest,
    /// Drives (or `packs`, or a file) that another writer changed meanwhile, so that these changes were not applied.
    pub conflicts: Vec<String>,
}

type Files<'a> = BTreeMap<&'a str, &'a StoredFile>;

/// Applies `changes`, which were made on `base`, to `current`; `now` is the time in seconds since 1970.
pub(super) fn rebase(
    base: &Manifest,
    current: &Manifest,
    changes: &Changes,
    intent: Intent,
    now: u64,
) -> Rebased {
    let mut by_unit: BTreeMap<&str, BTreeMap<&str, &Change>> = BTreeMap::new();
    for (path, change) in changes {
        by_unit.entry(unit(path)).or_default().insert(path, change);
    }
    let packs_moved = !same(&files(base, "packs"), &files(current, "packs"));
    // The answer to an earlier put was lost: everything was written.
    let packed = by_unit.get("packs").is_some_and(|changes| {
        let theirs = files(current, "packs");
        changes.iter().all(|(path, change)| match change {
            Change::Put(file) => theirs.get(path).is_some_and(|t| t.key == file.key),
            Change::Remove => !theirs.contains_key(path),
        })
    });
    let (mut result, mut conflicts) = (current.clone(), Vec::new());
    for (name, changes) in &by_unit {
        let (base, theirs) = (files(base, name), files(current, name));
        let mut mine = base.clone();
        for (path, change) in changes {
            match change {
                Change::Put(file) => drop(mine.insert(path, file)),
                Change::Remove => drop(mine.remove(path)),
            }
        }
        // Deleted meanwhile: packing it would restore it.
        if intent == Intent::Compact
            && !packed
            && !base.is_empty()
            && theirs.is_empty()
            && name.starts_with("drives/")
        {
            conflicts.push((*name).to_owned());
            continue;
        }
        let decision =
            decide(&Versions { name, base: &base, theirs: &theirs, mine: &mine }, intent, packs_moved);
        match decision {
            Decision::Mine => replace(&mut result, &theirs, &mine),
            Decision::Theirs => {}
            Decision::Both => {
                // Where both have a file, the published one is kept: the content of a drive is the same.
                for (path, change) in changes {
                    if let Change::Put(file) = change
                        && theirs.get(path).is_none_or(|t| t.blake3 != file.blake3)
                    {
                        result.files.insert((*path).to_owned(), (*file).clone());
                    }
                }
            }
            Decision::Conflict => conflicts.push((*name).to_owned()),
        }
    }
    if intent != Intent::Write && !conflicts.is_empty() {
        result = current.clone();
    }
    retire(&mut result, current, changes, intent, now);
    Rebased { manifest: result, conflicts }
}

struct Versions<'a> {
    name: &'a str,
    base: &'a Files<'a>,
    theirs: &'a Files<'a>,
    mine: &'a Files<'a>,
}

enum Decision {
    Mine,
    Theirs,
    Both,
    Conflict,
}

fn decide(of: &Versions<'_>, intent: Intent, packs_moved: bool) -> Decision {
    let is_drive = of.name.starts_with("drives/");
    let drive_json = format!("{}/{DRIVE_JSON}", of.name);
    let head = |files: &Files<'_>| files.get(drive_json.as_str()).map(|f| f.blake3.clone());
    let (base, theirs, mine) = (head(of.base), head(of.theirs), head(of.mine));
    // Files that override those of a packed drive belong to the pack that they were made for.
    let over_pack = is_drive && base.is_none() && mine.is_none();
    if same(of.mine, of.theirs) {
        return Decision::Theirs;
    }
    if same(of.base, of.theirs) && !(over_pack && packs_moved) {
        return Decision::Mine;
    }
    if !is_drive {
        return Decision::Conflict;
    }
    if mine == base {
        // Only derived from the drive: useless if the drive has been replaced.
        return if theirs == base && !(over_pack && packs_moved) { Decision::Both } else { Decision::Theirs };
    }
    match (mine, theirs) {
        (Some(mine), Some(theirs)) if mine == theirs => Decision::Both,
        (None, Some(_)) if intent == Intent::Compact => Decision::Theirs,
        // Compacted or deleted meanwhile: packing it would restore it.
        _ => Decision::Conflict,
    }
}

fn files<'a>(of: &'a Manifest, unit: &'a str) -> Files<'a> {
    match of.files.get_key_value(unit) {
        Some((path, file)) => BTreeMap::from([(path.as_str(), file)]),
        None => {
            let inside = |path: &str| path[unit.len()..].starts_with('/');
            of.below(unit)
                .filter(|(path, _)| inside(path))
                .map(|(path, file)| (path.as_str(), file))
                .collect()
        }
    }
}

fn same(a: &Files<'_>, b: &Files<'_>) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|((p, f), (q, g))| p == q && f.blake3 == g.blake3)
}

fn replace(result: &mut Manifest, theirs: &Files<'_>, mine: &Files<'_>) {
    for path in theirs.keys() {
        result.files.remove(*path);
    }
    for (path, file) in mine {
        // An unchanged file keeps its object.
        let kept = theirs.get(path).filter(|t| t.blake3 == file.blake3);
        result.files.insert((*path).to_owned(), (*kept.unwrap_or(file)).clone());
    }
}

/// Records the objects that no file uses any more, and those uploaded for `changes` that no file uses.
fn retire(result: &mut Manifest, current: &Manifest, changes: &Changes, intent: Intent, now: u64) {
    let used: BTreeSet<&str> = result.files.values().map(|f| f.key.as_str()).collect();
    let known: BTreeSet<&str> = result.retired.iter().map(|r| r.key.as_str()).collect();
    let replaced = current.files.values().map(|f| (f.key.as_str(), now));
    let unused = changes.values().filter_map(|c| match c {
        // Only this writer has ever known it.
        Change::Put(file) => Some((file.key.as_str(), 0)),
        Change::Remove => None,
    });
    let fresh: BTreeMap<&str, u64> =
        replaced.chain(unused).filter(|(key, _)| !used.contains(key) && !known.contains(key)).collect();
    let fresh: Vec<Retired> =
        fresh.into_iter().map(|(key, at)| Retired { key: key.to_owned(), at }).collect();
    result.retired.extend(fresh);
    if intent == Intent::Delete {
        // Also older states of a drive that was replaced before it was deleted.
        result.retired.iter_mut().for_each(|r| r.at = 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(content: &str) -> StoredFile {
        StoredFile { key: format!("key-{content}"), bytes: 1, blake3: content.into() }
    }

    fn manifest(files: &[(&str, &str)]) -> Manifest {
        let files = files.iter().map(|(path, content)| ((*path).to_owned(), file(content))).collect();
        Manifest { files, retired: vec![] }
    }

    fn put(changes: &[(&str, &str)]) -> Changes {
        let one = |(path, content): &(&str, &str)| {
            let change = if content.is_empty() { Change::Remove } else { Change::Put(file(content)) };
            ((*path).to_owned(), change)
        };
        changes.iter().map(one).collect()
    }

    /// The files as `path=content`, the conflicts, the retired objects.
    fn outcome(
        base: &[(&str, &str)],
        current: &[(&str, &str)],
        changes: &[(&str, &str)],
        intent: Intent,
    ) -> (String, String, String) {
        let done = rebase(&manifest(base), &manifest(current), &put(changes), intent, 9);
        let files: Vec<String> =
            done.manifest.files.iter().map(|(path, f)| format!("{path}={}", f.blake3)).collect();
        let retired: Vec<String> =
            done.manifest.retired.iter().map(|r| format!("{}@{}", r.key, r.at)).collect();
        (files.join(" "), done.conflicts.join(" "), retired.join(" "))
    }

    const A: (&str, &str) = ("drives/a/drive.json", "a");
    const B: (&str, &str) = ("drives/b/drive.json", "b");
    const PACK: (&str, &str) = ("packs/1/drives.parquet", "p");
    const CATALOG: (&str, &str) = ("packs/catalogue.parquet", "c");

    #[test]
    fn drives_of_two_writers_are_both_kept() {
        let (files, conflicts, retired) = outcome(&[], &[A], &[B], Intent::Write);
        assert_eq!(files, "drives/a/drive.json=a drives/b/drive.json=b");
        assert!(conflicts.is_empty() && retired.is_empty());
    }

    #[test]
    fn doing_it_again_changes_nothing() {
        // Also when the answer to the first put was lost: the published content is the intended one.
        let (files, conflicts, retired) = outcome(&[], &[A], &[A], Intent::Write);
        assert_eq!((files.as_str(), conflicts.as_str(), retired.as_str()), ("drives/a/drive.json=a", "", ""));
    }

    #[test]
    fn one_drive_with_two_contents_is_a_conflict_and_the_rest_is_published() {
        let mine = [("drives/a/drive.json", "a2"), B];
        let (files, conflicts, retired) =
            outcome(&[A], &[("drives/a/drive.json", "a1")], &mine, Intent::Write);
        assert_eq!(files, "drives/a/drive.json=a1 drives/b/drive.json=b");
        assert_eq!((conflicts.as_str(), retired.as_str()), ("drives/a", "key-a2@0"));
    }

    #[test]
    fn what_was_derived_from_a_drive_goes_with_it() {
        let signals = ("drives/a/signals/frames.parquet", "s");
        let (files, conflicts, _) =
            outcome(&[A], &[A, ("drives/a/found.json", "f")], &[signals], Intent::Write);
        assert_eq!(files, "drives/a/drive.json=a drives/a/found.json=f drives/a/signals/frames.parquet=s");
        assert!(conflicts.is_empty());
        let replaced = [("drives/a/drive.json", "a1")];
        let (files, conflicts, retired) = outcome(&[A], &replaced, &[signals], Intent::Write);
        assert_eq!((files.as_str(), conflicts.as_str()), ("drives/a/drive.json=a1", ""));
        assert_eq!(retired, "key-s@0");
        // Deleted: it is not restored in part. Overriding a pack: only as long as the packs are the same.
        assert_eq!(outcome(&[A], &[], &[signals], Intent::Write).0, "");
        assert_eq!(
            outcome(&[CATALOG], &[("packs/catalogue.parquet", "c2")], &[signals], Intent::Write).0,
            "packs/catalogue.parquet=c2"
        );
    }

    #[test]
    fn packing_keeps_what_others_wrote_and_brings_nothing_back() {
        let packed = [("drives/a/drive.json", ""), PACK, CATALOG];
        // A drive that was added meanwhile, and one that was replaced meanwhile: both keep their folders.
        let (files, conflicts, _) =
            outcome(&[A], &[("drives/a/drive.json", "a1"), B], &packed, Intent::Compact);
        assert_eq!(
            files,
            "drives/a/drive.json=a1 drives/b/drive.json=b packs/1/drives.parquet=p packs/catalogue.parquet=c"
        );
        assert!(conflicts.is_empty());
        // One that was deleted meanwhile, or packs of another compaction: nothing is done.
        for (current, name) in [(vec![], "drives/a"), (vec![A, ("packs/2/drives.parquet", "q")], "packs")] {
            let (files, conflicts, _) = outcome(&[A], &current, &packed, Intent::Compact);
            assert!(!files.contains("packs/1"), "{files}");
            assert_eq!(conflicts, name);
        }
    }

    #[test]
    fn deletion_removes_the_objects_at_once_or_says_that_the_drive_changed() {
        let (files, conflicts, retired) =
            outcome(&[A, B], &[A, B], &[("drives/a/drive.json", "")], Intent::Delete);
        assert_eq!((files.as_str(), conflicts.as_str()), ("drives/b/drive.json=b", ""));
        assert_eq!(retired, "key-a@0");
        let replaced = [("drives/a/drive.json", "a1"), B];
        let (files, conflicts, _) =
            outcome(&[A, B], &replaced, &[("drives/a/drive.json", "")], Intent::Delete);
        assert_eq!((files.contains("a1"), conflicts.as_str()), (true, "drives/a"));
    }

    #[test]
    fn one_drives_name_may_begin_with_anothers() {
        let longer = ("drives/a-2/drive.json", "z");
        let (files, ..) = outcome(&[A, longer], &[A, longer], &[("drives/a/drive.json", "")], Intent::Write);
        assert_eq!(files, "drives/a-2/drive.json=z");
    }
}
