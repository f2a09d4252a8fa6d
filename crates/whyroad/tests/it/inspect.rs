//! `whyroad inspect` as a person runs it.
#![allow(clippy::unwrap_used)]

use crate::mine::number_before;
use std::f64::consts::PI;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn whyroad(args: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new(env!("CARGO_BIN_EXE_whyroad"))
        .args(args)
        .env_remove("WHYROAD_LANG")
        .current_dir(root)
        .output()
        .unwrap()
}

fn out(o: &Output) -> String {
    String::from_utf8(o.stdout.clone()).unwrap()
}

#[test]
fn a_lake_is_listed_and_a_clip_is_shown() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().to_str().unwrap();
    let fixture = "crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml";
    assert!(whyroad(&["ingest", "sumo", fixture, "--lake", lake]).status.success());

    let all = whyroad(&["inspect", "--lake", lake]);
    assert_eq!(all.status.code(), Some(0));
    let text = out(&all);
    // By the fixture: 5 frames, a lorry for 3 of them, a bicycle and a person for 5; 12 lanes, 3 of them internal, 2 at
    // J, which has lights (a facility of the map).
    for part in [
        "1 drive, 1 clip",
        // What `select.sources` in the spec of a data set takes; the format is another thing.
        "  formats: sumo 1\n  sources: sumo 1\n",
        "crossroads-ego (sumo, crossroads)\n  source: sumo\n",
        // FCD has no dates: what `ingest` sets as the start is not shown as one.
        "crossroads-ego_000  no date  0.5 s  5 frames",
        "ego: 5.00 x 1.80 m, 10.0 - 10.0 m/s",
        // The fixture's figures are exact.
        "noise ego: 0.000 m, 0.00 deg, 0.00 m/s (exact)",
        "noise vehicles: 0.000 m, 0.00 deg, 0.00 m/s (exact)",
        "tracks: 3, 13 rows; 3 objects after joining tracks that break off",
        "truck                  1        3 rows",
        "crosswalks 1, facilities 1 (traffic lights 1), junctions 1, lanes 12, lanes in junctions 2, stop lines 1",
        "tables: clips, frames, tracks, ego, map\n",
        "not in the log: traffic lights",
        "not observable (needs traffic lights): light.countdown, light.distance_to_stop_line, light.previous,",
    ] {
        assert!(text.contains(part), "no '{part}' in\n{text}");
    }

    let clip = whyroad(&["inspect", "--lake", lake, "--clip", "crossroads-ego_000", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&out(&clip)).unwrap();
    assert_eq!(json[0]["signals"]["ego.speed"], serde_json::json!({"known": 5, "rows": 5}));
    assert_eq!(json[0]["clips"][0]["total_frames"], 5);
    // The log has a pose of the ego and a map, and no signs.
    assert_eq!(json[0]["unavailable"]["light.state"], serde_json::json!(["traffic lights"]));
    assert_eq!(json[0]["unavailable"]["sign.stop_distance"], serde_json::json!(["signs"]));
    assert_eq!(json[0]["unavailable"]["ego.fair_speed"], serde_json::json!([]));

    let zh = out(&whyroad(&["inspect", "--lake", lake, "--lang", "zh"]));
    assert!(zh.contains("日志中没有: 交通信号灯") && zh.contains("人行横道 1"), "{zh}");
}

#[test]
fn what_is_not_there_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().to_str().unwrap();
    let o = whyroad(&["inspect", "--lake", lake]);
    assert_eq!(o.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&o.stderr).contains("error[lake.not_a_lake]"));
    let fixture = "crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml";
    assert!(whyroad(&["ingest", "sumo", fixture, "--lake", lake]).status.success());
    for clip in ["crossroads-ego_001", "crossroads-ego_0", "nothing"] {
        assert_eq!(whyroad(&["inspect", "--lake", lake, "--clip", clip]).status.code(), Some(1), "{clip}");
    }
}

/// Signals are known, not observable, or without a value: each is in one group, in both languages.
#[test]
fn the_groups_of_signals_are_all_signals() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let lake = tempfile::tempdir().unwrap();
    let (path, drive) = (lake.path().to_str().unwrap(), root.join("examples/drives/multilane"));
    let ingested = whyroad(&["ingest", "sumo", drive.to_str().unwrap(), "--lake", path]);
    assert!(ingested.status.success(), "{}", out(&ingested));
    for (lang, of, known, blind, without, names) in [
        ("en", " of ", " of ", " not observable", " without a value", "without a value here: "),
        ("zh", " 个中 ", " 个已知", " 个不可观测", " 个没有值", "但没有值: "),
    ] {
        let shown = out(&whyroad(&["--lang", lang, "inspect", "--lake", path]));
        let line = shown.lines().find(|l| l.contains(without)).unwrap_or_else(|| panic!("{shown}"));
        let number = |word: &str| number_before(line, word) as usize;
        let numbers: Vec<usize> =
            line.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
        assert!(line.contains(of) && numbers.len() == 4, "{line}");
        let (a, b, c) = (number(known), number(blind), number(without));
        assert_eq!(a + b + c, *numbers.iter().max().unwrap(), "{line}");
        let named = shown.lines().find_map(|l| l.split(names).nth(1)).map_or(0, |l| l.split(", ").count());
        assert_eq!(named, c, "{shown}");
    }
}

