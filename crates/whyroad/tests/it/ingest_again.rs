//! `whyroad ingest` killed in the middle of a source with many drives, and started again: what was written is not made
//! again, and the lake is the same as after one run. Simulation: `examples/truth/grid`, every vehicle an ego.
#![cfg(unix)] // a process is killed without warning
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn ingest(lake: &Path) -> Command {
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth/grid/fcd.xml.gz");
    let mut command = Command::new(env!("CARGO_BIN_EXE_whyroad"));
    command.args(["ingest", "sumo", log.to_str().unwrap(), "--lake", lake.to_str().unwrap()]);
    command.args(["--ego-share", "0.08", "--seed", "3", "--format", "json"]);
    command.env_remove("WHYROAD_LANG").stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Outcome of each drive, by its id.
fn outcomes(lake: &Path) -> BTreeMap<String, Value> {
    let out = ingest(lake).stdout(Stdio::piped()).output().unwrap();
    assert!(out.status.success(), "{}", out.status);
    let report: Value = serde_json::from_slice(&out.stdout).unwrap();
    let one = |r: &Value| (r["drive_id"].as_str().unwrap().to_owned(), r.clone());
    report.as_array().unwrap().iter().map(one).collect()
}

/// Folders of the drives that a pattern such as `drives/*/tracks.parquet` finds.
fn drives(lake: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(lake.join("drives")) else { return Vec::new() };
    let mut seen: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    seen.sort();
    seen
}

/// Content of the files of a drive, and which files of the disk they are.
fn files(drive: &Path) -> BTreeMap<String, (Vec<u8>, u64)> {
    let entries = fs::read_dir(drive).unwrap().map(|e| e.unwrap());
    let one = |e: fs::DirEntry| {
        let content = fs::read(e.path()).unwrap();
        (e.file_name().to_str().unwrap().to_owned(), (content, e.metadata().unwrap().ino()))
    };
    entries.map(one).collect()
}

fn contents(drive: &Path) -> BTreeMap<String, Vec<u8>> {
    files(drive).into_iter().map(|(name, (content, _))| (name, content)).collect()
}

#[test]
fn killed_in_the_middle_of_a_source_it_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let (lake, other) = (dir.path().join("lake"), dir.path().join("other"));
    let mut child = ingest(&lake).spawn().unwrap();
    let patience = Instant::now() + Duration::from_secs(60);
    while drives(&lake).is_empty() && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap(); // SIGKILL
    child.wait().unwrap();
    let done = drives(&lake);
    let before: Vec<_> = done.iter().map(|d| files(d)).collect();

    let fresh = outcomes(&other);
    assert!(fresh.len() >= 4 && fresh.values().all(|r| r["outcome"] == "written"), "{fresh:#?}");
    assert!(!done.is_empty() && done.len() < fresh.len(), "killed in the middle: {done:?}");

    let resumed = outcomes(&lake);
    assert_eq!(resumed.keys().collect::<Vec<_>>(), fresh.keys().collect::<Vec<_>>());
    let id = |d: &Path| d.file_name().unwrap().to_str().unwrap().to_owned();
    let names: Vec<String> = done.iter().map(|d| id(d)).collect();
    for (drive, report) in &resumed {
        let expected = if names.contains(drive) { "unchanged" } else { "written" };
        assert_eq!(report["outcome"], expected, "{drive}");
        for key in ["frames", "duration_s", "tracks", "missing"] {
            assert_eq!(report[key], fresh[drive][key], "{drive} {key}");
        }
    }
    let after: Vec<_> = done.iter().map(|d| files(d)).collect();
    assert!(after == before, "what was written is not written again");
    assert_eq!(drives(&lake).len(), fresh.len());
    for drive in drives(&lake) {
        assert!(contents(&drive) == contents(&other.join("drives").join(id(&drive))), "{}", id(&drive));
    }
    // A drive that has lost a part is made again.
    fs::remove_file(done[0].join("tracks.parquet")).unwrap();
    assert_eq!(outcomes(&lake)[&names[0]]["outcome"], "replaced");
    assert!(contents(&done[0]) == contents(&other.join("drives").join(&names[0])));
}

#[test]
fn two_at_once_lose_no_drive_and_write_each_once() {
    let dir = tempfile::tempdir().unwrap();
    let (logs, lake) = (dir.path().join("logs"), dir.path().join("lake"));
    let meta = "source: van\nstart_time: 2026-03-01T08:00:00Z\nego: { length_m: 4.8, width_m: 1.9, height_m: 1.5, reference_to_centre_m: 0 }\n";
    let rows: String = (0..20).map(|i| format!("{},{i},0,0,10\n", f64::from(i) / 10.0)).collect();
    for drive in 0..80 {
        let log = logs.join(format!("d{drive:02}"));
        fs::create_dir_all(&log).unwrap();
        fs::write(log.join("drive.yaml"), meta).unwrap();
        fs::write(log.join("ego.csv"), format!("time_s,x_m,y_m,heading_rad,speed_mps\n{rows}")).unwrap();
    }
    let ingest = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_whyroad"));
        command.args(["ingest", "table", logs.to_str().unwrap(), "--lake", lake.to_str().unwrap()]);
        command.args(["--format", "json"]).env_remove("WHYROAD_LANG");
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let both = [ingest(), ingest()].map(|process| process.wait_with_output().unwrap());
    let mut outcomes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for out in both {
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let report: Value = serde_json::from_slice(&out.stdout).unwrap();
        for drive in report.as_array().unwrap() {
            let of = outcomes.entry(drive["drive_id"].as_str().unwrap().to_owned()).or_default();
            of.push(drive["outcome"].as_str().unwrap().to_owned());
        }
    }
    outcomes.values_mut().for_each(|of| of.sort());
    assert_eq!(outcomes.len(), 80);
    assert!(outcomes.values().all(|of| *of == ["unchanged", "written"]), "{outcomes:?}");
    // Also nothing with a leading dot.
    assert_eq!(fs::read_dir(lake.join("drives")).unwrap().count(), 80);
}
