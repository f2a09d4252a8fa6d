//! `whyroad evaluate` on the demo's episodes and the truth that the simulator's outputs give
//! (`examples/drives/*/truth.jsonl`).
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use std::path::Path;
use std::process::{Command, Output};

fn whyroad(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn the_demo_meets_its_truth_and_a_worse_truth_fails() {
    let dir = tempfile::tempdir().unwrap();
    assert!(whyroad(&["demo", "--out", dir.path().to_str().unwrap()]).status.success());
    let drives = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let truth = ["back_street", "multilane", "signal_junction"]
        .map(|d| drives.join(d).join("truth.jsonl").to_str().unwrap().to_owned());
    let mined = dir.path().join("mined");
    let mined = mined.to_str().unwrap();
    let args =
        ["evaluate", "--episodes", mined, "--format", "json", "--truth", &truth[0], &truth[1], &truth[2]];
    let output = whyroad(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let entries: usize = truth
        .iter()
        .map(|f| std::fs::read_to_string(f).unwrap().lines().filter(|l| l.contains("keyframe_ns")).count())
        .sum();
    assert_eq!(report["total"]["truth"], entries);
    assert_eq!(report["total"]["missed"], 0, "{}", report["missed"]);
    assert_eq!(report["total"]["spurious"], 0, "{}", report["spurious"]);
    assert_eq!(report["macro_f1"], 1.0);

    // The challenge's figures on the same: everything is found, so what is left is where ranges begin and end.
    let lake = dir.path().join("lake");
    let sequences = dir.path().join("sequences");
    let (lake, sequences) = (lake.to_str().unwrap(), sequences.to_str().unwrap());
    let metric = ["evaluate", "--metric", "av2-scenario-mining", "--format", "json"];
    let rest = [
        "--episodes",
        mined,
        "--lake",
        lake,
        "--write",
        sequences,
        "--truth",
        &truth[0],
        &truth[1],
        &truth[2],
    ];
    let output = whyroad(&[&metric[..], &rest[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let of_lake: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(of_lake["mean"]["log_balanced_accuracy"], 1.0);
    assert!(of_lake["mean"]["hota_temporal"].as_f64().unwrap() > 0.5, "{of_lake}");
    let written = |name: &str| format!("{sequences}/{name}.jsonl");
    let output = whyroad(
        &[&metric[..], &["--truth", &written("truth"), "--predictions", &written("predictions")]].concat(),
    );
    let of_files: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(of_files, of_lake);

    // An entry that never happened: the figure falls and a threshold is missed.
    let wrong = dir.path().join("wrong.jsonl");
    let never = r#"{"complete": ["reactive_agent.animal"], "drives": ["multilane-ego"]}
{"scenario_id": "reactive_agent.animal.crossing", "drive_id": "multilane-ego", "start_ns": 1767225614800000000, "keyframe_ns": 1767225616800000000, "end_ns": 1767225618700000000}
"#;
    std::fs::write(&wrong, never).unwrap();
    let args =
        ["evaluate", "--episodes", mined, "--truth", wrong.to_str().unwrap(), "--min-f1", "0.9", "--details"];
    let output = whyroad(&args);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("macro F1 is 0.000, under 0.9"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("missed  reactive_agent.animal.crossing multilane-ego"));

    // A line that cannot be used is named, and the code says that input was lost.
    std::fs::write(&wrong, "{\"scenario_id\": \"reactive_agent.cutin.urgnet\"}\n").unwrap();
    let output =
        whyroad(&["--lang", "zh", "evaluate", "--episodes", mined, "--truth", wrong.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("evaluate.truth.line") && text(&output.stderr).contains("已跳过"));
}
