//! How fast rules run on stored signals, as ratios measured in the same run on all cores:
//! `cargo bench -p whyroad-engine --bench mine [-- [all|one|stl] [ROWS] [ROUNDS]]` (20 000 000 rows of targets and 3
//! rounds by default; some GB of temporary files). `mine/all`: all bundled rules against bare decoding of the columns
//! that they use. `mine/one`: single rules against the same question to DuckDB and Polars. `mine/stl`: a formula's
//! robustness against rtamt. Peers are asked through Python and left out, with a notice, where it lacks them. Every
//! round begins at closed files; rounds are interleaved; the fastest counts. CPU seconds stand beside the seconds: on a
//! machine with other work they are the steadier figure.
#![allow(clippy::print_stdout, clippy::expect_used)] // printing is what a bench is for

mod cost;
mod cpu;
mod data;
mod peers;
mod stl;

use cost::{Cost, timed};
use data::Stored;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs::File;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use whyroad_engine::mine::find_stored;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::fast::Plan;
use whyroad_signals::Catalog;

fn main() {
    // `cargo test --benches` runs this too; then a little is enough to see that it works.
    let quick = std::env::args().any(|a| a == "--test");
    let mut numbers = std::env::args().filter_map(|a| a.parse::<usize>().ok());
    let rows = numbers.next().unwrap_or(if quick { 150_000 } else { 20_000_000 });
    let rounds = numbers.next().unwrap_or(if quick { 1 } else { 3 });
    let chosen: Vec<String> =
        std::env::args().filter(|a| ["all", "one", "stl"].contains(&a.as_str())).collect();
    let asked = |part: &str| chosen.is_empty() || chosen.iter().any(|c| c == part);
    if asked("all") || asked("one") {
        stored(rows, rounds, asked);
    }
    if asked("stl") {
        stl::run(if quick { 2_000 } else { 20_000 }, rounds);
    }
}

/// The parts that run on stored signals.
fn stored(rows: usize, rounds: usize, asked: impl Fn(&str) -> bool) {
    let rules = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0;
    let plan = Plan::of(&rules);
    let of_rules = plan.rules.iter().flat_map(|r| r.when_signals.iter().chain(&r.later_signals));
    let used: BTreeSet<&str> = of_rules
        .map(String::as_str)
        .chain(peers::QUESTIONS.iter().flat_map(|q| q.signals.iter().copied()))
        .collect();
    let dir = tempfile::tempdir().expect("a temporary folder");
    let tables = data::bundled(&|name| used.contains(name));
    let (written, folders) = timed(|| data::write(dir.path(), &tables, rows));
    let stored = data::open(&folders);
    let total: usize = stored.iter().map(|s| s.file.contents().drives[s.drive].target_rows()).sum();
    let size = |folder: &PathBuf| {
        TABLES.map(|t| std::fs::metadata(folder.join(t)).map_or(0, |m| m.len())).iter().sum::<u64>()
    };
    println!(
        "{total} target rows in {} drives, {} columns, {:.2} GB, written in {:.0} s",
        stored.len(),
        stored[0].file.signals(0).len(),
        folders.iter().map(size).sum::<u64>() as f64 / 1e9,
        written.seconds
    );
    if asked("all") {
        let (mut floor, mut ours, mut episodes) = (Cost::WORST, Cost::WORST, 0);
        for _ in 0..rounds {
            floor = floor.least(timed(|| decode(&folders, &used)).0);
            let (cost, found) = timed(|| mine(&folders, &rules, &plan));
            (ours, episodes) = (ours.least(cost), found);
        }
        println!(
            "mine/all/{total}: {} rules, {episodes} episodes: {ours}; bare decode of the columns used {floor}; ratio {:.2}, of CPU {:.2}",
            rules.rules.len(),
            ours.seconds / floor.seconds,
            ours.cpu / floor.cpu
        );
    }
    if asked("one") {
        peers::run(dir.path(), &folders, total, rounds);
    }
}

const TABLES: [&str; 2] = ["frames.parquet", "targets.parquet"];

/// All rules on all drives, arbitrated; the number of episodes.
fn mine(folders: &[PathBuf], rules: &RuleSet, plan: &Plan<'_>) -> usize {
    let all: Vec<usize> = (0..plan.rules.len()).collect();
    let one = |s: &Stored| {
        let found = find_stored(plan, &s.file, s.drive, &all).expect("readable");
        let times = s.file.times(s.drive).expect("readable");
        arbitrated(rules, &s.file.contents().drives[s.drive].drive_id, &times, found).episodes.len()
    };
    data::open(folders).par_iter().with_max_len(1).map(one).sum()
}

/// Every column that a rule may read, decoded by the common Rust reader from the same row groups and dropped.
fn decode(folders: &[PathBuf], used: &BTreeSet<&str>) -> usize {
    let groups = |folder: &PathBuf| {
        TABLES.into_iter().flat_map(|table| row_groups(&folder.join(table), used)).collect::<Vec<_>>()
    };
    let builders: Vec<_> = folders.par_iter().flat_map_iter(groups).collect();
    let one = |builder: ParquetRecordBatchReaderBuilder<File>| {
        let batches = builder.build().expect("readable");
        batches.map(|b| black_box(b.expect("readable")).num_rows()).sum::<usize>()
    };
    builders.into_par_iter().with_max_len(1).map(one).sum()
}

/// A reader for each row group of a file; its metadata are read once.
fn row_groups(path: &Path, used: &BTreeSet<&str>) -> Vec<ParquetRecordBatchReaderBuilder<File>> {
    let file = File::open(path).expect("there");
    let metadata = ArrowReaderMetadata::load(&file, ArrowReaderOptions::default()).expect("readable");
    let one = |group: usize| {
        let file = File::open(path).expect("there");
        let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata.clone());
        let fields = builder.schema().fields().iter().enumerate();
        let wanted: Vec<usize> =
            fields.filter(|(_, f)| used.contains(f.name().as_str())).map(|(i, _)| i).collect();
        let rows = usize::try_from(builder.metadata().row_group(group).num_rows()).expect("a size");
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
        builder.with_row_groups(vec![group]).with_projection(mask).with_batch_size(rows)
    };
    (0..metadata.metadata().num_row_groups()).map(one).collect()
}
