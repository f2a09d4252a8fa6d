//! How fast rules run on stored signals, as ratios measured in the same run on all cores:
//! `cargo bench -p whyroad-mining --bench mine [-- ROWS]` (20 000 000 rows of targets unless said; some GB of temporary
//! files). `mine/all`: all bundled rules against bare decoding of the columns that they use. `mine/one`: single rules
//! against the same question to DuckDB and Polars. `mine/stl`: a formula's robustness against rtamt. Peers are asked
//! through Python and left out, with a notice, where it lacks them. Rounds are interleaved; the fastest counts.
#![allow(clippy::print_stdout, clippy::expect_used)] // printing is what a bench is for

mod data;
mod peers;
mod stl;

use data::Stored;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs::File;
use std::hint::black_box;
use std::time::Instant;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::engine::find_stored;
use whyroad_mining::fast::Plan;
use whyroad_signals::Catalogue;

/// Seconds that a call takes.
pub fn timed<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let out = black_box(f());
    (start.elapsed().as_secs_f64(), out)
}

fn main() {
    // `cargo test --benches` runs this too; then a little is enough to see that it works.
    let quick = std::env::args().any(|a| a == "--test");
    let rows = std::env::args().filter_map(|a| a.parse().ok()).next();
    let rows: usize = rows.unwrap_or(if quick { 150_000 } else { 20_000_000 });
    let rounds = if quick { 1 } else { 3 };
    let rules = RuleSet::of_framework(Framework::bundled(), Catalogue::bundled()).0;
    let plan = Plan::of(&rules);
    let of_rules = plan.rules.iter().flat_map(|r| r.when_signals.iter().chain(&r.later_signals));
    let used: BTreeSet<&str> = of_rules
        .map(String::as_str)
        .chain(peers::QUESTIONS.iter().flat_map(|q| q.signals.iter().copied()))
        .collect();
    let dir = tempfile::tempdir().expect("a temporary folder");
    let tables = data::bundled(&|name| used.contains(name));
    let (seconds, stored) = timed(|| data::write(dir.path(), &tables, rows));
    let total: usize = stored.iter().map(|s| s.file.contents().drives[s.drive].target_rows()).sum();
    let bytes = |s: &Stored| {
        ["frames", "targets"]
            .map(|t| std::fs::metadata(s.folder.join(t).with_extension("parquet")).map_or(0, |m| m.len()))
    };
    let size: u64 = stored.iter().filter(|s| s.drive == 0).flat_map(bytes).sum();
    println!(
        "{total} target rows in {} drives, {} columns, {:.1} GB, written in {seconds:.0} s",
        stored.len(),
        stored[0].file.signals(0).len(),
        size as f64 / 1e9
    );

    let mut best = [f64::INFINITY; 2];
    let mut episodes = 0;
    for _ in 0..rounds {
        best[0] = best[0].min(timed(|| decode(&stored, &used)).0);
        let (seconds, found) = timed(|| mine(&stored, &rules, &plan));
        best[1] = best[1].min(seconds);
        episodes = found;
    }
    println!(
        "mine/all/{total}: {} rules, {episodes} episodes: {:.2} s; bare decode of the columns used {:.2} s; ratio {:.2}",
        rules.rules.len(),
        best[1],
        best[0],
        best[1] / best[0]
    );
    peers::run(dir.path(), &stored, total, rounds);
    stl::run(if quick { 2_000 } else { 20_000 }, rounds);
}

/// All rules on all drives, arbitrated; the number of episodes.
fn mine(stored: &[Stored], rules: &RuleSet, plan: &Plan<'_>) -> usize {
    let all: Vec<usize> = (0..plan.rules.len()).collect();
    let one = |s: &Stored| {
        let found = find_stored(plan, &s.file, s.drive, &all).expect("readable");
        let times = s.file.times(s.drive).expect("readable");
        arbitrated(rules, &s.file.contents().drives[s.drive].drive_id, &times, found).episodes.len()
    };
    stored.par_iter().with_max_len(1).map(one).sum()
}

/// Every column that a rule may read, decoded from the same row groups and dropped.
fn decode(stored: &[Stored], used: &BTreeSet<&str>) -> usize {
    let one = |s: &Stored| -> usize {
        let tables = ["frames.parquet", "targets.parquet"];
        let values = tables.map(|name| {
            let file = File::open(s.folder.join(name)).expect("there");
            let builder = ParquetRecordBatchReaderBuilder::try_new(file).expect("readable");
            let fields = builder.schema().fields().iter().enumerate();
            let wanted: Vec<usize> =
                fields.filter(|(_, f)| used.contains(f.name().as_str())).map(|(i, _)| i).collect();
            let rows = builder.metadata().row_group(s.drive).num_rows();
            let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
            let reader = builder
                .with_row_groups(vec![s.drive])
                .with_projection(mask)
                .with_batch_size(usize::try_from(rows).expect("a size"));
            let batches = reader.build().expect("readable");
            batches.map(|b| black_box(b.expect("readable")).num_rows()).sum::<usize>()
        });
        values.iter().sum()
    };
    stored.par_iter().with_max_len(1).map(one).sum()
}
