//! The search for sources: every path and every file of a folder is either taken or named with the reason.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{AdapterRef, Options, find_sources, ingest, sumo};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::Severity;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

#[test]
fn a_path_without_drives_is_reported_wherever_it_stands() {
    let dir = tempfile::tempdir().unwrap();
    let (first, last) = (dir.path().join("a"), dir.path().join("b"));
    [&first, &last].into_iter().for_each(|d| fs::create_dir(d).unwrap());
    let log = fixtures().join("crossroads.fcd.xml");
    let paths = [first.clone(), log, PathBuf::from("/nowhere"), last.clone()];
    let (sources, problems) = find_sources(Some(AdapterRef(&sumo::Sumo)), &paths);
    assert_eq!(sources.len(), 1);
    let found: Vec<_> =
        problems.iter().map(|d| (d.code, d.location.file.clone().unwrap_or_default())).collect();
    let text = |p: &Path| p.display().to_string();
    assert_eq!(
        found,
        [
            ("ingest.nothing_found", text(&first)),
            ("ingest.path.missing", "/nowhere".to_owned()),
            ("ingest.nothing_found", text(&last)),
        ]
    );
}

#[test]
fn files_that_are_not_taken_are_named_with_the_reason() {
    let dir = tempfile::tempdir().unwrap();
    let deep = dir.path().join("a/b/c/d/e");
    fs::create_dir_all(&deep).unwrap();
    // A scenario under any name, a pickle that is none, and companions of a simulation, which are taken with it.
    fs::copy(fixtures().join("scenarionet/sd_byhand_p4.pkl"), deep.join("0.pkl")).unwrap();
    fs::write(dir.path().join("model.pkl"), [0x80, 4, b'N', b'.']).unwrap();
    fs::copy(fixtures().join("crossroads.fcd.xml"), dir.path().join("fcd.xml")).unwrap();
    fs::copy(fixtures().join("crossroads.net.xml"), dir.path().join("net.xml")).unwrap();
    for name in ["day.zip", "front.mp4", "car.dbc", "a/b/notes.md", "strange.xyz"] {
        fs::write(dir.path().join(name), "?").unwrap();
    }
    let (sources, problems) = find_sources(None, &[dir.path().to_owned()]);
    let mut formats: Vec<_> = sources.iter().map(|s| s.format()).collect();
    formats.sort_unstable();
    assert_eq!(formats, ["scenarionet", "sumo"]);
    assert!(problems.iter().all(|d| d.code == "ingest.files.skipped" && d.severity == Severity::Warning));
    let said: Vec<&str> = problems.iter().map(|d| d.message.en.as_str()).collect();
    let expected = [
        ("model.pkl", "pickle without a scenario"),
        ("day.zip", "unpack it first"),
        ("front.mp4", "whyroad media add"),
        ("car.dbc", "--dbc"),
        ("a/b/notes.md", "not a recording"),
        ("strange.xyz", "no adapter"),
    ];
    for (file, reason) in expected {
        assert!(said.iter().any(|m| m.contains(file) && m.contains(reason)), "{file}: {said:#?}");
    }
    assert!(!said.iter().any(|m| m.contains("net.xml") || m.contains("0.pkl")), "{said:#?}");
}

#[test]
#[cfg(unix)]
fn a_link_to_nowhere_loses_no_other_drive() {
    let dir = tempfile::tempdir().unwrap();
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/table/following");
    let drive = dir.path().join("sim");
    fs::create_dir(&drive).unwrap();
    for file in fs::read_dir(table).unwrap().flatten().filter(|f| f.path().is_file()) {
        fs::copy(file.path(), drive.join(file.file_name())).unwrap();
    }
    fs::copy(fixtures().join("crossroads.fcd.xml"), dir.path().join("a.fcd.xml")).unwrap();
    fs::copy(fixtures().join("scenarionet/sd_byhand_p4.pkl"), dir.path().join("sd_a.pkl")).unwrap();
    fs::write(dir.path().join("a.mcap"), "").unwrap();
    // With a given format, the drives of others are not sources: what is in their folders is outside.
    let all = [None, Some(AdapterRef(&sumo::Sumo))];
    let before = all.map(|format| find_sources(format, &[dir.path().to_owned()]).0);
    assert_eq!((before[0].len(), before[1].len()), (4, 1));

    std::os::unix::fs::symlink("/nowhere/at/all", dir.path().join("gone")).unwrap();
    std::os::unix::fs::symlink("/nowhere/at/all", drive.join("camera")).unwrap();
    for (format, before) in all.into_iter().zip(before) {
        let (sources, problems) = find_sources(format, &[dir.path().to_owned()]);
        assert_eq!(sources, before);
        let said: Vec<_> = problems
            .iter()
            .filter(|d| d.code == "ingest.path.unreadable")
            .map(|d| (d.severity, d.location.file.clone().unwrap_or_default(), d.message.en.contains("link")))
            .collect();
        let path = |p: &Path| p.display().to_string();
        let expected = match format {
            None => vec![
                (Severity::Error, path(&dir.path().join("gone")), true),
                (Severity::Warning, path(&drive.join("camera")), true),
            ],
            Some(_) => vec![(Severity::Error, path(dir.path()), true)],
        };
        assert_eq!(said, expected);
    }
}