/// What several drives lack is listed once; the lists of one drive are asked for.
#[test]
fn lists_of_signals_are_not_repeated_for_every_drive() {
    let dir = tempfile::tempdir().unwrap();
    let lake = dir.path().to_str().unwrap();
    for fixture in ["crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml", "examples/drives/multilane"] {
        assert!(whyroad(&["ingest", "sumo", fixture, "--lake", lake]).status.success());
    }
    let several = out(&whyroad(&["inspect", "--lake", lake]));
    // Neither log has states of traffic lights; the motorway has no stop lines (the network has no junction).
    assert_eq!(several.matches("light.countdown").count(), 1, "{several}");
    assert!(several.contains("    2 of 2 drives (needs traffic lights): "), "{several}");
    assert!(
        several.contains("    1 of 2 drives (needs stop lines): map.distance_to_stop_line,"),
        "{several}"
    );
    assert_eq!(several.matches(" without a value\n").count(), 2, "{several}");
    let one = out(&whyroad(&["inspect", "--lake", lake, "--drive", "crossroads-ego"]));
    assert!(one.contains("    not observable (needs traffic lights): light.countdown,"), "{one}");
    assert!(!one.contains("multilane"), "{one}");
    let none = whyroad(&["inspect", "--lake", lake, "--drive", "nothing"]);
    let said = String::from_utf8_lossy(&none.stderr).into_owned();
    assert!(
        none.status.code() == Some(1) && said.contains("drive 'nothing' not found in the lake"),
        "{said}"
    );
}

/// A drive without a map in the table layout: 40 m straight, a quarter of a circle of 12 m radius to the right, 80 m
/// straight, at 10 m/s.
fn turn_without_a_map(dir: &Path) {
    let (corner, quarter) = (40.0, 6.0 * PI);
    let mut ego = "time_s,x_m,y_m,heading_rad\n".to_owned();
    for i in 0..139 {
        let s = f64::from(i);
        let turned = ((s - corner) / 12.0).clamp(0.0, PI / 2.0);
        let on = (s - corner - quarter).max(0.0);
        let (x, y) = (s.min(corner) + 12.0 * turned.sin(), -12.0 * (1.0 - turned.cos()) - on);
        writeln!(ego, "{:.3},{x:.6},{y:.6},{:.6}", s / 10.0, -turned).unwrap();
    }
    let meta = r#"{"source": "test",
        "ego": {"length_m": 4.8, "width_m": 1.9, "height_m": 1.5, "reference_to_centre_m": 0}}"#;
    fs::write(dir.join("drive.json"), meta).unwrap();
    fs::write(dir.join("ego.csv"), ego).unwrap();
    fs::write(dir.join("objects.csv"), "time_s,track_id,class,x_m,y_m,heading_rad\n").unwrap();
}

#[test]
fn a_turn_without_a_map_is_found_and_nothing_else_counts_as_searched() {
    let dir = tempfile::tempdir().unwrap();
    let [log, lake, mined] = ["log", "lake", "mined"].map(|name| dir.path().join(name));
    fs::create_dir(&log).unwrap();
    turn_without_a_map(&log);
    let [log, lake, mined] = [&log, &lake, &mined].map(|path| path.to_str().unwrap());
    assert_eq!(whyroad(&["ingest", "table", log, "--lake", lake]).status.code(), Some(0));
    assert_eq!(whyroad(&["mine", "--lake", lake, "--out", mined]).status.code(), Some(0));
    let coverage = fs::read_to_string(Path::new(mined).join("coverage.json")).unwrap();
    let coverage: serde_json::Value = serde_json::from_str(&coverage).unwrap();
    let of =
        |id: &str| coverage["leaves"].as_array().unwrap().iter().find(|l| l["scenario_id"] == id).unwrap();
    let (right, left) = (of("proactive.turn.right_normal"), of("proactive.turn.left_normal"));
    // Found, and yet the drive was not searched: turns of another shape may be in it.
    assert_eq!(
        (&right["state"], &right["episodes"], &right["drives_searched"]),
        (&"found".into(), &1.into(), &0.into())
    );
    assert_eq!((&left["state"], &left["drives_searched"]), (&"not_observable".into(), &0.into()));
    let lacking = right["gaps"][0]["missing_signals"].as_array().unwrap();
    assert!(lacking.contains(&"ego.in_junction".into()), "{right}");

    let text = out(&whyroad(&["inspect", "--lake", lake]));
    let line =
        "known only where other data proves it (needs map): ego.in_junction, ego.movement, ego.turn_angle,";
    assert!(text.contains(line), "{text}");
    let missing = out(&whyroad(&["mine", "--lake", lake, "--out", mined, "--missing", "--format", "json"]));
    assert!(missing.contains("proactive.turn.right_normal"), "{missing}");
    let stored = out(&whyroad(&["inspect", "--lake", lake, "--format", "json"]));
    let stored: serde_json::Value = serde_json::from_str(&stored).unwrap();
    assert_eq!(stored[0]["partial"]["ego.movement"], serde_json::json!(["map"]));
    assert_eq!(stored[0]["unavailable"].get("ego.movement"), None);
}
