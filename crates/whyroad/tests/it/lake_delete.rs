//! `whyroad lake delete`: nothing of a drive remains in lake, mined folders, store and caches; what may not be changed
//! is named. A mined folder afterwards is that of a lake that never had the drive.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::folders::{self, files};
use crate::session::{Run, root, whyroad_in};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// The bundled drives: a lake, mined by all rules and with a limit, tasks of all, a backup and a release.
static MADE: LazyLock<TempDir> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| good(whyroad_in(dir.path(), args));
    for name in ["back_street", "multilane", "signal_junction"] {
        let drive = root().join("examples/drives").join(name);
        let day = ["--start-time", "2026-05-01T08:00:00Z"];
        run(&[&["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake"][..], &day].concat());
    }
    run(&["mine", "--lake", "lake", "--out", "mined/all"]);
    let rule = ["--rule", "target.gap < 40 m for 1 s", "--limit", "2"];
    run(&[&["mine", "--lake", "lake", "--out", "mined/rule"][..], &rule].concat());
    run(&["tasks", "create", "--from", "mined/all", "--lake", "lake", "--project", "p", "--data", "service"]);
    run(&["backup", "--data", "service", "--out", "backups/b.jsonl"]);
    run(&["dataset", "init", "dataset.yaml"]);
    let spec = fs::read_to_string(dir.path().join("dataset.yaml")).unwrap();
    assert!(spec.contains("  # assume: Apache-2.0"), "the template has changed");
    let spec = spec.replace("  # assume: Apache-2.0", "  assume: Apache-2.0");
    fs::write(dir.path().join("dataset.yaml"), spec).unwrap();
    let release = [
        "--spec",
        "dataset.yaml",
        "--labels",
        "mined/all",
        "--drafts",
        "--lake",
        "lake",
        "--out",
        "releases/r1",
    ];
    run(&[&["dataset", "build"][..], &release].concat());
    assert!(dir.path().join("releases/r1/manifest.json").is_file());
    fs::create_dir_all(dir.path().join("service/blurred")).unwrap();
    fs::write(dir.path().join("service/blurred/x.png"), "x").unwrap();
    dir
});

#[track_caller]
fn good(run: Run) -> Run {
    assert!(run.code == 0 || run.code == 1, "{}{}", run.out, run.err);
    run
}

fn copy() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    folders::copy(MADE.path(), dir.path());
    dir
}

fn drive(lake: &Path, part: &str) -> String {
    let names =
        fs::read_dir(lake.join("drives")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    names.filter(|n| n.contains(part)).min().unwrap()
}

const PLACES: &[&str] = &[
    "--lake",
    "lake",
    "--mined",
    "mined",
    "--store",
    "service",
    "--releases",
    "releases",
    "--backups",
    "backups",
    "--format",
    "json",
];

fn delete(dir: &Path, more: &[&str]) -> (Run, Value) {
    let run = whyroad_in(dir, &[&["lake", "delete"][..], more, PLACES].concat());
    let printed = serde_json::from_str(&run.out).unwrap_or(Value::Null);
    (run, printed)
}

#[test]
fn nothing_of_the_drive_remains_and_who_else_holds_it_is_named() {
    let dir = copy();
    let at = |p: &str| dir.path().join(p);
    let id = drive(&at("lake"), "multilane");
    let before = files(dir.path());

    let (dry, would) = delete(dir.path(), &[&id, "--dry-run"]);
    assert_eq!(dry.code, 1, "a release and a backup hold it: {}", dry.err);
    assert!(
        files(dir.path()).iter().all(|(p, c)| p.starts_with("service") || before[p] == *c),
        "nothing changed"
    );
    assert_eq!(would["drive_ids"], serde_json::json!([id]));
    assert!(would["tasks"].as_u64().unwrap() > 0 && would["episodes"].as_u64().unwrap() > 0);

    // Places that were not given are not searched: their counts are unknown, not zero (delete-drives.md).
    let alone = whyroad_in(dir.path(), &["lake", "delete", &id, "--lake", "lake", "--dry-run"]);
    assert!(
        alone.out.contains("store of the labeling service: not searched (--store was not given)"),
        "{}",
        alone.out
    );
    assert!(alone.out.contains(&format!("drives that would be deleted:\n  {id}\n")), "{}", alone.out);
    assert!(!alone.out.contains("0 tasks") && !alone.out.contains("0 images"), "{}", alone.out);

    // A mistyped id beside it is named, and does not stop the deletion of the other.
    let (typo, found) = delete(dir.path(), &[&id, "multilane-egoo", "--dry-run"]);
    assert_eq!((typo.code, &found["not_found"]), (1, &serde_json::json!(["multilane-egoo"])));
    assert_eq!((&found["drives"], &found["lake_drives"]), (&serde_json::json!(1), &serde_json::json!(1)));

    let (run, done) = delete(dir.path(), &[&id, "--request", "DSR-17"]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert_eq!(done, would);
    assert_eq!(done["releases"], serde_json::json!(["releases/r1"]));
    assert_eq!(done["backups"], serde_json::json!(["backups/b.jsonl"]));
    for (path, content) in files(dir.path()) {
        let kept = path.starts_with("releases") || path.starts_with("backups");
        // Parquet is compressed: the mined tables are compared with a fresh run below.
        let held = content.windows(id.len()).any(|w| w == id.as_bytes());
        assert!(kept || !held, "{} holds {id}", path.display());
        if kept {
            assert!(content == before[&path], "{} was changed", path.display());
        }
    }
    assert!(!at("service/blurred/x.png").exists());
    let audit = fs::read_to_string(at("lake/deletions.jsonl")).unwrap();
    let entries: Vec<Value> = audit.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(entries.iter().map(|e| e["state"].as_str().unwrap()).collect::<Vec<_>>(), ["begun", "done"]);
    assert_eq!((&entries[1]["request"], &entries[1]["drives"]), (&"DSR-17".into(), &1.into()));

    // As if the drive had never been there.
    good(whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "fresh/all"]));
    let rule = ["--rule", "target.gap < 40 m for 1 s", "--limit", "2"];
    good(whyroad_in(dir.path(), &[&["mine", "--lake", "lake", "--out", "fresh/rule"][..], &rule].concat()));
    let (mined, fresh) = (files(&at("mined")), files(&at("fresh")));
    assert_eq!(mined.keys().collect::<Vec<_>>(), fresh.keys().collect::<Vec<_>>());
    assert!(fresh[Path::new("all/episodes.jsonl")].len() > 1000);
    for (path, content) in &fresh {
        assert!(mined[path] == *content, "{} differs", path.display());
    }

    // Again: there is nothing left, which is said.
    let again = whyroad_in(dir.path(), &["lake", "delete", &id, "--lake", "lake", "--mined", "mined"]);
    assert!(again.code == 1 && again.err.contains(&id), "{}", again.err);
}

