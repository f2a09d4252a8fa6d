//! The quality report of imported causal texts on the bundled simulated drives: the same texts in the formats of three
//! tools, true ones and some with one known fault, each of which must be reported as its kind and as nothing else. What
//! happens in the drives is the simulator's (`examples/drives/truth.jsonl` and README).
#![allow(clippy::print_stdout, reason = "what was reported is what a reader wants to see")]

use crate::label_checks::lake;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_engine::label_drives::LabelDrives;
use whyroad_framework::Framework;
use whyroad_label::check::Checker;
use whyroad_label::import::{Place, Reading, alpamayo2, auto_labeler, draft, ood_reasoning};
use whyroad_lake::Lake;
use whyroad_model::messages::ScenarioLabel;
use whyroad_model::{DriveId, Nanos};

/// Drive, second, kinds that must be reported, text. Omission is the counterfactual's, and stated where the text leaves
/// out whoever holds the ego.
const TEXTS: &[(&str, f64, &[&str], &str)] = &[
    (
        "back_street-ego",
        3.7,
        &[],
        "A pedestrian on the left is crossing the road ahead and will be in the ego's path, so the ego slows down and yields to the pedestrian.",
    ),
    (
        "back_street-ego",
        3.7,
        &["motion"],
        "A pedestrian on the left is crossing the road ahead but leaves enough room, so the ego accelerates to get past the pedestrian.",
    ),
    (
        "back_street-ego",
        3.7,
        &["omission"],
        "The road surface is rough here and the houses stand close, so the ego slows down to a comfortable speed.",
    ),
    (
        "back_street-ego",
        3.7,
        &["late_evidence"],
        "A pedestrian on the left is crossing the road and in the end reached the other side safely, so the ego slows down and yields to the pedestrian.",
    ),
    (
        "back_street-ego",
        33.7,
        &[],
        "A pedestrian is on the crosswalk at the junction ahead, so the ego slows down and yields before going on.",
    ),
    (
        "back_street-ego",
        37.4,
        &["route"],
        "The pedestrian has left the crosswalk and the route leads to the left at the junction, so the ego turns left.",
    ),
    (
        "multilane-ego",
        16.9,
        &[],
        "A car on the left is cutting into the ego's lane and the gap becomes too small, so the ego slows down to yield to it.",
    ),
    (
        "multilane-ego",
        16.9,
        &["motion"],
        "A car on the left is cutting into the ego's lane and needs the whole lane, so the ego comes to a complete stop to let it in.",
    ),
    (
        "signal_junction-ego",
        49.7,
        &["scene"],
        "The light is red for the ego's lane and an oncoming car is far away, so the ego turns left at the junction.",
    ),
    (
        "multilane-ego",
        42.0,
        &["motion"],
        "The truck ahead is slow and the right lane is free, so the ego changes lanes to the right.",
    ),
    (
        "multilane-ego",
        47.1,
        &[],
        "The road ahead bends sharply and the bend is too tight for this speed, so the ego slows down before the bend.",
    ),
    (
        "multilane-ego",
        47.1,
        &["motion"],
        "The road ahead bends gently and nothing is in the way, so the ego speeds up through the bend.",
    ),
    (
        "signal_junction-ego",
        7.9,
        &[],
        "The lead car brakes hard for the red light and the gap to it shrinks quickly, so the ego brakes and follows it at a safe distance.",
    ),
    (
        "signal_junction-ego",
        7.9,
        &["motion"],
        "The lead car brakes hard but the gap is still large, so the ego accelerates towards it.",
    ),
    ("signal_junction-ego", 7.9, &["omission", "text"], "Slow."),
    (
        "signal_junction-ego",
        23.0,
        &[],
        "The light has turned green and the lead car has moved off, so the ego moves off behind it.",
    ),
    (
        "signal_junction-ego",
        28.6,
        &["late_evidence"],
        "A pedestrian is on the crosswalk; three seconds later they have left it, so the ego slows down and yields to the pedestrian.",
    ),
    (
        "signal_junction-ego",
        49.7,
        &["route"],
        "An oncoming car is still far away and the junction is clear, so the ego turns right at the junction.",
    ),
];

/// Times are microseconds; one each, so that every text is an event of its own.
fn microseconds(i: usize) -> i64 {
    (TEXTS[i].1 * 1e6) as i64 + i as i64
}

