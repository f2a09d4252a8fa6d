//! Other copies of a drive: in releases, backups, parts of mining runs. They are found and listed, never changed: a
//! release is immutable, and a backup changed by hand could not be restored.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufReader, Read as _};
use std::path::{Path, PathBuf};
use whyroad_dataset::Release;
use whyroad_engine::parts::Part;
use whyroad_model::DriveId;

/// Copies of a drive, and places that could not be searched.
#[derive(Debug, Default)]
pub(super) struct Holders {
    pub found: Vec<String>,
    pub unsearched: Vec<String>,
}

impl Holders {
    fn add(&mut self, path: &Path, holds: anyhow::Result<bool>) {
        match holds {
            Ok(true) => self.found.push(path.display().to_string()),
            Ok(false) => {}
            Err(e) => self.unsearched.push(format!("{}: {e:#}", path.display())),
        }
    }
}

/// Releases at or anywhere below the folders, and builds that did not finish.
pub(super) fn releases(dirs: &[PathBuf], drives: &BTreeSet<DriveId>) -> Holders {
    let mut out = Holders::default();
    if drives.is_empty() {
        return out;
    }
    let all = files(dirs, &mut out.unsearched);
    let unfinished: BTreeSet<&Path> = all.iter().filter_map(|p| unfinished_build(p)).collect();
    for dir in unfinished {
        out.add(dir, unfinished_holds(dir, drives));
    }
    for manifest in all.iter().filter(|p| p.ends_with("manifest.json") && unfinished_build(p).is_none()) {
        // Other tools use this file name, too.
        let text = fs::read(manifest).ok().and_then(|t| serde_json::from_slice::<Value>(&t).ok());
        let ours = text.is_some_and(|m| m["format"].as_str().is_some_and(|f| f.contains("whyroad")));
        if let Some(dir) = manifest.parent().filter(|_| ours) {
            out.add(dir, release_holds(dir, drives));
        }
    }
    out
}

/// The work folder `.NAME.partial` of a build in which a file is: a killed or refused build leaves it.
fn unfinished_build(file: &Path) -> Option<&Path> {
    file.ancestors().skip(1).find(|dir| {
        let name = dir.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with('.') && name.ends_with(".partial")
    })
}

fn unfinished_holds(dir: &Path, drives: &BTreeSet<DriveId>) -> anyhow::Result<bool> {
    let all = files(&[dir.to_owned()], &mut vec![]);
    for file in &all {
        if occurs(file, drives)? {
            return Ok(true);
        }
    }
    // Its columns are compressed.
    let tables = all.iter().filter(|f| f.extension().is_some_and(|e| e == "parquet")).count();
    anyhow::ensure!(
        tables == 0,
        "an unfinished build; its {tables} Parquet files cannot be searched: remove it"
    );
    Ok(false)
}

