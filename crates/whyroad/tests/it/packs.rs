//! `whyroad lake compact`, `list` and `upgrade`: the results of every command are the same for packed drives, a
//! compaction killed anywhere loses nothing, and the documented queries of DuckDB and Polars read packs.
#![cfg(unix)] // a process is killed without warning
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::duckdb;
use crate::folders::{copy, files};
use crate::session::{Run, root, whyroad_in};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::Duration;
use tempfile::TempDir;

const DRIVES: usize = 5;

/// A lake of five drives, the simulated ones and copies of two, mined.
static LAKE: LazyLock<TempDir> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    for (i, name) in ["back_street", "multilane", "signal_junction"].iter().cycle().take(DRIVES).enumerate() {
        ingest(dir.path(), name, &format!("d{i}"));
    }
    good(whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "mined"]));
    dir
});

fn ingest(dir: &Path, name: &str, id: &str) {
    let drive = root().join("examples/drives").join(name);
    let day = format!("2026-02-0{}T00:00:00Z", id[1..].parse::<u32>().unwrap() + 1);
    let args = ["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake"];
    good(whyroad_in(dir, &[&args[..], &["--drive-id", id, "--start-time", &day]].concat()));
}

fn with_lake() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    copy(LAKE.path(), dir.path());
    dir
}

#[track_caller]
fn good(run: Run) -> Run {
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    run
}

/// Packs of two drives.
fn compact(dir: &Path, more: &[&str]) -> Value {
    let args = ["lake", "compact", "--lake", "lake", "--drives", "2", "--format", "json"];
    serde_json::from_str(&good(whyroad_in(dir, &[&args[..], more].concat())).out).unwrap()
}

fn listed(dir: &Path) -> Vec<Value> {
    let list = good(whyroad_in(dir, &["lake", "list", "--lake", "lake", "--format", "json"]));
    serde_json::from_str(&list.out).unwrap()
}

/// Drives with a folder of their own.
fn loose(dir: &Path) -> usize {
    let names = fs::read_dir(dir.join("lake/drives")).unwrap();
    names.filter(|e| !e.as_ref().unwrap().file_name().to_string_lossy().starts_with('.')).count()
}

#[test]
fn every_command_gives_the_same_for_packed_drives() {
    let dir = with_lake();
    let run = |args: &[&str]| whyroad_in(dir.path(), args);
    let commands: [&[&str]; 7] = [
        &["inspect", "--lake", "lake"],
        &["inspect", "--lake", "lake", "--format", "json"],
        &["explain", "cutin.urgent", "--lake", "lake", "--clip", "d1_000"],
        &["mine", "--lake", "lake", "--rule", "target.gap < 20 m for 1 s", "--out", "asked"],
        &["mine", "--lake", "lake", "--out", "again", "--format", "json"],
        &["mine", "--lake", "lake", "--plan", "2", "--out", "plan"],
        &["report", "--lake", "lake", "--mined", "mined", "--out", "report.html"],
    ];
    let results = |dir: &Path| {
        let one = |args: &&[&str]| {
            let done = run(args);
            (done.code, done.out)
        };
        let runs: Vec<_> = commands.iter().map(one).collect();
        (
            runs,
            files(&dir.join("again")),
            files(&dir.join("plan")),
            fs::read(dir.join("report.html")).unwrap(),
        )
    };
    let before = results(dir.path());
    assert!(before.0.iter().all(|(code, _)| *code == 0), "{:?}", before.0);
    let done = compact(dir.path(), &[]);
    assert_eq!((&done["packed"], &done["packs"]), (&DRIVES.into(), &3.into()));
    assert_eq!(loose(dir.path()), 0);
    assert!(results(dir.path()) == before, "packed drives give other results");
    // Without signals and findings it is derived again, to the same.
    compact(dir.path(), &["--drop-signals"]);
    assert!(
        !dir.path()
            .join("lake/packs")
            .read_dir()
            .unwrap()
            .flatten()
            .any(|e| e.path().join("signals").exists())
    );
    assert!(results(dir.path()) == before);
    let again = compact(dir.path(), &[]);
    assert_eq!(compact(dir.path(), &[])["packs_written"], 0, "{again}");
    assert!(results(dir.path()) == before);
}

