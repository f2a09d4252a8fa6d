//! Prints a hash over the bits of all signals of each drive in the given folders, in any format that `whyroad ingest`
//! reads: equal before and after a change that affects only the run time.
//!
//! `cargo run --release -p whyroad-signals --example digest -- LOG...`
#![allow(clippy::print_stdout, reason = "an example's output is for the reader")]

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::{Column, SignalTable};

fn digest(table: &SignalTable) -> u64 {
    // Its keys are constant.
    let mut into = DefaultHasher::new();
    for (name, column) in table.frame_columns.iter().chain(&table.target_columns) {
        name.hash(&mut into);
        match column {
            Column::Number(values) => values.iter().for_each(|v| v.to_bits().hash(&mut into)),
            Column::Flag(values) => values.iter().for_each(|v| format!("{v:?}").hash(&mut into)),
            Column::Category { codes, .. } => codes.hash(&mut into),
        }
    }
    format!("{:?}", table.unavailable).hash(&mut into);
    into.finish()
}

fn main() {
    let paths: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    let (sources, _) = find_sources(None, &paths);
    for source in &sources {
        let Some(drive) = read(source, &Options::default()).0 else { continue };
        let started = std::time::Instant::now();
        let table = whyroad_signals::derive(&drive);
        let (ms, rows) = (started.elapsed().as_secs_f64() * 1e3, table.target_columns.values().next());
        let rows = rows.map_or(0, Column::len);
        println!("{} {rows} rows {:016x} {ms:.1} ms", drive.meta.drive_id, digest(&table));
    }
}
