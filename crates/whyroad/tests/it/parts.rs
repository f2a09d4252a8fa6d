//! A lake mined by several workers and merged: the same bytes as one run, whatever befalls the workers. What a merge
//! refuses: a missing part, a drive twice, other versions, a drive that changed.
#![cfg(unix)] // a process is killed without warning
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::folders::{copy, files};
use crate::session::{Run, root, whyroad_in};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A lake of five drives, the simulated ones and copies of two, with one run over all of it beside.
static LAKE: LazyLock<TempDir> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    for (i, name) in ["back_street", "multilane", "signal_junction"].iter().cycle().take(5).enumerate() {
        let drive = root().join("examples/drives").join(name);
        let (id, day) = (format!("d{i}"), format!("2026-02-{:02}T00:00:00Z", i + 1));
        let drive = drive.to_str().unwrap();
        let ids = ["--drive-id", &id, "--start-time", &day];
        good(whyroad_in(dir.path(), &[&["ingest", "sumo", drive, "--lake", "lake"][..], &ids].concat()));
    }
    good(whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "whole"]));
    dir
});

/// A folder of its own with a copy of the lake.
fn with_lake() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    copy(&LAKE.path().join("lake"), &dir.path().join("lake"));
    dir
}

#[track_caller]
fn good(run: Run) -> Run {
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    run
}

/// The files of two folders are the same, byte for byte.
#[track_caller]
fn same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert!(b[Path::new("episodes.jsonl")].len() > 1000);
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (path, content) in &b {
        assert!(a[path] == *content, "{} differs", path.display());
    }
}

/// The parts of a plan for `n` workers, with these further arguments of `mine`.
fn parts(dir: &Path, n: usize, more: &[&str]) {
    let lists = n.to_string();
    good(whyroad_in(dir, &["mine", "--lake", "lake", "--plan", &lists, "--out", "plan"]));
    for i in 1..=n {
        let (list, part) = (format!("plan/list-{i}.json"), format!("parts/{i}"));
        let args = ["mine", "--lake", "lake", "--drives", &list, "--out", &part];
        good(whyroad_in(dir, &[&args[..], more].concat()));
    }
}