fn release_holds(dir: &Path, drives: &BTreeSet<DriveId>) -> anyhow::Result<bool> {
    // Dropped samples are listed in the stages' files.
    let named = files(&[dir.to_owned()], &mut vec![]);
    for file in named.iter().filter(|f| f.extension().is_none_or(|e| e != "parquet")) {
        if occurs(file, drives)? {
            return Ok(true);
        }
    }
    for batch in Release::open(dir)?.batches(None, Some(&["lineage"])) {
        let batch = batch?;
        for drive in whyroad_dataset::release::drive_ids(&batch)? {
            if drives.contains(&DriveId::from(drive)) {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// Part folders at or directly below the folders.
pub(super) fn parts(dirs: &[PathBuf], drives: &BTreeSet<DriveId>) -> Holders {
    let mut out = Holders::default();
    for dir in dirs.iter().flat_map(|d| Part::find(d).unwrap_or_default()) {
        out.add(&dir, Part::names_any(&dir, drives).map_err(Into::into));
    }
    out
}

/// Files at or below the paths in which the id of a drive occurs as a whole word: backups are plain text, copies of a
/// SQLite file contain texts unchanged. Compressed files are named as not searched.
pub(super) fn backups(paths: &[PathBuf], drives: &BTreeSet<DriveId>) -> Holders {
    let mut out = Holders::default();
    if drives.is_empty() {
        return out;
    }
    for file in files(paths, &mut out.unsearched) {
        let packed = file.extension().and_then(|e| e.to_str());
        if packed.is_some_and(|e| ["gz", "zst", "xz", "zip", "bz2", "7z", "age", "gpg"].contains(&e)) {
            out.unsearched.push(format!("{}: compressed or encrypted", file.display()));
            continue;
        }
        out.add(&file, occurs(&file, drives).map_err(Into::into));
    }
    out
}

fn files(paths: &[PathBuf], unsearched: &mut Vec<String>) -> Vec<PathBuf> {
    let (mut found, mut todo) = (Vec::new(), paths.to_vec());
    while let Some(path) = todo.pop() {
        if path.is_file() {
            found.push(path);
            continue;
        }
        match fs::read_dir(&path) {
            Ok(entries) => todo.extend(entries.flatten().map(|e| e.path()).filter(|p| !p.is_symlink())),
            Err(e) => unsearched.push(format!("{}: {e}", path.display())),
        }
    }
    found.sort();
    found
}

/// Piece of a file that is searched at once.
const PIECE: usize = 1 << 20;

/// Searches piece by piece; pieces overlap, so that an id at a border is found.
fn occurs(path: &Path, drives: &BTreeSet<DriveId>) -> std::io::Result<bool> {
    let longest = drives.iter().map(|d| d.as_str().len()).max().unwrap_or(0) + 2;
    let mut file = BufReader::new(File::open(path)?);
    let mut piece = vec![b'\n'];
    loop {
        let before = piece.len();
        file.by_ref().take(PIECE as u64).read_to_end(&mut piece)?;
        let ended = piece.len() == before;
        if ended {
            piece.push(b'\n');
        }
        if drives.iter().any(|d| contains(&piece, d.as_str().as_bytes())) {
            return Ok(true);
        }
        if ended {
            return Ok(false);
        }
        piece.drain(..piece.len().saturating_sub(longest));
    }
}

/// The id between characters that no id contains; a clip's id (`<drive>_000`) counts.
fn contains(text: &[u8], id: &[u8]) -> bool {
    let of_id = |b: &u8| b.is_ascii_alphanumeric() || *b == b'-' || *b == b'.';
    let mut from = 0;
    while let Some(at) = text[from..].windows(id.len()).position(|w| w == id).map(|i| from + i) {
        let before = at.checked_sub(1).and_then(|i| text.get(i));
        let after = text.get(at + id.len());
        if before.is_some_and(|b| !of_id(b) && *b != b'_') && after.is_some_and(|b| !of_id(b)) {
            return true;
        }
        from = at + 1;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_found_as_a_whole_word_wherever_it_is() {
        assert!(contains(b"\"d1\"", b"d1") && contains(b"\"d1_000\"", b"d1"));
        for text in ["\"d11\"", "\"xd1\"", "\"a_d1\"", "\"d1-b\"", "\"d1.b\""] {
            assert!(!contains(text.as_bytes(), b"d1"), "{text}");
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("backup.jsonl");
        let drives = BTreeSet::from([DriveId::from("d1")]);
        // At every position around the border of two pieces.
        for shift in 0..8 {
            let mut text = vec![b' '; PIECE - 5 + shift];
            text.extend(b"\"d1\" and more");
            fs::write(&path, &text).unwrap();
            assert!(occurs(&path, &drives).unwrap(), "{shift}");
        }
        fs::write(&path, "d1").unwrap();
        assert!(occurs(&path, &drives).unwrap(), "the whole file");
        fs::write(dir.path().join("b.jsonl.gz"), "?").unwrap();
        let found = backups(&[dir.path().to_owned()], &drives);
        assert_eq!((found.found.len(), found.unsearched.len()), (1, 1));
    }

    #[test]
    fn an_unfinished_build_is_found() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        for (build, file, text) in [
            (".r1.partial", "labels.records", "\"d1_000\""),
            (".r2.partial", "labels.records", "\"d2_000\""),
            (".r3.partial", "samples/0.parquet", "PAR1"),
        ] {
            let file = path(build).join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        }
        let found = releases(&[dir.path().to_owned()], &BTreeSet::from([DriveId::from("d1")]));
        assert_eq!(found.found, [path(".r1.partial").display().to_string()]);
        let [unsearched] = &found.unsearched[..] else { panic!("{found:?}") };
        assert!(unsearched.contains(".r3.partial"), "{unsearched}");
    }
}
