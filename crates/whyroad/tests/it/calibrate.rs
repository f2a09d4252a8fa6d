//! `whyroad calibrate` and the built-in table: what scores say about drives that the table was not made from.
//!
//! The drives of the committed sample (`examples/truth/{agents,roads}`) are in no table:
//! `docs/reference/calibration.md` says how it was made.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic, and prints its figures")]

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use whyroad_framework::Framework;
use whyroad_model::messages::EpisodeRecord;
use whyroad_report::calibration::{CalibrationError, measure};
use whyroad_report::evaluation::judge;
use whyroad_report::evaluation::truth::TruthSet;

/// Largest expected calibration error on held-out drives.
const LARGEST_ERROR: f64 = 0.06;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn whyroad(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whyroad"));
    let o = command.args(args).env_remove("WHYROAD_FRAMEWORK").env_remove("WHYROAD_LANG").output().unwrap();
    // 1: there are findings about the logs, which is fine here.
    assert!(matches!(o.status.code(), Some(0 | 1)), "{args:?}: {}", String::from_utf8_lossy(&o.stderr));
    o
}

fn records(mined: &Path) -> Vec<EpisodeRecord> {
    let text = std::fs::read_to_string(mined.join("episodes.jsonl")).unwrap();
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

/// Drives of the sample, with their truth files.
fn sample(lake: &str) -> TruthSet {
    let mut truth = TruthSet::default();
    for part in ["agents", "roads"] {
        let set = root().join("examples/truth").join(part).join("seen");
        let mut drives: Vec<PathBuf> = set.read_dir().unwrap().map(|e| e.unwrap().path()).collect();
        drives.sort();
        let mut files: Vec<PathBuf> = vec![set.join("truth.jsonl")];
        for drive in drives.iter().filter(|d| d.is_dir()) {
            let path = drive.to_str().unwrap();
            if drive.join("fcd.xml.gz").is_file() {
                whyroad(&["ingest", "sumo", "--lake", lake, "--sensor-range", "inf", path]);
            } else {
                whyroad(&["ingest", "table", "--lake", lake, path]);
            }
            files.push(drive.join("truth.jsonl"));
        }
        for file in files.iter().filter(|f| f.is_file()) {
            let text = std::fs::read_to_string(file).unwrap();
            assert_eq!(truth.read(&text, "truth", &|_| true), []);
        }
    }
    truth
}

#[test]
fn scores_are_shares_on_drives_that_the_table_was_not_made_from() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (lake, mined) = (at("lake"), at("mined"));
    let truth = sample(&lake);
    whyroad(&["mine", "--lake", &lake, "--out", &mined]);
    let records = records(Path::new(&mined));
    let judged: Vec<(&EpisodeRecord, bool)> =
        records.iter().zip(judge(&truth, &records)).filter_map(|(r, right)| Some((r, right?))).collect();
    // Where the leaf is open, the L2 has no share: the table was made before the rules found such episodes.
    let judged: Vec<_> = judged.into_iter().filter(|(r, _)| r.scenario_id.is_leaf()).collect();
    let calibrated: Vec<_> = judged.iter().filter(|(r, _)| r.calibrated == Some(true)).collect();
    let predictions = |of: &dyn Fn(&EpisodeRecord) -> f64| -> CalibrationError {
        measure(&calibrated.iter().map(|(r, right)| (of(r), *right)).collect::<Vec<_>>()).unwrap()
    };
    let (scores, margins) = (predictions(&|r| r.score), predictions(&|r| r.margin_score.unwrap()));
    println!("{} of {} judged episodes are of calibrated classes", calibrated.len(), judged.len());
    println!("scores: {scores:?}\nmargin scores: {margins:?}");
    assert!(calibrated.len() >= 60 && calibrated.len() * 10 >= judged.len() * 8);
    assert!(scores.expected <= LARGEST_ERROR, "{scores:?}");
    assert!(scores.expected < margins.expected && scores.brier < margins.brier, "{margins:?}");
    // A share is that of the table; without one, the score is the margin score.
    let table = &Framework::bundled().calibration;
    for r in &records {
        let share = table.share(&r.scenario_id, r.margin_score.unwrap());
        assert_eq!((r.calibrated, r.score), (Some(share.is_some()), share.or(r.margin_score).unwrap()));
    }
}

#[test]
fn verdicts_change_the_scores_of_their_class() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (lake, mined, again) = (at("lake"), at("mined"), at("again"));
    let drive = root().join("examples/drives/multilane");
    whyroad(&["ingest", "sumo", "--lake", &lake, drive.to_str().unwrap()]);
    whyroad(&["mine", "--lake", &lake, "--out", &mined]);
    let class = "reactive_agent.cutin.urgent";
    let first = records(Path::new(&mined)).into_iter().find(|r| r.scenario_id.to_string() == class).unwrap();
    // Eight people, two of whom find the class right.
    let line = |right: bool| {
        json!({
            "verdict": if right { "right" } else { "nothing" }, "episode_id": first.episode_id,
            "drive_id": first.drive_id, "scenario_id": class, "keyframe_ns": first.keyframe.timestamp.0,
            "score": first.score, "by": "lea",
        })
        .to_string()
    };
    let verdicts: Vec<String> = (0..8).map(|i| line(i < 2)).collect();
    std::fs::write(at("verdicts.jsonl"), verdicts.join("\n")).unwrap();

    // A copy of the framework gets the new table.
    for (name, text) in Framework::bundled_files() {
        let path = dir.path().join("framework").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let (framework, table) = (at("framework"), at("framework/schema/calibration.yaml"));
    let args =
        ["calibrate", "--framework", &framework, "--episodes", &mined, "--verdicts", &at("verdicts.jsonl")];
    let o = whyroad(&[&args[..], &["--fresh", "--out", &table, "--format", "json"]].concat());
    let told: Value = serde_json::from_slice(&o.stdout).unwrap();
    let of_class = &told["calibration"]["classes"][0];
    assert_eq!(
        (&of_class["id"], &of_class["judged"], &of_class["right"]),
        (&json!(class), &json!(8), &json!(2))
    );
    whyroad(&["mine", "--framework", &framework, "--lake", &lake, "--out", &again]);
    for r in records(Path::new(&again)) {
        let is_class = r.scenario_id.to_string() == class;
        assert_eq!(r.calibrated, Some(is_class), "{}", r.episode_id);
        if is_class {
            // By hand: all (2 + 1) / (8 + 2); the class (2 + 4 * 0.3) / 12.
            assert!((r.score - 0.2667).abs() < 1e-4, "{}", r.score);
        }
    }
    let result =
        std::fs::read_to_string(Path::new(&again).join(format!("mining_results/{class}.json"))).unwrap();
    let result: Value = serde_json::from_str(&result).unwrap();
    let returned = result["mining_result"]["returned"].as_u64().unwrap();
    let counts = &result["mining_result"]["statistics"];
    assert_eq!(counts["score_distribution"], json!({"0.2-0.3": returned}));
    assert_eq!(counts.get("uncalibrated"), None);

    // The table in force counts as at most ten episodes.
    let o = whyroad(&args);
    assert!(String::from_utf8(o.stdout).unwrap().contains(class));
}