fn alpamayo() -> Reading {
    let line = |i: usize| {
        let (drive, _, _, text) = TEXTS[i];
        json!({ "clip_id": drive, "t0_us": microseconds(i), "chain_of_causation": text }).to_string()
    };
    let lines: Vec<String> = (0..TEXTS.len()).map(line).collect();
    alpamayo2::read("a2.jsonl", "a2", &lines.join("\n"))
}

fn auto_labels() -> Reading {
    let mut out = Reading::default();
    for (i, (drive, at, _, text)) in TEXTS.iter().enumerate() {
        let us = microseconds(i);
        let results = json!({ "results": {
            "event_start_frame": (at * 10.0) as i64, "event_start_timestamp": us, "coc_prompt_version": "v3",
            "final_content": { "ego_behavior_schema": { "effect_on_ego_behavior": text } },
        } });
        // JSON is YAML.
        out.append(auto_labeler::read_text("cot.yaml", drive, &format!("cot_{us}"), &results.to_string()));
    }
    out
}

/// One row per drive with all of its events, under either name of the text.
fn ood() -> Reading {
    let drives: BTreeSet<&str> = TEXTS.iter().map(|t| t.0).collect();
    let row = |drive: &&str| {
        let of_drive = TEXTS.iter().enumerate().filter(|(_, t)| t.0 == *drive);
        let events: Vec<Value> = of_drive
            .map(|(i, t)| {
                let name = if i % 2 == 0 { "coc" } else { "cot" };
                json!({ "event_start_timestamp": microseconds(i), name: t.3 })
            })
            .collect();
        let row = json!({ "clip_id": drive, "events": json!(events).to_string(), "split": "train" });
        row.as_object().unwrap().clone()
    };
    let rows: Vec<_> = drives.iter().map(row).collect();
    ood_reasoning::read("ood_reasoning.parquet", &rows)
}

/// Kinds reported for each text of `TEXTS`.
fn reported(reading: &Reading, lake: &Lake, checker: &Checker<'_>) -> Vec<BTreeSet<&'static str>> {
    assert!(reading.diagnostics.is_empty(), "{:#?}", reading.diagnostics);
    assert_eq!(reading.found.len(), TEXTS.len());
    let scenario = ScenarioLabel { l1: "other".into(), l2: "other".into(), l3: None, full_id: None };
    let mut out = vec![BTreeSet::new(); TEXTS.len()];
    for text in &reading.found {
        let i = (0..TEXTS.len()).find(|&i| microseconds(i) == text.at_us && TEXTS[i].0 == text.clip).unwrap();
        assert_eq!(text.text, TEXTS[i].3);
        let id = DriveId::from(text.clip.as_str());
        let drive = lake.read_drive(&id).unwrap();
        let zero = Nanos::parse_iso("2026-01-01T00:00:00Z").unwrap();
        let place = Place { drive: &id, times: &drive.times, zero, scenario: &scenario, by: "model" };
        let label = draft(text, &place).unwrap();
        let quality = checker.quality(&label);
        assert!(quality.compared);
        for (kind, d) in &quality.findings {
            println!("{i} {}: {} {}", kind.id(), d.code, d.message.en);
            out[i].insert(kind.id());
        }
    }
    out
}

#[test]
fn faults_of_imported_texts_are_reported_by_kind() {
    let dir = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let folders: Vec<PathBuf> =
        ["back_street", "multilane", "signal_junction"].map(|n| root.join(n)).to_vec();
    let lake = lake(dir.path(), &folders);
    let checker = Checker::new(Framework::bundled())
        .with_recordings(Arc::new(LabelDrives::new(lake.clone(), Framework::bundled())));
    let mut wrong = Vec::new();
    for (format, reading) in [("alpamayo2", alpamayo()), ("auto-labeler", auto_labels()), ("ood", ood())] {
        for (i, found) in reported(&reading, &lake, &checker).into_iter().enumerate() {
            let expected: BTreeSet<&str> = TEXTS[i].2.iter().copied().collect();
            if found != expected {
                wrong.push(format!("{format}: expected {expected:?}, found {found:?}: {}", TEXTS[i].3));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of them\n{}", wrong.len(), wrong.join("\n"));
}
