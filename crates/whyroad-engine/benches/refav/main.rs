//! RefAV's functions on an Argoverse 2 log, as RefAV's own code answers them and as a rule does (the first line of each
//! in docs/reference/refav.md, for vehicles): `WHYROAD_PEERS=PYTHON WHYROAD_REFAV=CHECKOUT cargo bench -p
//! whyroad-engine --bench refav -- LOG`. Without the two variables only Whyroad is timed. LOG has the ego among its
//! annotations (see `peer.py`, which names what Python needs). Whyroad's time is from the drive in memory to the rows
//! for which the rule holds; reading the log is stated by itself, and RefAV reads it again for each question.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a bench prints, and may panic")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use whyroad_engine::objects::signals_for;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_mining::fast::layout::RowSet;
use whyroad_mining::fast::{Evaluation, Plan, Signals};
use whyroad_mining::language::Subject;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Drive, ScenarioId, Tri};
use whyroad_signals::Catalog;

/// Function and rule of the first line of each function that can be asked.
fn lines() -> Vec<(String, String)> {
    let page = include_str!("../../../../docs/reference/refav.md");
    let mut out: Vec<(String, String)> = Vec::new();
    for line in page.lines().filter(|l| l.starts_with("| `")) {
        let cells: Vec<&str> = line.trim().trim_matches('|').split('|').collect();
        let cell = |i: usize| cells[i].trim().trim_matches('`').to_owned();
        let (function, rule) = (cell(0), cell(2));
        let asked = !rule.starts_with("an option") && !rule.starts_with("cannot");
        if asked && out.iter().all(|(f, _)| *f != function) {
            out.push((function, rule.replace(", R)", ", vehicle)")));
        }
    }
    out
}

/// Rows for which the rule holds.
fn answer(rule: &str, drive: &Drive) -> usize {
    let class = ScenarioId::custom("bench");
    let rule = compile_text(rule, Subject::from_word("vehicle"), &class, Catalog::bundled(), "docs");
    let rule = rule.unwrap();
    let table = signals_for(&rule, || Ok(drive.clone()), || unreachable!("no other signals")).unwrap();
    let (plan, columns) = (Plan::of_rules([&rule]), Signals::of_table(&table));
    let evaluation = Evaluation::new(&plan, &columns);
    let holds = |(i, span): (usize, &TargetSpan)| {
        let truth = evaluation.truth(plan.rules[0].node(rule.when), RowSet::Object(i));
        (0..span.frames.len()).filter(|row| truth.at(*row) == Tri::True).count()
    };
    table.targets.iter().enumerate().map(holds).sum()
}

/// Seconds of the fastest round, and what it returned.
fn fastest<T>(rounds: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let start = Instant::now();
        let result = work();
        (start.elapsed().as_secs_f64(), result)
    };
    (0..rounds).map(|_| once()).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// Seconds and rows of each function that RefAV answers.
fn peer(log: &Path) -> BTreeMap<String, (f64, usize)> {
    let (Some(python), Some(refav)) = (std::env::var_os("WHYROAD_PEERS"), std::env::var_os("WHYROAD_REFAV"))
    else {
        return BTreeMap::new();
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/refav/peer.py");
    let output = Command::new(python).arg(script).arg(refav).arg(log).output().unwrap();
    let parsed = String::from_utf8(output.stdout).unwrap();
    let line = |line: &str| {
        let mut words = line.split_whitespace();
        let (name, seconds, rows) = (words.next()?, words.next()?, words.next()?);
        match (seconds.parse(), rows.parse()) {
            (Ok(seconds), Ok(rows)) => Some((name.to_owned(), (seconds, rows))),
            _ => {
                println!("RefAV: {line}");
                None
            }
        }
    };
    parsed.lines().filter_map(line).collect()
}

fn main() {
    let Some(log) = std::env::args().skip(1).find(|a| !a.starts_with('-')).map(PathBuf::from) else {
        println!("usage: cargo bench -p whyroad-engine --bench refav -- LOG");
        return;
    };
    let sources = find_sources(None, std::slice::from_ref(&log)).0;
    let (reading, drive) = fastest(3, || read(sources.first().unwrap(), &Options::default()).0.unwrap());
    let rows: usize = drive.tracks.iter().map(|t| t.frames.len()).sum();
    println!("{} objects, {rows} rows; reading the log once: {:.1} ms", drive.tracks.len(), reading * 1e3);
    let theirs = peer(&log);
    println!(
        "{:<34} {:>12} {:>12} {:>10} {:>8} {:>8}",
        "function", "whyroad, ms", "RefAV, s", "ratio", "rows", "RefAV's"
    );
    for (function, rule) in lines() {
        let (ours, found) = fastest(5, || answer(&rule, &drive));
        let (seconds, ratio, rows) = match theirs.get(&function) {
            Some((s, rows)) => (format!("{s:.2}"), format!("{:.0}x", s / ours), rows.to_string()),
            None => ("-".to_owned(), "-".to_owned(), "-".to_owned()),
        };
        println!("{function:<34} {:>12.3} {seconds:>12} {ratio:>10} {found:>8} {rows:>8}", ours * 1e3);
    }
}
