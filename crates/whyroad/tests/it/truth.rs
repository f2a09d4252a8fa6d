//! Mining on simulated drives against what the simulator or its script says happened there (`examples/truth/{agents,roads,traffic}`, sets
//! `seen` and `unseen`, of traffic `second` and `fresh` too), with the figures of docs/reference/accuracy.md as floors (`examples/truth/floors.json`).
//!
//! In a debug build a few drives of each set are mined, so that the test stays quick. All of them, with the table of each set:
//! `WHYROAD_TRUTH=all cargo test --release -p whyroad --test truth -- --nocapture`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic, and prints its tables")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

const PARTS: &[&str] = &["agents", "roads", "traffic"];
const SETS: [&str; 4] = ["seen", "unseen", "second", "fresh"];

/// One set of one part: the folders of its drives and its files of truth.
#[derive(Default)]
struct Set {
    drives: Vec<PathBuf>,
    truth: Vec<PathBuf>,
}

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth")
}

fn is_drive(folder: &Path) -> bool {
    folder.join("fcd.xml.gz").is_file() || folder.join("drive.yaml").is_file()
}

/// A set is a folder with the name of one, or all folders whose names begin so.
fn gather(folder: &Path, set: Option<&'static str>, sets: &mut BTreeMap<&'static str, Set>) {
    let mut entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let set = set.or_else(|| SETS.into_iter().find(|s| name.starts_with(s)));
        if path.is_dir() {
            if let (Some(s), true) = (set, is_drive(&path)) {
                sets.entry(s).or_default().drives.push(path.clone());
            }
            gather(&path, set, sets);
        } else if let (Some(s), "truth.jsonl") = (set, name.as_str()) {
            sets.entry(s).or_default().truth.push(path);
        }
    }
}

fn whyroad(args: &[String]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .env_remove("WHYROAD_FRAMEWORK")
        .env_remove("WHYROAD_LANG")
        .output()
        .unwrap();
    // 1: there are findings about the logs, which is fine here.
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

/// Brings a drive into the lake; `egos.txt` beside a simulation names its egos where they are not `ego`.
fn ingest(drive: &Path, lake: &str) {
    let format = if drive.join("fcd.xml.gz").is_file() { "sumo" } else { "table" };
    let mut args = words(&["ingest", format, "--lake", lake]);
    if let Ok(egos) = std::fs::read_to_string(drive.join("egos.txt")) {
        args.extend(egos.split_whitespace().flat_map(|e| words(&["--ego", e])));
    }
    args.push(drive.display().to_string());
    whyroad(&args);
}

/// The truth about the drives that are in the lake, in one file: the rest is not mined.
fn truth_of(set: &Set, lake: &str, into: &Path) {
    let drives: Vec<String> = Path::new(lake)
        .join("drives")
        .read_dir()
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    for (i, file) in set.truth.iter().enumerate() {
        let text = std::fs::read_to_string(file).unwrap();
        let mut kept = String::new();
        for line in text.lines() {
            let mut value: Value = serde_json::from_str(line).unwrap();
            if let Some(all) = value.get_mut("drives").and_then(Value::as_array_mut) {
                all.retain(|d| drives.iter().any(|there| there == d.as_str().unwrap()));
                kept += &format!("{value}\n");
            } else if drives.iter().any(|there| there == value["drive_id"].as_str().unwrap()) {
                kept += &format!("{line}\n");
            }
        }
        std::fs::write(into.join(format!("truth{i:03}.jsonl")), kept).unwrap();
    }
}

/// Figures of a set, of every `step`-th drive.
fn figures(set: &Set, step: usize) -> (Value, String) {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).display().to_string();
    let (lake, mined) = (at("lake"), at("mined"));
    for drive in set.drives.iter().step_by(step) {
        ingest(drive, &lake);
    }
    whyroad(&words(&["mine", "--lake", &lake, "--out", &mined]));
    truth_of(set, &lake, dir.path());
    let mut args = words(&["evaluate", "--episodes", &mined, "--truth"]);
    args.extend((0..set.truth.len()).map(|i| at(&format!("truth{i:03}.jsonl"))));
    let table = whyroad(&args);
    args.extend(words(&["--json"]));
    (serde_json::from_str(&whyroad(&args)).unwrap(), table)
}

#[test]
fn what_the_simulators_say_is_found() {
    let all = std::env::var("WHYROAD_TRUTH").is_ok_and(|v| v == "all");
    let floors = std::fs::read_to_string(examples().join("floors.json")).unwrap();
    let floors: Value = serde_json::from_str(&floors).unwrap();
    let mut checked = 0;
    for part in PARTS {
        let mut sets = BTreeMap::new();
        gather(&examples().join(part), None, &mut sets);
        for (name, set) in &sets {
            let floor = &floors[part][name][if all { "all" } else { "some" }];
            let Some(step) = floor["every"].as_u64() else { continue };
            let (found, table) = figures(set, usize::try_from(step).unwrap());
            println!("{part}, {name}, every drive of {step}:\n{table}");
            let figure = |key: &str| found[key].as_f64().unwrap_or(f64::NAN);
            let at_least = |key: &str, floor: &Value| {
                let least = floor.as_f64().unwrap();
                assert!(
                    figure(key) >= least,
                    "{part}, {name}: {key} is {}, under {least}\n{table}",
                    figure(key)
                );
            };
            at_least("macro_f1", &floor["macro_f1"]);
            at_least("macro_classes", &floor["classes"]);
            let error = figure("keyframe_error_median_s");
            assert!(
                error <= floor["keyframe_s"].as_f64().unwrap(),
                "{part}, {name}: keyframes are {error} s off"
            );
            checked += 1;
        }
    }
    assert!(checked > 0, "no set has a floor");
}
