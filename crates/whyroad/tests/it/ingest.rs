//! `whyroad ingest` as a person runs it: exit codes, what goes to stdout and what to stderr, the second run.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn whyroad(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .env_remove("WHYROAD_LANG")
        .current_dir(root())
        .output()
        .unwrap()
}

fn out(o: &Output) -> String {
    String::from_utf8(o.stdout.clone()).unwrap()
}

fn err(o: &Output) -> String {
    String::from_utf8(o.stderr.clone()).unwrap()
}

#[test]
fn a_drive_goes_in_once() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().to_str().unwrap();
    let fixture = "crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml";
    // By the fixture: 5 rows of the ego, 3 + 5 + 5 of others, 5 of somebody who rides in the ego.
    let first = whyroad(&["ingest", "sumo", fixture, "--lake", lake]);
    assert_eq!(first.status.code(), Some(0), "{}", err(&first));
    insta::assert_snapshot!("ingest_sumo", out(&first));
    assert_eq!(err(&first), "", "nothing to say about clean input");

    // No format named: recognized; same content: not written again.
    let second = whyroad(&["ingest", fixture, "--lake", lake, "--lang", "zh"]);
    assert_eq!(second.status.code(), Some(0));
    insta::assert_snapshot!("ingest_sumo_again_zh", out(&second));

    // Another start time is other content under the same id.
    let third = whyroad(&["ingest", "sumo", fixture, "--lake", lake, "--start-time", "2026-02-01T00:00:00Z"]);
    assert!(out(&third).contains("crossroads-ego: replaced"), "{}", out(&third));

    // The default start is no date; the same time given is one.
    let missing = |start: &[&str]| {
        let args = [&["ingest", "sumo", fixture, "--lake", lake, "--format", "json"], start].concat();
        let json: serde_json::Value = serde_json::from_str(&out(&whyroad(&args))).unwrap();
        let report = &json[0];
        let undated = report["missing"].as_array().unwrap().iter().any(|m| m == "date");
        (report["outcome"].as_str().unwrap().to_owned(), undated)
    };
    let given = ["--start-time", "2026-01-01T00:00:00Z"];
    assert_eq!(missing(&[]), ("replaced".to_owned(), true));
    assert_eq!(missing(&given), ("replaced".to_owned(), false));
    assert_eq!(missing(&given), ("unchanged".to_owned(), false));
}

#[test]
fn the_bundled_drives_go_in_without_a_word() {
    let dir = tempfile::tempdir().unwrap();
    let o = whyroad(&["ingest", "sumo", "examples/drives", "--lake", dir.path().to_str().unwrap()]);
    assert_eq!((o.status.code(), err(&o).as_str()), (Some(0), ""));
    assert!(out(&o).ends_with("3 of 3 sources are in the lake, 0 rows dropped\n"), "{}", out(&o));
}

#[test]
fn what_cannot_be_read_is_1_and_what_is_half_read_is_3() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().join("lake");
    let lake = lake.to_str().unwrap();
    let logs = dir.path().join("logs");
    let good = fs::read(root().join("crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml")).unwrap();
    fs::create_dir_all(&logs).unwrap();
    fs::write(logs.join("bad.fcd.xml"), "<fcd-export>").unwrap();
    let logs = logs.to_str().unwrap();

    let none = whyroad(&["ingest", "sumo", logs, "--lake", lake]);
    assert_eq!(none.status.code(), Some(1));
    assert!(
        err(&none).contains("error[sumo.fcd.broken]") && err(&none).contains("bad.fcd.xml"),
        "{}",
        err(&none)
    );

    fs::write(Path::new(logs).join("good.fcd.xml"), good).unwrap();
    let some = whyroad(&["ingest", "sumo", logs, "--lake", lake, "--format", "json"]);
    assert_eq!(some.status.code(), Some(3), "{}", err(&some));
    let report: serde_json::Value = serde_json::from_str(&out(&some)).unwrap();
    assert_eq!(report[0]["outcome"], serde_json::Value::Null);
    assert_eq!(report[1]["outcome"], "written");
    assert_eq!(report[1]["tables"][0]["read"], 23);

    let nothing = whyroad(&["ingest", "av2", "docs", "--lake", lake]);
    assert_eq!(nothing.status.code(), Some(1));
    assert!(err(&nothing).contains("ingest.nothing_found"));
    assert_eq!(whyroad(&["ingest", "sumo"]).status.code(), Some(2), "usage");
}

#[test]
fn every_recorded_av2_log_goes_in() {
    let data = std::env::var_os("WHYROAD_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let logs = data.join("av2/sensor_logs");
    if !logs.is_dir() {
        crate::require::skipped("recorded", "no recorded data");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().to_str().unwrap();
    let o = whyroad(&["ingest", "av2", logs.to_str().unwrap(), "--lake", lake, "--format", "json"]);
    assert_eq!(o.status.code(), Some(0), "{}", err(&o));
    let report: serde_json::Value = serde_json::from_str(&out(&o)).unwrap();
    // Rows of the raw files, by pandas; `a_log_...` tests in whyroad-ingest look closer.
    let rows: Vec<_> =
        report.as_array().unwrap().iter().map(|r| r["tables"][0]["read"].as_u64().unwrap()).collect();
    assert_eq!(rows, [12342, 11364, 12078, 6542]);
}

#[test]
fn a_mistyped_format_is_a_usage_error_and_writes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().join("lake");
    let at = lake.to_str().unwrap();
    let typo = whyroad(&["ingest", "av3", "examples/drives", "--lake", at]);
    assert_eq!(typo.status.code(), Some(2));
    assert!(err(&typo).contains("'av3'") && err(&typo).contains("'av2'"), "{}", err(&typo));
    let unknown = whyroad(&["ingest", "zzz", "examples/drives", "--lake", at]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(err(&unknown).contains("the formats are av2,"), "{}", err(&unknown));
    assert_eq!(whyroad(&["ingest", "sumo", "examples/drives"]).status.code(), Some(2), "no lake");
    let foreign = whyroad(&["ingest", "av2", "examples/drives", "--ego", "a", "--lake", at]);
    assert_eq!(foreign.status.code(), Some(2), "an option of another format");
    assert!(!lake.exists());
}

#[test]
fn help_of_a_format_lists_its_own_options_only() {
    let av2 = out(&whyroad(&["ingest", "av2", "--help"]));
    let sumo = out(&whyroad(&["ingest", "sumo", "--help"]));
    for option in ["--ego", "--sensor-range", "--occlusion", "--net", "--dbc", "--mapping"] {
        assert!(!av2.contains(option), "{option}: {av2}");
    }
    assert!(
        sumo.contains("--ego-share") && sumo.contains("--sensor-range") && !sumo.contains("--dbc"),
        "{sumo}"
    );
    assert!(av2.contains("Example:") && sumo.contains("Example:"));
}

#[test]
fn notes_appear_only_when_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path().to_str().unwrap();
    let set = "crates/whyroad-ingest/tests/fixtures/nuscenes/v1.0-byhand";
    let quiet = whyroad(&["ingest", "nuscenes", set, "--lake", at]);
    assert!(!err(&quiet).contains("note["), "{}", err(&quiet));
    let verbose = whyroad(&["ingest", "nuscenes", set, "--lake", at, "--verbose"]);
    assert!(err(&verbose).contains("note[ingest.rate.resampled]"), "{}", err(&verbose));
}
