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

/// Frames of the small drive, which lies beside the changed file.
const FEW: usize = 3;

pub(super) fn targets() -> Vec<Target> {
    let Some(drive) = drive() else { return Vec::new() };
    let few = drive.until_frame(FEW);
    let id = drive.meta.drive_id.clone();
    let (whole, small) = (work_folder(), work_folder());
    let in_lake = |folder: &Path, drive: &Drive| {
        let written = Lake::create_or_open(folder).and_then(|lake| lake.write_drive(drive));
        written.is_ok().then(|| folder.join("drives").join(id.as_str()))
    };
    let (Some(seeds), Some(_)) = (in_lake(whole.path(), &drive), in_lake(small.path(), &few)) else {
        return Vec::new();
    };
    let mut out = targets_in(&seeds, &|name| {
        let (own, id) = (copy_of(small.path()), id.clone());
        let path = own.path().join("drives").join(id.as_str()).join(name);
        Target {
            name: format!("lake-{}", name.split('.').next().unwrap_or(name)),
            seeds: fs::read(seeds.join(name)).into_iter().collect(),
            small: fs::read(&path).into_iter().collect(),
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
    let (whole, small) = (work_folder(), work_folder());
    let stored = |folder: &Path, drive: &Drive| {
        write_signals(folder, "1", &[(String::new(), &whyroad_signals::derive(drive))]).is_ok()
    };
    if stored(whole.path(), &drive) && stored(small.path(), &few) {
        out.extend(targets_in(whole.path(), &|name| {
            let own = copy_of(small.path());
            let path = own.path().join(name);
            Target {
                name: format!("signals-{}", name.split('.').next().unwrap_or(name)),
                seeds: fs::read(whole.path().join(name)).into_iter().collect(),
                small: fs::read(&path).into_iter().collect(),
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
