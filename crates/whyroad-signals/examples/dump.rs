//! Prints selected signals of the first drive in a log as CSV, for inspection: seconds since the first frame, then one
//! column per signal; `target.` signals are those of the target whose id begins with the given text, or of every target
//! (`all`, with its id in a separate column). Unknown is empty.
//!
//! `cargo run -p whyroad-signals --example dump -- LOG TARGET_PREFIX|all|- SIGNAL...`, where LOG is a
//! log folder or a simulation in any format that `whyroad ingest` reads.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example's output is for the reader")]

use std::process::ExitCode;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::column::Tri;
use whyroad_model::{Column, SignalTable};

fn text(column: &Column, row: usize) -> String {
    match column {
        Column::Number(_) => column.number(row).map_or(String::new(), |x| format!("{x:.3}")),
        Column::Flag(_) => match column.flag(row) {
            Tri::True => "1".into(),
            Tri::False => "0".into(),
            Tri::Unknown => String::new(),
        },
        Column::Category { .. } => column.category(row).unwrap_or("").to_owned(),
    }
}

fn print_row(table: &SignalTable, names: &[String], frame: usize, row: Option<usize>, which: &str) {
    let values = names.iter().map(|name| match table.frame_columns.get(name) {
        Some(column) => text(column, frame),
        None => table.target_columns.get(name).zip(row).map_or(String::new(), |(c, r)| text(c, r)),
    });
    let t = table.times[frame].seconds_since(table.times[0]);
    println!("{t:.2},{which}{}", values.collect::<Vec<_>>().join(","));
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [log, target, names @ ..] = args.as_slice() else {
        eprintln!("usage: dump LOG TARGET_PREFIX|all|- SIGNAL...");
        return ExitCode::from(2);
    };
    let (sources, _) = find_sources(None, &[log.into()]);
    let Some(drive) = sources.first().and_then(|s| read(s, &Options::default()).0) else {
        eprintln!("{log} has no readable drive");
        return ExitCode::FAILURE;
    };
    let started = std::time::Instant::now();
    let table = whyroad_signals::derive(&drive);
    eprintln!(
        "{} targets, {} frames, {:.1} ms",
        table.targets.len(),
        table.times.len(),
        started.elapsed().as_secs_f64() * 1e3
    );
    eprintln!("unavailable: {:?}", table.unavailable);
    let all = target == "all";
    let spans: Vec<_> =
        table.targets.iter().filter(|t| all || t.id.as_str().starts_with(target.as_str())).collect();
    println!("t,{}{}", if all { "frame,target," } else { "" }, names.join(","));
    if all {
        for (span, frame) in spans.iter().flat_map(|s| (s.frames.start..s.frames.end).map(move |f| (*s, f))) {
            print_row(&table, names, frame, span.row(frame), &format!("{frame},{},", span.id.as_str()));
        }
    } else {
        for frame in 0..table.times.len() {
            print_row(&table, names, frame, spans.first().and_then(|s| s.row(frame)), "");
        }
    }
    ExitCode::SUCCESS
}
