//! The robustness of one formula of signal temporal logic over one long signal, against rtamt (discrete time, offline):
//! `eventually[0:10] always[0:5] (x < 3)`, in samples.

use crate::cost::timed;
use std::process::Command;
use whyroad_mining::fast::layout::RowSet;
use whyroad_mining::fast::{Evaluation, Plan, Signals};
use whyroad_mining::rule::text::compile_text;
use whyroad_model::{Column, Nanos, SignalTable};
use whyroad_signals::Catalog;

/// A wave with a drift, the same in Python.
fn signal(n: usize) -> Vec<f64> {
    (0..n).map(|i| 5.0 + 4.0 * (i as f64 * 0.37).sin() + 2.0 * (i as f64 * 0.011).cos()).collect()
}

/// Compares times, and the values where both speak of the same window.
pub fn run(n: usize, rounds: usize) {
    let table = SignalTable {
        times: (0..n as i64).map(|i| Nanos(i * 100_000_000)).collect(),
        frame_columns: [("ego.speed".to_owned(), Column::Number(signal(n)))].into(),
        ..SignalTable::default()
    };
    // `for` looks to both sides of a row, `within` ahead as STL does: always is not eventually not.
    let text = "(not ((not (ego.speed < 3 m/s)) within 0.5 s)) within 1 s";
    let class = "proactive.turn.straight".parse().expect("a class");
    let rule = compile_text(text, None, &class, Catalog::bundled(), "bench").expect("a rule");
    let plan = Plan::of_rules([&rule]);
    let when = plan.rules[0].node(rule.when);
    let ours = || {
        let signals = Signals::of_table(&table);
        let evaluation = Evaluation::new(&plan, &signals);
        evaluation.margins(when, RowSet::Drive, 0..n)
    };
    let (mut best, mut margins) = (f64::INFINITY, Vec::new());
    for _ in 0..rounds * 5 {
        let (cost, out) = timed(ours);
        best = best.min(cost.seconds);
        margins = out;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mine/stl.py");
    let answer = Command::new("python3").args([script, &n.to_string()]).output();
    let Some(answer) = answer.ok().filter(|a| a.status.success()) else {
        println!("mine/stl/{n}: {best:.6} s; rtamt: skipped: Python lacks it");
        return;
    };
    let text = String::from_utf8_lossy(&answer.stdout);
    let mut lines = text.lines();
    let seconds: f64 = lines.next().and_then(|l| l.parse().ok()).expect("seconds");
    let theirs: Vec<f64> = lines.filter_map(|l| l.parse().ok()).collect();
    // Ours is in typical magnitudes of a speed (5 m/s), and unknown where the window leaves the recording.
    let compared = margins.iter().zip(&theirs).filter(|(m, _)| !m.is_nan());
    let differ = compared.clone().filter(|(m, r)| (*m * 5.0 - *r).abs() > 1e-9).count();
    println!(
        "mine/stl/{n}: {best:.6} s; rtamt {seconds:.3} s, {:.0} x; {} values compared, {differ} differ",
        seconds / best,
        compared.count()
    );
}
