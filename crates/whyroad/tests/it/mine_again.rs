//! `whyroad mine` again and again on one lake: killed in the middle and started again, with other numbers of jobs, with
//! a limit. What it writes is the same bytes each time; what was done is not done again.
#![cfg(unix)] // a process is killed without warning
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::folders::{copy, files};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn whyroad(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whyroad"));
    command.args(args).env_remove("WHYROAD_LANG").stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn mine(lake: &Path, out: &Path, more: &[&str]) -> Command {
    let mut args = vec!["mine", "--lake", lake.to_str().unwrap(), "--out", out.to_str().unwrap()];
    args.extend(more);
    whyroad(&args)
}

fn done(mut command: Command) {
    let status = command.status().unwrap();
    assert!(status.success(), "{command:?}: {status}");
}

/// The same simulated drive n times, under different names and days.
fn lake(dir: &Path, drives: usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives/multilane");
    for i in 0..drives {
        let (id, day) = (format!("drive{i}"), format!("2026-02-{:02}T00:00:00Z", i + 1));
        let lake = dir.to_str().unwrap();
        done(whyroad(&[
            "ingest",
            "sumo",
            path.to_str().unwrap(),
            "--lake",
            lake,
            "--drive-id",
            &id,
            "--start-time",
            &day,
        ]));
    }
}

/// Ids of the drives of which it is known what the rules found.
fn mined(lake: &Path) -> Vec<String> {
    let drives = fs::read_dir(lake.join("drives")).unwrap().map(|e| e.unwrap().path());
    let mut ids: Vec<String> = drives
        .filter(|d| d.join("found.json").exists())
        .map(|d| d.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    ids.sort();
    ids
}

#[test]
fn killed_in_the_middle_it_goes_on_and_says_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    lake(&at("lake"), 4);
    copy(&at("lake"), &at("untouched"));

    let mut child = mine(&at("lake"), &at("out"), &["--jobs", "1"]).spawn().unwrap();
    let patience = Instant::now() + Duration::from_secs(100);
    while mined(&at("lake")).is_empty() && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap(); // SIGKILL
    child.wait().unwrap();
    let before = mined(&at("lake"));
    assert!(!before.is_empty() && before.len() < 4, "killed in the middle: {before:?} were done");
    assert!(!at("out").join("episodes.jsonl").exists(), "half a result must not be published");

    // Without its signals a drive that was done could not be mined quickly: nobody looks for them.
    let signals = at("lake").join("drives").join(&before[0]).join("signals");
    fs::remove_dir_all(&signals).unwrap();
    done(mine(&at("lake"), &at("out"), &[]));
    assert_eq!(mined(&at("lake")).len(), 4);
    assert!(!signals.exists(), "what was done is not done again");

    done(mine(&at("untouched"), &at("fresh"), &["--jobs", "2"]));
    let (resumed, fresh) = (files(&at("out")), files(&at("fresh")));
    assert!(fresh[Path::new("episodes.jsonl")].len() > 1000);
    assert_eq!(resumed.keys().collect::<Vec<_>>(), fresh.keys().collect::<Vec<_>>());
    for (path, content) in &fresh {
        assert!(resumed[path] == *content, "{} differs", path.display());
    }
    // And once more, over its own results.
    done(mine(&at("lake"), &at("out"), &["--jobs", "3"]));
    assert_eq!(files(&at("out")), fresh);
}

/// New drives beside mined ones: a kill between two of them, and a kill of the whole process group while the folder is
/// written, lose nothing and mix nothing.
#[test]
fn killed_while_only_new_drives_are_mined_it_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    lake(&at("all"), 4);
    // Half of the drives are mined, then the others come.
    copy(&at("all"), &at("lake"));
    for id in ["drive1", "drive3"] {
        fs::remove_dir_all(at("lake").join("drives").join(id)).unwrap();
    }
    done(mine(&at("lake"), &at("out"), &[]));
    let before = files(&at("out"));
    for id in ["drive1", "drive3"] {
        copy(&at("all").join("drives").join(id), &at("lake").join("drives").join(id));
    }
    for file in ["found.json", "signals/frames.parquet", "signals/targets.parquet"] {
        fs::remove_file(at("lake").join("drives/drive0").join(file)).unwrap();
    }

    let mut child = mine(&at("lake"), &at("out"), &["--jobs", "1"]).spawn().unwrap();
    let patience = Instant::now() + Duration::from_secs(100);
    while !mined(&at("lake")).contains(&"drive1".to_owned()) && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap(); // SIGKILL
    child.wait().unwrap();
    let known = mined(&at("lake"));
    assert!(known.contains(&"drive1".to_owned()) && !known.contains(&"drive3".to_owned()), "{known:?}");
    let visible = |all: BTreeMap<PathBuf, Vec<u8>>| -> BTreeMap<PathBuf, Vec<u8>> {
        all.into_iter()
            .filter(|(path, _)| !path.to_string_lossy().ends_with(".part") && path != Path::new(".lock"))
            .collect()
    };
    assert_eq!(visible(files(&at("out"))), before, "the earlier results are there until the run is finished");

    done(mine(&at("lake"), &at("out"), &[]));
    assert!(!mined(&at("lake")).contains(&"drive0".to_owned()), "an unchanged drive is not opened");
    done(mine(&at("all"), &at("fresh"), &[]));
    assert_eq!(files(&at("out")), files(&at("fresh")));

    // `--force` trusts nothing.
    done(mine(&at("lake"), &at("out"), &["--force"]));
    assert!(mined(&at("lake")).contains(&"drive0".to_owned()));
    assert_eq!(files(&at("out")), files(&at("fresh")));
}

#[test]
fn a_limit_leaves_out_the_worst_and_counts_them() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    lake(&at("lake"), 2);
    let ask = |out: &str, more: &[&str]| {
        let rule = ["--rule", "target.gap < 40 m for 1 s"];
        done(mine(&at("lake"), &at(out), &[&rule, more].concat()));
        let text = fs::read_to_string(at(out).join("mining_result.json")).unwrap();
        serde_json::from_str::<Value>(&text).unwrap()["mining_result"].clone()
    };
    let all = ask("all", &[]);
    let clips = all["clips"].as_array().unwrap();
    assert!(clips.len() > 2 && all["total_matched"] == clips.len(), "{all:#}");
    let two = ask("two", &["--limit", "2"]);
    assert_eq!(two["clips"].as_array().unwrap().as_slice(), &clips[..2], "the best ones, in the same order");
    assert_eq!((&two["total_matched"], &two["returned"]), (&all["total_matched"], &Value::from(2)));
    let scores: Vec<f64> = clips.iter().map(|c| c["match_score"].as_f64().unwrap()).collect();
    assert!(scores.is_sorted_by(|a, b| a >= b), "{scores:?}");
}
