//! Time of checking a label, as ratios to a bare serde_json parse measured in the same run: `cargo bench -p
//! whyroad-label --bench validate`. It has no harness: the result is a ratio of the fastest rounds, because on a shared
//! machine other measures include the load of other processes.
#![allow(clippy::print_stdout)] // printing is what a bench is for

use std::hint::black_box;
use std::time::Instant;
use whyroad_framework::Framework;
use whyroad_framework::check::{Document, Origin};
use whyroad_label::check::Checker;
use whyroad_model::messages::CocLabel;

const EXAMPLES: &[(&str, &str)] = &[
    ("zh/cutin", include_str!("../../../examples/cutin_urgent_example.json")),
    ("en/cutin", include_str!("../../../examples/cutin_urgent_example.en.json")),
    ("zh/lane_change", include_str!("../../../examples/lane_change_example.json")),
    ("zh/vru_crossing", include_str!("../../../examples/vru_crossing_example.json")),
    ("zh/blind_spot", include_str!("../../../examples/blind_spot_example.json")),
];

/// Microseconds per call; the caller's loop interleaves the rounds that are compared.
fn round(calls: usize, f: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..calls {
        f();
    }
    start.elapsed().as_secs_f64() * 1e6 / calls as f64
}

fn fastest(v: &[f64]) -> f64 {
    v.iter().copied().fold(f64::INFINITY, f64::min)
}

fn main() {
    // `cargo test --benches` also runs this; one round is enough for a test.
    let quick = std::env::args().any(|a| a == "--test");
    let (rounds, calls) = if quick { (1, 10) } else { (101, 500) };
    let checker = Checker::new(Framework::bundled());
    println!(
        "{:<28} {:>6} {:>9} {:>9} {:>9} {:>12} {:>12}",
        "validate/label", "bytes", "typed us", "value us", "check us", "check/typed", "check/value"
    );
    for (name, pretty) in EXAMPLES {
        let compact =
            serde_json::from_str::<serde_json::Value>(pretty).map(|v| v.to_string()).unwrap_or_default();
        for (form, text) in [("compact", compact.as_str()), ("pretty", *pretty)] {
            let mut found = Vec::new();
            let (mut typed, mut value, mut check) = (Vec::new(), Vec::new(), Vec::new());
            for _ in 0..rounds {
                typed.push(round(calls, &mut || {
                    black_box(serde_json::from_str::<CocLabel>(black_box(text)).ok());
                }));
                value.push(round(calls, &mut || {
                    black_box(serde_json::from_str::<serde_json::Value>(black_box(text)).ok());
                }));
                check.push(round(calls, &mut || {
                    let document = Document { origin: Origin::start(), bytes: black_box(text.as_bytes()) };
                    black_box(checker.check(&document, &mut found));
                }));
            }
            assert!(found.is_empty(), "{found:?}");
            let (t, v, c) = (fastest(&typed), fastest(&value), fastest(&check));
            println!(
                "{:<28} {:>6} {t:>9.2} {v:>9.2} {c:>9.2} {:>12.2} {:>12.2}",
                format!("{name}/{form}"),
                text.len(),
                c / t,
                c / v
            );
        }
    }
    documents(quick);
    many_faults(quick);
}

/// 100,000 documents in one run, all valid and with one invalid in ten, as ratios to a bare typed parse of the same
/// texts: the time for a file of labels, including findings and their messages. `WHYROAD_BENCH_DOCUMENTS=FOLDER` writes
/// the documents as JSON Lines, for `peers.py` in this folder.
fn documents(quick: bool) {
    let n = if quick { 50 } else { 100_000 };
    let checker = Checker::new(Framework::bundled());
    let folder = std::env::var("WHYROAD_BENCH_DOCUMENTS").ok();
    for (language, prefix) in [("zh", "zh/"), ("en", "en/")] {
        let labels: Vec<serde_json::Value> = EXAMPLES
            .iter()
            .filter(|(name, _)| name.starts_with(prefix))
            .filter_map(|(_, text)| serde_json::from_str(text).ok())
            .collect();
        for (what, faulty) in [("valid", false), ("one in ten faulty", true)] {
            let texts: Vec<String> = (0..n)
                .map(|i| {
                    let mut label = labels[i % labels.len()].clone();
                    if faulty && i % 10 == 0 {
                        break_one(&mut label, i / 10);
                    }
                    label.to_string()
                })
                .collect();
            if let Some(folder) = &folder {
                let file = format!("{folder}/{language}-{}.jsonl", if faulty { "faulty" } else { "valid" });
                if let Err(e) = std::fs::write(&file, texts.join("\n")) {
                    println!("{file}: {e}");
                }
            }
            let (mut typed, mut check, mut findings) = (Vec::new(), Vec::new(), 0);
            for _ in 0..if quick { 1 } else { 5 } {
                let start = Instant::now();
                for text in &texts {
                    black_box(serde_json::from_str::<CocLabel>(text).ok());
                }
                typed.push(start.elapsed().as_secs_f64());
                let (start, mut found) = (Instant::now(), Vec::new());
                for text in &texts {
                    let document = Document { origin: Origin::start(), bytes: text.as_bytes() };
                    black_box(checker.check(&document, &mut found));
                }
                check.push(start.elapsed().as_secs_f64());
                findings = found.len();
            }
            let (t, c) = (fastest(&typed), fastest(&check));
            println!(
                "{:<28} {n:>6} documents {what}: {:.2} us each, {:.2} of a typed parse, {findings} findings",
                format!("validate/documents/{language}"),
                c * 1e6 / n as f64,
                c / t
            );
        }
    }
}

/// One error of form, of a value or of a text, in rotation.
fn break_one(label: &mut serde_json::Value, turn: usize) {
    match turn % 4 {
        0 => label["keyframe"]["timestamp"] = "yesterday".into(),
        1 => label["driving_decision"]["longitudinal"] = "fly".into(),
        2 => label["critical_components"][0]["description"] = "test".into(),
        _ => {
            label.as_object_mut().map(|o| o.remove("coc_trace"));
        }
    }
}

/// A document with an error in each of many components, on one line: the time per error must not grow with their
/// number.
fn many_faults(quick: bool) {
    let checker = Checker::new(Framework::bundled());
    let mut last = f64::NAN;
    for n in if quick { [10, 20] } else { [20_000, 85_000] } {
        let mut label: serde_json::Value = serde_json::from_str(EXAMPLES[0].1).unwrap_or_default();
        label["critical_components"] = vec![serde_json::json!({}); n].into();
        let text = label.to_string();
        let start = Instant::now();
        let found = black_box(checker.check_text(&text)).len();
        let us = start.elapsed().as_secs_f64() * 1e6 / n as f64;
        println!(
            "{:<28} {n:>6} components, {found} findings: {us:.2} us each ({:.2} of the last)",
            "validate/faults",
            us / last
        );
        last = us;
    }
}
