//! Signal tables for the benches: the bundled drives, one after another and again and again, each time a little
//! different, as long drives; stored as a lake stores them, several drives a file, one a row group.

use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_lake::SignalFile;
use whyroad_lake::signals::write_signals;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, FrameRange, Nanos, SignalTable};

/// Rows of targets per drive, approximately: three quarters of an hour in traffic.
const DRIVE_ROWS: usize = 100_000;
const DRIVES_A_FILE: usize = 8;

/// One drive of the data: its store, its row group.
pub struct Stored {
    /// The store, shared by the drives that are in it.
    pub file: Arc<SignalFile>,
    /// Row group.
    pub drive: usize,
}

/// The bundled drives' signals; only of these names.
pub fn bundled(names: &dyn Fn(&str) -> bool) -> Vec<SignalTable> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let (sources, _) = find_sources(None, &[folder]);
    let drives = sources.iter().filter_map(|s| read(s, &Options::default()).0);
    let mut tables: Vec<SignalTable> = drives.map(|d| whyroad_signals::derive(&d)).collect();
    for table in &mut tables {
        table.frame_columns.retain(|n, _| names(n));
        table.target_columns.retain(|n, _| names(n));
    }
    // Long drives are made of whole ones: they must have the same columns.
    let in_all = |n: &String| {
        tables.iter().all(|t| t.frame_columns.contains_key(n) || t.target_columns.contains_key(n))
    };
    let keep: std::collections::BTreeSet<String> = tables
        .iter()
        .flat_map(|t| t.frame_columns.keys().chain(t.target_columns.keys()))
        .filter(|n| in_all(n))
        .cloned()
        .collect();
    for table in &mut tables {
        table.frame_columns.retain(|n, _| keep.contains(n));
        table.target_columns.retain(|n, _| keep.contains(n));
    }
    tables
}

/// Writes at least `rows` rows of targets below `dir`, some drives a folder; the folders.
pub fn write(dir: &Path, tables: &[SignalTable], rows: usize) -> Vec<PathBuf> {
    let drives = rows.div_ceil(DRIVE_ROWS).max(1);
    let files: Vec<usize> = (0..drives.div_ceil(DRIVES_A_FILE)).collect();
    let one = |f: &usize| {
        let folder = dir.join(format!("{f:03}"));
        std::fs::create_dir_all(&folder).expect("a folder");
        let of_file = f * DRIVES_A_FILE..drives.min((f + 1) * DRIVES_A_FILE);
        let long: Vec<(String, SignalTable)> =
            of_file.map(|d| (String::new(), long_drive(tables, d, DRIVE_ROWS))).collect();
        let borrowed: Vec<(String, &SignalTable)> = long.iter().map(|(h, t)| (h.clone(), t)).collect();
        write_signals(&folder, "bench", &borrowed).expect("written");
        folder
    };
    files.par_iter().map(one).collect()
}

/// The drives in these folders, their stores opened again: nothing is known of them that is not in the files.
pub fn open(folders: &[PathBuf]) -> Vec<Stored> {
    let one = |folder: &PathBuf| {
        let file = Arc::new(SignalFile::open(folder).expect("readable").expect("there"));
        let drives = 0..file.contents().drives.len();
        drives.map(|drive| Stored { file: file.clone(), drive }).collect::<Vec<_>>()
    };
    folders.par_iter().flat_map_iter(one).collect()
}

/// A factor near 1, from a counter: numbers are never the same twice, and nobody's clock or dice are asked.
fn factor(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    0.97 + 0.06 * ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

fn long_drive(tables: &[SignalTable], drive: usize, rows: usize) -> SignalTable {
    let mut out =
        SignalTable { drive_id: format!("drive{drive:05}").as_str().into(), ..SignalTable::default() };
    let (mut done, mut part) = (0, 0);
    while done < rows {
        let table = &tables[(drive + part) % tables.len()];
        let f = factor((drive * 1000 + part) as u64);
        let (first_frame, first_row) = (out.times.len(), done);
        out.times.extend((0..table.times.len()).map(|i| Nanos((first_frame + i) as i64 * 100_000_000)));
        for span in &table.targets {
            out.targets.push(TargetSpan {
                id: format!("{part:04}.{}", span.id).as_str().into(),
                class: span.class,
                first_row: first_row + span.first_row,
                frames: FrameRange::new(first_frame + span.frames.start, first_frame + span.frames.end),
            });
        }
        for (name, column) in &table.frame_columns {
            append(out.frame_columns.entry(name.clone()), column, f);
        }
        for (name, column) in &table.target_columns {
            append(out.target_columns.entry(name.clone()), column, f);
        }
        done += table.targets.iter().map(|t| t.frames.len()).sum::<usize>();
        part += 1;
    }
    out
}

fn append(to: std::collections::btree_map::Entry<'_, String, Column>, column: &Column, f: f64) {
    let empty = match column {
        Column::Number(_) => Column::Number(vec![]),
        Column::Flag(_) => Column::Flag(vec![]),
        Column::Category { names, .. } => Column::Category { codes: vec![], names: names.clone() },
    };
    match (to.or_insert(empty), column) {
        (Column::Number(to), Column::Number(v)) => to.extend(v.iter().map(|x| x * f)),
        (Column::Flag(to), Column::Flag(v)) => to.extend_from_slice(v),
        (Column::Category { codes: to, .. }, Column::Category { codes, .. }) => to.extend_from_slice(codes),
        _ => {}
    }
}
