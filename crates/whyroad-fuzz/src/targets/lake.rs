//! Files of a lake: each by itself on bytes in memory (`drive-*`, `signals-*`), and all of a drive, of which one file
//! is changed, from a folder (`folder-lake`, `folder-signals`).

use super::{unchanged, work_folder};
use crate::harness::Target;
use crate::targets::readers::example;
use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{FilesInMemory, Options, formats, read_files};
use whyroad_lake::signals::write_signals;
use whyroad_lake::{Lake, SignalFile, readers};
use whyroad_model::scene::MediaFrame;
use whyroad_model::{Drive, Nanos};

/// Frames of the small drive.
const FEW: usize = 3;

/// A drive with every table.
fn drive() -> Option<Drive> {
    let names =
        ["drive.yaml", "ego.csv", "objects.csv", "lanes.csv", "areas.csv", "lights.csv", "context.csv"];
    let files: FilesInMemory = names.iter().map(|n| ((*n).to_owned(), example(n))).collect();
    let (drive, _) = read_files(formats::by_name("table")?, &files, &Options::default()).pop()?;
    let image =
        |index| MediaFrame { camera: "front".into(), time: Nanos(0), uri: "front/a.jpg".into(), index };
    Some(Drive { media: Some((0..3).map(image).collect()), ..drive?.until_frame(FEW) })
}

pub(super) fn targets() -> Vec<Target> {
    let Some(drive) = drive() else { return Vec::new() };
    let (lake, signals) = (work_folder(), work_folder());
    let id = drive.meta.drive_id.clone();
    let written = Lake::create_or_open(lake.path()).and_then(|lake| lake.write_drive(&drive));
    let stored = write_signals(signals.path(), "1", &[(String::new(), &whyroad_signals::derive(&drive))]);
    if written.is_err() || stored.is_err() {
        return Vec::new();
    }
    let tables = lake.path().join("drives").join(id.as_str());
    let mut out: Vec<Target> =
        readers::ALL.iter().map(|reader| in_memory(reader, &tables, signals.path())).collect();
    out.push(in_folder("folder-lake", lake.path(), tables, move |folder| {
        Lake::open(folder).is_ok_and(|lake| lake.read_drive(&id).is_ok() & lake.outline(&id).is_ok())
    }));
    out.push(in_folder("folder-signals", signals.path(), signals.path().to_owned(), |folder| {
        let Ok(Some(file)) = SignalFile::open(folder) else { return false };
        (0..file.contents().drives.len()).fold(true, |all, i| all & file.read_table(i).is_ok())
    }));
    out
}

fn in_memory(reader: &readers::LakeReader, tables: &Path, signals: &Path) -> Target {
    let seeds = match reader.name.strip_prefix("drive-") {
        Some("manifest") => vec![tables.join("drive.json")],
        Some(table) => vec![tables.join(format!("{table}.parquet"))],
        None => vec![signals.join("frames.parquet"), signals.join("targets.parquet")],
    };
    Target {
        name: reader.name.to_owned(),
        seeds: seeds.into_iter().filter_map(|path| fs::read(path).ok()).collect(),
        small: Vec::new(),
        repair: unchanged,
        run: Box::new(reader.read),
    }
}

/// A target whose input says in its first byte which file of `changed` it is, and then its content.
fn in_folder(name: &str, folder: &Path, changed: PathBuf, read: impl Fn(&Path) -> bool + 'static) -> Target {
    let mut names: Vec<String> = fs::read_dir(&changed)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|e| e.path().is_file())
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    let whole: Vec<Vec<u8>> = names.iter().filter_map(|n| fs::read(changed.join(n)).ok()).collect();
    let own = copy_of(folder);
    let places =
        names.iter().map(|n| own.path().join(changed.strip_prefix(folder).unwrap_or(&changed)).join(n));
    let places: Vec<PathBuf> = places.collect();
    let seeds =
        whole.iter().enumerate().map(|(i, content)| [&[i as u8], content.as_slice()].concat()).collect();
    let run = move |bytes: &[u8]| {
        let Some((which, content)) = bytes.split_first() else { return false };
        let which = usize::from(*which) % places.len();
        let _ = fs::write(&places[which], content);
        let taken = read(own.path());
        let _ = fs::write(&places[which], &whole[which]);
        taken
    };
    Target { name: name.to_owned(), seeds, small: Vec::new(), repair: unchanged, run: Box::new(run) }
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
