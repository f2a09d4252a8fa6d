//! All targets. Seeds are the fixtures of the tests and the examples, so the harness runs inside the repository.

mod cut;
mod ingest;
mod lake;
mod made;
mod readers;
mod text;

use crate::harness::Target;
use std::fs;
use std::path::{Path, PathBuf};

/// Every target, in the order of their names.
pub fn all() -> Vec<Target> {
    let mut all = readers::targets();
    all.extend(ingest::targets());
    all.extend(lake::targets());
    all.extend(text::targets());
    all.sort_by(|a, b| a.name.cmp(&b.name));
    all
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The bytes of a file of the repository; empty when it is not there, which the smoke test refuses.
fn file(path: &str) -> Vec<u8> {
    fs::read(repository().join(path)).unwrap_or_default()
}

/// A fixture of the recorded formats.
fn fixture(name: &str) -> Vec<u8> {
    file(&format!("crates/whyroad-ingest/tests/fixtures/{name}"))
}

fn unchanged(_: &mut Vec<u8>) {}

/// A folder for files at work, in memory where the system has such a place.
fn work_folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    made.or_else(|_| tempfile::tempdir()).expect("a temporary folder can be made")
}