#[test]
fn a_git_lfs_pointer_is_recognised() {
    let dir = tempfile::tempdir().unwrap();
    let log = dir.path().join("log");
    fs::create_dir(&log).unwrap();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
    fs::write(log.join("annotations.feather"), pointer).unwrap();
    fs::write(dir.path().join("other.bin"), pointer).unwrap();
    let (sources, problems) = find_sources(None, &[dir.path().to_owned()]);
    assert!(sources.is_empty(), "{sources:?}");
    assert_eq!(problems.len(), 2, "{problems:?}");
    for (d, name) in problems.iter().zip(["annotations.feather", "other.bin"]) {
        assert_eq!((d.code, d.severity), ("ingest.file.lfs_pointer", Severity::Error));
        assert!(d.message.en.contains(name) && d.hint.as_ref().unwrap().en.contains("git lfs pull"));
    }
}

#[test]
fn the_recorded_data_is_taken_or_named() {
    let root = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    if !root.is_dir() {
        crate::require::skipped("recorded", "no recorded data");
        return;
    }
    let (sources, problems) = find_sources(None, &[root]);
    let count = |format: &str| sources.iter().filter(|s| s.format() == format).count();
    // As ../shared/data/README.md lists them.
    let counts = ["av2", "av2-motion", "comma2k19", "scenarionet"].map(count);
    assert_eq!(counts, [4, 1, 1, 5], "{sources:#?}");
    let named = |file: &str| problems.iter().any(|d| d.message.en.contains(file));
    assert!(
        ["solidWhiteRight.mp4", "_toyota_2017.dbc", "README.md"].iter().all(|f| named(f)),
        "{problems:#?}"
    );
}

#[test]
fn two_sources_with_one_name_are_two_drives() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
    let log = fs::read_to_string(fixtures().join("crossroads.fcd.xml")).unwrap();
    let write = |folder: &str, text: &str| {
        let folder = dir.path().join(folder);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("run.fcd.xml"), text).unwrap();
        let (sources, _) = find_sources(Some(AdapterRef(&sumo::Sumo)), &[folder]);
        ingest(&sources[0], &Options::default(), &lake)
    };
    let changed = log.replace("speed=\"10", "speed=\"9");
    assert_ne!(log, changed);
    let first = write("a", &log);
    assert_eq!(first.outcome, Some(WriteOutcome::Written));
    let other = write("b", &changed);
    assert_eq!(other.outcome, Some(WriteOutcome::Written));
    assert!(other.diagnostics.iter().any(|d| d.code == "ingest.drive_id.taken"));
    assert_eq!(lake.drive_ids().len(), 2);
    // Again: both are found; a change of the first replaces the first.
    assert_eq!(write("b", &changed).outcome, Some(WriteOutcome::Unchanged));
    let again = write("a", &changed.replace("speed=\"9", "speed=\"8"));
    assert_eq!((again.outcome, again.drive_id), (Some(WriteOutcome::Replaced), first.drive_id.clone()));
    assert_eq!(lake.drive_ids().len(), 2);
    // An id that the user states is not changed: of another source it is refused, and nothing is stored.
    let stated = |folder: &str| {
        let (sources, _) = find_sources(Some(AdapterRef(&sumo::Sumo)), &[dir.path().join(folder)]);
        ingest(&sources[0], &Options::default().with_drive_id("mine".into()), &lake)
    };
    assert_eq!(stated("a").outcome, Some(WriteOutcome::Written));
    let refused = stated("b");
    assert!(refused.outcome.is_none() && refused.lost_input(), "{refused:?}");
    let said = refused.diagnostics.iter().find(|d| d.code == "ingest.drive_id.taken").unwrap();
    assert!(said.hint.as_ref().unwrap().en.contains("whyroad lake delete mine"), "{said:?}");
    assert_eq!((stated("a").outcome, lake.drive_ids().len()), (Some(WriteOutcome::Unchanged), 3));
}
