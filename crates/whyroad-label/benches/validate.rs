//! How fast a label is checked, as ratios to a bare serde_json parse measured in the same run:
//! `cargo bench -p whyroad-label --bench validate`. No harness: the numbers wanted are ratios, of the
//! fastest rounds, because on a shared machine everything else measures the neighbours.
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

/// Microseconds a call; the rounds of what is compared are interleaved by the caller's loop.
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
    // `cargo test --benches` runs this too; then once is enough to see that it works.
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
    many_faults(quick);
}

/// A document with a fault in each of many components, on one line: time per fault must not grow with their number.
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