fn drives_of(list: &Path) -> Vec<String> {
    let list: Value = serde_json::from_slice(&fs::read(list).unwrap()).unwrap();
    list["drives"].as_array().unwrap().iter().map(|d| d["drive_id"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn merged_parts_are_one_run_byte_for_byte_whatever_their_number() {
    for n in [1, 3, 7] {
        let dir = with_lake();
        parts(dir.path(), n, &[]);
        let listed: Vec<_> =
            (1..=n).flat_map(|i| drives_of(&dir.path().join(format!("plan/list-{i}.json")))).collect();
        assert_eq!(listed.len(), 5);
        assert_eq!(listed.iter().collect::<BTreeSet<_>>().len(), 5, "disjoint");
        good(whyroad_in(dir.path(), &["merge", "parts", "--out", "merged"]));
        same(&dir.path().join("merged"), &LAKE.path().join("whole"));
        // Again, over its own result, and checked against the lake.
        good(whyroad_in(dir.path(), &["merge", "parts", "--out", "merged", "--lake", "lake"]));
        same(&dir.path().join("merged"), &LAKE.path().join("whole"));
        assert!(
            fs::read_dir(dir.path()).unwrap().all(|e| !e
                .unwrap()
                .file_name()
                .to_str()
                .unwrap()
                .starts_with('.'))
        );
    }
}

#[test]
fn a_custom_rule_with_a_limit_and_lists_of_other_programs_merge_too() {
    let dir = with_lake();
    let rule = ["--rule", "target.gap < 40 m for 1 s", "--limit", "2", "--lang", "zh"];
    for (part, ids) in [("a", "d0\nd3\n"), ("b", "d4\n\nd1\nd2\n")] {
        fs::write(dir.path().join("list"), ids).unwrap();
        let args = ["mine", "--lake", "lake", "--drives", "list", "--out", part];
        good(whyroad_in(dir.path(), &[&args[..], &rule].concat()));
    }
    let unknown = whyroad_in(dir.path(), &["merge", "a", "b", "--out", "merged"]);
    assert_eq!(unknown.code, 1);
    assert!(unknown.err.contains("merge.expected.unknown"), "{}", unknown.err);
    assert!(!dir.path().join("merged").exists());
    good(whyroad_in(dir.path(), &["merge", "a", "b", "--out", "merged", "--lake", "lake"]));
    good(whyroad_in(dir.path(), &[&["mine", "--lake", "lake", "--out", "whole"][..], &rule].concat()));
    same(&dir.path().join("merged"), &dir.path().join("whole"));
}

#[test]
fn what_is_missing_doubled_changed_or_of_another_version_is_named_and_nothing_is_written() {
    let dir = with_lake();
    parts(dir.path(), 3, &[]);
    let at = |p: &str| dir.path().join(p);
    let refused = |args: &[&str], words: &[&str]| {
        let run = whyroad_in(dir.path(), &[&["merge"][..], args, &["--out", "merged"]].concat());
        assert_eq!(run.code, 1, "{}", run.err);
        for word in words {
            assert!(run.err.contains(word), "no {word}: {}", run.err);
        }
        assert!(!at("merged").exists(), "nothing is published");
    };
    refused(&["parts/1", "parts/3"], &["merge.drive.missing", "list 2"]);
    let second = drives_of(&at("plan/list-2.json"));
    refused(&["parts/1", "parts/3", "--lake", "lake"], &["merge.drive.missing", &second[0]]);
    copy(&at("parts/2"), &at("again"));
    refused(&["parts", "again"], &["merge.drive.doubled", &second[0], "again"]);

    // One part twice: one line, whatever the number of drives.
    let twice = whyroad_in(dir.path(), &["merge", "parts", "again", "--out", "merged"]);
    assert_eq!(twice.err.matches("merge.drive.doubled").count(), 1, "{}", twice.err);
    assert!(twice.err.contains("work list 2"), "{}", twice.err);

    // The program with another value in a rule.
    for folder in ["schema", "scenarios"] {
        copy(&root().join(folder), &at("fw").join(folder));
    }
    let file = at("fw/scenarios/reactive_agent/cutin.yaml");
    let rules = fs::read_to_string(&file).unwrap();
    let changed = rules.replace("reach_thw: { value: 2 s", "reach_thw: { value: 1 s");
    assert_ne!(rules, changed);
    fs::write(&file, changed).unwrap();
    let other = whyroad_in(dir.path(), &["--framework", "fw", "merge", "parts", "--out", "merged"]);
    assert!(other.code == 1 && other.err.contains("merge.part.differs"), "{}", other.err);
    assert!(!at("merged").exists());

    // The same part, made by another version of the derivation.
    let work = fs::read_to_string(at("again/work.json")).unwrap();
    let mut other: Value = serde_json::from_str(&work).unwrap();
    other["versions"]["signals"] = "0".into();
    fs::write(at("again/work.json"), other.to_string()).unwrap();
    refused(&["parts/1", "again", "parts/3"], &["merge.part.differs", "another version"]);
    other = serde_json::from_str(&work).unwrap();
    other["list"]["drives"].as_array_mut().unwrap().pop();
    fs::write(at("again/work.json"), other.to_string()).unwrap();
    refused(&["parts/1", "again", "parts/3"], &["merge.drive.missing", "a list was changed"]);
    fs::write(at("again/work.json"), &work).unwrap();

    // A byte of the results flipped; a worker that has not finished.
    let mut lines = fs::read(at("again/drives.jsonl")).unwrap();
    let middle = lines.len() / 2;
    lines[middle] ^= 1;
    fs::write(at("again/drives.jsonl"), lines).unwrap();
    refused(&["parts/1", "again", "parts/3"], &["merge.part.unreadable"]);
    fs::remove_file(at("again/part.json")).unwrap();
    refused(&["parts/1", "again", "parts/3"], &["merge.part.incomplete", "again"]);

    // A drive has other content than when it was mined.
    let manifest = at("lake/drives/d1/drive.json");
    let mut of_drive: Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    of_drive["meta"]["content_hash"] = "other".into();
    fs::write(&manifest, of_drive.to_string()).unwrap();
    refused(&["parts", "--lake", "lake"], &["merge.drive.changed", "d1"]);
}

#[test]
fn a_drive_that_cannot_be_read_is_set_aside_and_named() {
    let dir = with_lake();
    fs::write(dir.path().join("lake/drives/d1/frames.parquet"), "no Parquet").unwrap();
    let whole = whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "whole"]);
    assert_eq!(whole.code, 3);
    fs::write(dir.path().join("list"), "d0\nd1\nd2\nd3\nd4\n").unwrap();
    let part = whyroad_in(dir.path(), &["mine", "--lake", "lake", "--drives", "list", "--out", "part"]);
    assert_eq!(part.code, 3, "{}", part.err);
    let merged = whyroad_in(dir.path(), &["merge", "part", "--lake", "lake", "--out", "merged"]);
    assert_eq!(merged.code, 3);
    for run in [&part, &merged] {
        assert!(run.err.contains("mine.drive.unreadable") && run.err.contains("d1"), "{}", run.err);
    }
    same(&dir.path().join("merged"), &dir.path().join("whole"));
    // Nothing is known about it: the folder says so, and so does the report.
    let coverage = fs::read(dir.path().join("merged/coverage.json")).unwrap();
    let coverage: Value = serde_json::from_slice(&coverage).unwrap();
    let expected = serde_json::json!([{"drive_id": "d1", "code": "mine.drive.unreadable"}]);
    assert_eq!(coverage["left_out"], expected);
    copy(&dir.path().join("lake/drives/d2"), &dir.path().join("lake/drives/new"));
    let args = ["report", "--lake", "lake", "--mined", "merged", "--format", "json"];
    let report = whyroad_in(dir.path(), &args);
    let printed: Value = serde_json::from_str(&report.out).unwrap();
    assert_eq!((&printed["left_out"], &printed["not_mined"]), (&expected, &1.into()));
    assert_eq!(report.code, 3);
    assert!(report.err.contains("left_out in coverage.json"), "{}", report.err);
    // A drive that is not in the lake at all is another fault.
    fs::write(dir.path().join("list"), "d0\nnowhere\n").unwrap();
    let part = whyroad_in(dir.path(), &["mine", "--lake", "lake", "--drives", "list", "--out", "other"]);
    assert!(part.code == 3 && part.err.contains("mine.drive.unknown"), "{}", part.err);
}

/// Makes reading a drive hang, as a drive does that exhausts a machine: its table is a pipe that nobody writes.
fn block(lake: &Path, id: &str) -> (PathBuf, Vec<u8>) {
    let path = lake.join("drives").join(id).join("frames.parquet");
    let content = fs::read(&path).unwrap();
    fs::remove_file(&path).unwrap();
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    (path, content)
}

fn lines(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Starts a worker and kills it when its lines say so.
fn killed(dir: &Path, until: impl Fn(&str) -> bool) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(["mine", "--lake", "lake", "--drives", "list", "--out", "part", "--jobs", "2"])
        .current_dir(dir)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let patience = Instant::now() + Duration::from_secs(100);
    while !until(&lines(&dir.join("part/drives.jsonl"))) {
        assert!(Instant::now() < patience, "{}", lines(&dir.join("part/drives.jsonl")));
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap(); // SIGKILL
    child.wait().unwrap();
}

#[test]
fn a_killed_worker_is_continued_and_the_drive_that_kills_is_set_aside() {
    let dir = with_lake();
    let (path, content) = block(&dir.path().join("lake"), "d1");
    fs::write(dir.path().join("list"), "d0\nd1\nd2\nd3\nd4\n").unwrap();
    let begun = |text: &str| text.matches(r#"{"begun":"d1"}"#).count();
    let done = |text: &str| text.matches(r#"{"done":"#).count();
    killed(dir.path(), |text| begun(text) == 1 && done(text) >= 1);
    let first = done(&lines(&dir.path().join("part/drives.jsonl")));
    // Drives that were never in work at a death are finished before the suspects are tried again, one by one.
    killed(dir.path(), |text| begun(text) == 2);
    assert!(done(&lines(&dir.path().join("part/drives.jsonl"))) >= 3, "after {first}");
    assert!(!dir.path().join("part/part.json").exists());

    // A second worker cannot write the same part.
    let args = ["mine", "--lake", "lake", "--drives", "list", "--out", "part"];
    let mut busy = Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .current_dir(dir.path())
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while begun(&lines(&dir.path().join("part/drives.jsonl"))) < 3 {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(
        done(&lines(&dir.path().join("part/drives.jsonl"))),
        4,
        "the one with the most deaths comes last"
    );
    let second = whyroad_in(dir.path(), &args);
    assert!(second.code == 1 && second.err.contains("another worker"), "{}", second.err);
    busy.kill().unwrap();
    busy.wait().unwrap();

    // It was in work at three deaths.
    let aside = whyroad_in(dir.path(), &args);
    assert_eq!(aside.code, 3, "{}", aside.err);
    assert!(aside.err.contains("mine.drive.kills_worker") && aside.err.contains("d1"), "{}", aside.err);
    let merged = whyroad_in(dir.path(), &["merge", "part", "--lake", "lake", "--out", "merged"]);
    assert_eq!(merged.code, 3, "{}", merged.err);
    assert!(merged.err.contains("mine.drive.kills_worker") && merged.out.contains('4'), "{}", merged.err);

    // The cause is gone: mined again from the start, the drive is there.
    fs::remove_file(&path).unwrap();
    fs::write(&path, content).unwrap();
    good(whyroad_in(dir.path(), &[&args[..], &["--force"]].concat()));
    good(whyroad_in(dir.path(), &["merge", "part", "--lake", "lake", "--out", "merged"]));
    same(&dir.path().join("merged"), &LAKE.path().join("whole"));
}