#[test]
fn a_deletion_that_was_killed_is_finished_by_the_same_command() {
    let whole = copy();
    let id = drive(&whole.path().join("lake"), "back_street");
    delete(whole.path(), &[&id]);
    let lines = |dir: &Path| -> BTreeMap<PathBuf, Vec<u8>> {
        let mut all = files(dir);
        all.retain(|p, _| p.starts_with("lake/drives") || p.starts_with("mined"));
        all
    };
    // Killed after the store, while a mined folder was written aside; and after the lake's folder was renamed.
    let dir = copy();
    let at = |p: &str| dir.path().join(p);
    let one = whyroad_in(dir.path(), &["lake", "delete", &id, "--lake", "empty", "--store", "service"]);
    assert_eq!(one.code, 1, "no such lake: {}", one.err);
    fs::create_dir_all(at("mined/.all.new/mining_results")).unwrap();
    fs::write(at("mined/.all.new/.episodes.jsonl.part"), "half").unwrap();
    fs::rename(at(&format!("lake/drives/{id}")), at(&format!("lake/drives/.gone-7-{id}"))).unwrap();
    fs::write(at("lake/deletions.jsonl"), "{\"state\":\"begun\"}\n").unwrap();
    let (run, _) = delete(dir.path(), &[&id]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert_eq!(lines(dir.path()), lines(whole.path()));
    // Killed before the last entry of the audit file.
    let audit = at("lake/deletions.jsonl");
    fs::write(&audit, "{\"state\":\"begun\"}\n").unwrap();
    let (run, _) = delete(dir.path(), &[&id]);
    assert!(run.err.is_empty(), "{}", run.err);
    assert!(fs::read_to_string(&audit).unwrap().lines().last().unwrap().contains("\"done\""));
}

#[test]
fn old_drives_are_chosen_by_their_end() {
    let dir = copy();
    let lake = dir.path().join("lake/drives");
    let ends: Vec<String> = {
        let clips = fs::read_to_string(dir.path().join("mined/all/clip_metadata.jsonl")).unwrap();
        let times = clips.lines().map(|l| serde_json::from_str::<Value>(l).unwrap());
        times.map(|v| v["clip_metadata"]["capture_time"].as_str().unwrap()[..10].to_owned()).collect()
    };
    let first = ends.iter().min().unwrap();
    let (none, printed) = delete(dir.path(), &["--older-than", first]);
    assert_eq!((none.code, &printed["drives"]), (0, &0.into()), "{}", none.err);
    assert_eq!(fs::read_dir(&lake).unwrap().count(), 3);
    let (_, printed) = delete(dir.path(), &["--older-than", "0d", "--dry-run"]);
    assert_eq!(printed["lake_drives"], 3);
    // SUMO states no date: how old such a drive is, nobody knows. It is kept and named, loose and packed.
    let street = root().join("examples/drives/back_street");
    let args = ["ingest", "sumo", street.to_str().unwrap(), "--lake", "lake", "--drive-id", "undated"];
    good(whyroad_in(dir.path(), &args));
    for packed in [false, true] {
        if packed {
            good(whyroad_in(dir.path(), &["lake", "compact", "--lake", "lake"]));
        }
        let (run, printed) = delete(dir.path(), &["--older-than", "0d", "--dry-run"]);
        assert_eq!((run.code, &printed["lake_drives"]), (1, &3.into()), "{}", run.err);
        let unsearched = printed["unsearched"].as_array().unwrap();
        assert!(unsearched.contains(&"undated: date unknown".into()), "{printed:#}");
    }
    let wrong = whyroad_in(dir.path(), &["lake", "delete", "--lake", "lake", "--older-than", "yesterday"]);
    assert_eq!(wrong.code, 2, "{}", wrong.err);
}

#[test]
fn a_folder_with_other_files_is_left_as_it_is() {
    let dir = copy();
    let id = drive(&dir.path().join("lake"), "multilane");
    fs::write(dir.path().join("mined/all/notes.txt"), "mine").unwrap();
    let before = files(&dir.path().join("mined/all"));
    let (run, _) = delete(dir.path(), &[&id]);
    assert!(run.code == 1 && run.err.contains("notes.txt"), "{}", run.err);
    assert_eq!(files(&dir.path().join("mined/all")), before);
    assert!(dir.path().join("lake/drives").join(&id).exists(), "the lake comes last");
}
