//! Files of a lake: tables of a drive, its manifest, and stored signals.

use super::{repository, unchanged, work_folder};
use crate::harness::Target;
use std::fs;
use std::path::Path;
use whyroad_ingest::{AdapterRef, Options, find_sources, read, sumo};
use whyroad_lake::signals::write_signals;
use whyroad_lake::{Lake, SignalFile};
use whyroad_model::Drive;

fn drive() -> Option<Drive> {
    let path = repository().join("crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml");
    let (sources, _) = find_sources(Some(AdapterRef(&sumo::Sumo)), &[path]);
    read(sources.first()?, &Options::default()).0
}

fn targets_in(folder: &Path, make: &dyn Fn(&str) -> Target) -> Vec<Target> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|e| e.path().is_file())
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names.iter().map(|n| make(n)).collect()
}

pub(super) fn targets() -> Vec<Target> {
    let Some(drive) = drive() else { return Vec::new() };
    let id = drive.meta.drive_id.clone();
    let folder = work_folder();
    let written = Lake::create_or_open(folder.path()).and_then(|lake| lake.write_drive(&drive));
    if written.is_err() {
        return Vec::new();
    }
    let below = folder.path().join("drives").join(id.as_str());
    let mut out = targets_in(&below, &|name| {
        let (own, id) = (copy_of(folder.path()), id.clone());
        let path = own.path().join("drives").join(id.as_str()).join(name);
        Target {
            name: format!("lake-{}", name.split('.').next().unwrap_or(name)),
            seeds: vec![fs::read(&path).unwrap_or_default()],
            repair: unchanged,
            run: Box::new(move |bytes| {
                let _ = fs::write(&path, bytes);
                if let Ok(lake) = Lake::open(own.path()) {
                    drop(lake.read_drive(&id));
                    drop(lake.outline(&id));
                }
            }),
        }
    });
    let signals = work_folder();
    let table = whyroad_signals::derive(&drive);
    if write_signals(signals.path(), "1", &[(String::new(), &table)]).is_ok() {
        out.extend(targets_in(signals.path(), &|name| {
            let own = copy_of(signals.path());
            let path = own.path().join(name);
            Target {
                name: format!("signals-{}", name.split('.').next().unwrap_or(name)),
                seeds: vec![fs::read(&path).unwrap_or_default()],
                repair: unchanged,
                run: Box::new(move |bytes| {
                    let _ = fs::write(&path, bytes);
                    if let Ok(Some(file)) = SignalFile::open(own.path()) {
                        (0..file.contents().drives.len()).for_each(|i| drop(file.read_table(i)));
                    }
                }),
            }
        }));
    }
    out
}

fn copy_of(folder: &Path) -> tempfile::TempDir {
    fn copy(from: &Path, to: &Path) {
        for entry in fs::read_dir(from).into_iter().flatten().flatten() {
            let (path, to) = (entry.path(), to.join(entry.file_name()));
            if path.is_dir() {
                let _ = fs::create_dir_all(&to);
                copy(&path, &to);
            } else {
                let _ = fs::copy(&path, &to);
            }
        }
    }
    let out = work_folder();
    copy(folder, out.path());
    out
}