#[test]
fn new_drives_stay_loose_and_old_ones_are_replaced_and_deleted() {
    let dir = with_lake();
    compact(dir.path(), &[]);
    ingest(dir.path(), "multilane", "d7");
    good(whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "mined", "--force"]));
    let packs = |list: &[Value]| list.iter().filter(|d| !d["pack"].is_null()).count();
    let list = listed(dir.path());
    assert_eq!((list.len(), packs(&list)), (DRIVES + 1, DRIVES));
    // Another recording under the same id is refused; the same one, with another content, replaces it.
    let under_d1 = |name: &str| {
        let drive = root().join("examples/drives").join(name);
        whyroad_in(
            dir.path(),
            &["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake", "--drive-id", "d1"],
        )
    };
    let refused = under_d1("back_street");
    assert!(
        refused.code == 1 && refused.err.contains("ingest.drive_id.taken"),
        "{}{}",
        refused.out,
        refused.err
    );
    let replaced = good(under_d1("multilane"));
    assert!(!replaced.err.contains("ingest.drive_id.taken") && listed(dir.path()).len() == DRIVES + 1);
    compact(dir.path(), &[]);
    let ids: Vec<Value> = listed(dir.path()).iter().map(|d| d["drive_id"].clone()).collect();
    good(whyroad_in(dir.path(), &["lake", "delete", "d0", "d7", "--lake", "lake", "--mined", "mined"]));
    let left: Vec<Value> = ids.into_iter().filter(|id| id != "d0" && id != "d7").collect();
    assert_eq!(listed(dir.path()).iter().map(|d| d["drive_id"].clone()).collect::<Vec<_>>(), left);
    for (path, content) in files(&dir.path().join("lake/packs")) {
        let found = content.windows(5).any(|w| w == b"\"d0\"," || w == b"d0_00");
        assert!(!found, "{} still names the deleted drive", path.display());
    }
}

#[test]
fn a_list_is_filtered_by_place_format_and_time() {
    let dir = with_lake();
    compact(dir.path(), &[]);
    ingest(dir.path(), "multilane", "d7");
    let ids = |more: &[&str]| {
        let args = [&["lake", "list", "--lake", "lake"][..], more].concat();
        let out = good(whyroad_in(dir.path(), &args)).out;
        out.lines().map(|l| l.split('\t').next().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(ids(&[]), ["d0", "d1", "d2", "d3", "d4", "d7"]);
    assert_eq!(ids(&["--since", "2026-02-03", "--until", "2026-02-05"]), ["d2", "d3"]);
    assert_eq!(ids(&["--since", "2026-02-05"]), ["d4", "d7"]);
    // A drive without a date has no start to show and is in no range of time.
    let street = root().join("examples/drives/back_street");
    let args = ["ingest", "sumo", street.to_str().unwrap(), "--lake", "lake", "--drive-id", "d8"];
    good(whyroad_in(dir.path(), &args));
    for packed in [false, true] {
        if packed {
            compact(dir.path(), &[]);
        }
        let all = good(whyroad_in(dir.path(), &["lake", "list", "--lake", "lake"])).out;
        let start = |id: &str| {
            let line = all.lines().find(|l| l.starts_with(&format!("{id}\t"))).unwrap();
            line.split('\t').nth(1).unwrap().to_owned()
        };
        assert_eq!((start("d7").as_str(), start("d8").as_str()), ("2026-02-08T00:00:00.000Z", "-"));
        assert_eq!(ids(&["--since", "2026-02-05"]), ["d4", "d7"]);
        let until = ["lake", "list", "--lake", "lake", "--until", "2026-02-02"];
        let until = good(whyroad_in(dir.path(), &until));
        assert!(until.out.starts_with("d0\t") && until.out.lines().count() == 1, "{}", until.out);
        assert!(until.err.contains("1 drive without a date not listed"), "{}", until.err);
    }
    assert_eq!(ids(&["--source-format", "av2"]), Vec::<String>::new());
    let place = listed(dir.path())[0]["place"].clone();
    assert_eq!(ids(&["--place", "Atlantis"]), Vec::<String>::new());
    if let Some(place) = place.as_str() {
        assert!(ids(&["--place", place]).contains(&"d0".to_owned()));
    }
}

#[test]
fn a_compaction_killed_anywhere_leaves_every_drive_once() {
    let dir = with_lake();
    let ids: Vec<String> = (0..DRIVES).map(|i| format!("d{i}")).collect();
    let (mut killed, mut finished) = (0, 0);
    for step in 0..40 {
        // From a lake of folders every time, killed a little later every time.
        if finished > 0 || step % 8 == 0 {
            fs::remove_dir_all(dir.path().join("lake")).unwrap();
            copy(&LAKE.path().join("lake"), &dir.path().join("lake"));
            finished = 0;
        }
        let mut compaction = Command::new(env!("CARGO_BIN_EXE_whyroad"))
            .args(["lake", "compact", "--lake", "lake", "--drives", "2"])
            .current_dir(dir.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(step * 3));
        if compaction.try_wait().unwrap().is_some() {
            finished += 1;
        } else {
            compaction.kill().unwrap();
            compaction.wait().unwrap();
            killed += 1;
        }
        let found: Vec<String> =
            listed(dir.path()).iter().map(|d| d["drive_id"].as_str().unwrap().to_owned()).collect();
        assert_eq!(found, ids, "after a kill at {} ms", step * 3);
    }
    assert!(killed > 3, "only {killed} compactions were killed");
    compact(dir.path(), &[]);
    assert_eq!(loose(dir.path()), 0);
    good(whyroad_in(dir.path(), &["mine", "--lake", "lake", "--out", "again"]));
    assert!(files(&dir.path().join("again")) == files(&dir.path().join("mined")));
}

#[test]
fn an_upgrade_names_what_has_to_be_ingested_again() {
    let dir = with_lake();
    compact(dir.path(), &[]);
    let upgrade = || whyroad_in(dir.path(), &["lake", "upgrade", "--lake", "lake"]);
    assert_eq!(good(upgrade()).out, "5 drives are current (5 of them packed); no action needed\n");
    ingest(dir.path(), "multilane", "d7");
    let manifest = dir.path().join("lake/drives/d7/drive.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replace("\"lake_version\": 2", "\"lake_version\": 1")).unwrap();
    let run = upgrade();
    assert_eq!(run.code, 1);
    assert!(run.err.contains("lake.version") && run.err.contains("whyroad ingest sumo PATH"), "{}", run.err);
    assert!(run.out.contains("1 have to be ingested again"), "{}", run.out);
    // A lake of version 1 as a whole.
    let old = dir.path().join("old/drives");
    fs::create_dir_all(&old).unwrap();
    fs::write(dir.path().join("old/whyroad-lake.json"), r#"{"format": "whyroad-lake", "version": 1}"#)
        .unwrap();
    let run = whyroad_in(dir.path(), &["lake", "upgrade", "--lake", "old"]);
    assert_eq!(run.code, 1);
    assert!(run.err.contains("whyroad ingest FORMAT PATH --lake old"), "{}", run.err);
}

#[test]
fn the_documented_queries_read_packed_drives() {
    if !duckdb::is_installed() {
        crate::require::skipped("python", "no duckdb");
        return;
    }
    let dir = with_lake();
    compact(dir.path(), &[]);
    let page = root().join("docs/how-to/large-lakes.md");
    // No drive is loose after compaction.
    assert_eq!(duckdb::run_queries(&page, dir.path())[1..], [DRIVES, DRIVES]);
    ingest(dir.path(), "multilane", "d7");
    // One that is packed and was replaced since, and one more in a pack that nothing names.
    let drive = root().join("examples/drives/back_street");
    let args = ["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake", "--drive-id", "d3"];
    good(whyroad_in(dir.path(), &[&args[..], &["--start-time", "2026-03-01T00:00:00Z"]].concat()));
    copy(&dir.path().join("lake/packs/00000001"), &dir.path().join("lake/packs/00000000"));
    let rows = duckdb::run_queries(&page, dir.path());
    assert!(rows[0] >= 1);
    assert_eq!(rows[1..], [DRIVES, DRIVES + 1]);
    // Sums that DuckDB and Whyroad agree on: nothing twice, nothing missing.
    let objects = "SELECT sum(object_rows) FROM 'lake/packs/catalogue.parquet'";
    let counted = "SELECT count(*) FROM read_parquet('lake/packs/*/tracks.parquet', filename = true) t \
                   JOIN 'lake/packs/catalogue.parquet' c USING (drive_id) \
                   WHERE c.pack = split_part(t.filename, '/', -2)";
    let python = |code: String| {
        let run =
            Command::new(duckdb::python()).args(["-c", &code]).current_dir(dir.path()).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        String::from_utf8(run.stdout).unwrap()
    };
    let sums = python(format!(
        "import duckdb\nfor sql in (\"\"\"{objects}\"\"\", \"\"\"{counted}\"\"\"):\n    \
         print(duckdb.sql(sql).fetchall()[0][0])"
    ));
    let sums: Vec<u64> = sums.lines().map(|n| n.parse().unwrap()).collect();
    assert!(sums[0] > 1000 && sums[0] == sums[1], "{sums:?}");
    let page = fs::read_to_string(page).unwrap();
    let polars = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    if python("import importlib.util as u; print(u.find_spec('polars') is not None)".into()).trim() == "True"
    {
        assert!(python(polars.to_owned()).trim().parse::<usize>().unwrap() > 0);
    } else {
        crate::require::skipped("python", "no polars");
    }
}
