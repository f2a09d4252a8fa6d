//! Waymo motion scenarios written with Waymo's own message classes from PyPI (`tests/fixtures/waymo/make.py`); every
//! expected value is that script's closed form, not our output.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{AdapterRef, Options, SourceReport, find_sources, waymo};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::road_map::{LaneKind, LaneMark};
use whyroad_model::scene::LightColor;
use whyroad_model::{Drive, ObjectClass};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/waymo")
}

fn file() -> PathBuf {
    fixtures().join("byhand.tfrecord-00000-of-00001")
}

fn read(path: &Path, at: u64) -> (Option<Drive>, SourceReport) {
    let (drive, report) = waymo::read(path, at, &Options::default());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive, report)
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

/// Sizes, headings and velocities are float32 in the format.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-4
}

#[test]
fn each_record_is_a_drive() {
    let (sources, problems) = find_sources(None, &[fixtures()]);
    assert!(crate::only_skipped(&problems) && sources.iter().all(|s| s.format() == "waymo-motion"));
    let found: Vec<_> = sources
        .iter()
        .map(|s| {
            let (drive, report) = whyroad_ingest::read(s, &Options::default());
            assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
            let drive = drive.unwrap();
            (drive.meta.drive_id.to_string(), drive.times.len())
        })
        .collect();
    assert_eq!(found, [("a1".to_owned(), 31), ("b2".to_owned(), 21)]);
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let outcome = || whyroad_ingest::ingest(&sources[1], &Options::default(), &lake).outcome;
    assert_eq!((outcome(), outcome()), (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged)));
}

#[test]
fn objects_and_the_ego_move_as_the_script_says() {
    let (drive, report) = read(&file(), 0);
    let drive = crate::estimated(drive.unwrap());
    let ego = drive.ego.as_ref().unwrap();
    // x = -40 + 10 t - t^2 at 2 s; braking at 2 m/s2.
    assert!(
        near(ego.motion.x[20], -24.0)
            && near(ego.motion.vx[20], 6.0)
            && (ego.motion.accel[20] + 2.0).abs() < 1e-3
    );
    assert!(near(ego.length_m, 4.8) && near(ego.width_m, 2.1) && near(ego.height_m, 1.6));
    assert_eq!(drive.tracks.iter().map(|t| t.id.as_str()).collect::<Vec<_>>(), ["41", "7"]);
    let walker = &drive.tracks[0];
    // Valid up to 1.0 s.
    assert_eq!((walker.class, walker.frames.len()), (ObjectClass::Pedestrian, 11));
    assert!(near(walker.motion.y[10], -4.5) && near(walker.motion.heading[10], std::f64::consts::FRAC_PI_2));
    let cyclist = &drive.tracks[1];
    assert!(
        cyclist.class == ObjectClass::Bicycle
            && near(cyclist.motion.vy[30], -4.0)
            && near(cyclist.motion.y[30], -4.0)
    );
    let states = &report.tables[0];
    assert_eq!(
        (states.read, states.kept["ego"], states.kept["track"], states.set_aside["not_observed"]),
        (93, 31, 42, 20)
    );
}

#[test]
fn the_map_has_edges_marks_limits_and_what_lies_beside() {
    let map = read(&file(), 0).0.unwrap().map.unwrap();
    let lane = map.lane("100").unwrap();
    assert!(lane.left.iter().all(|p| near(p.y, 1.7)) && lane.right.iter().all(|p| near(p.y, -2.0)));
    assert_eq!((lane.left_mark, lane.right_mark), (LaneMark::DoubleSolid, LaneMark::Unknown));
    assert_eq!((lane.left_neighbor.as_deref(), lane.successors[0].as_str()), (Some("102"), "101"));
    // 25 mph.
    assert!(near(lane.speed_limit_mps.unwrap(), 11.176));
    assert_eq!(map.lane("102").unwrap().kind, LaneKind::Bike);
    assert!(map.lane("101").unwrap().in_junction && lane.junction_id.as_deref() == Some("junction_101"));
    assert_eq!((map.signs[0].kind.as_str(), map.signs[0].lane_ids[0].as_str()), ("stop", "102"));
    assert_eq!((map.facilities.len(), map.crosswalks.len(), map.stop_lines.len()), (2, 1, 1));
    let stop = &map.stop_lines[0];
    assert!(
        stop.lane_ids == ["101"]
            && stop.line.iter().all(|p| near(p.x, 0.0))
            && stop.line[0].y > stop.line[1].y
    );
}

#[test]
fn light_states_are_those_of_the_lane() {
    let drive = read(&file(), 0).0.unwrap();
    let lights = drive.lights.as_ref().unwrap();
    let seen: Vec<_> = lights.iter().map(|l| (l.lane_id.as_str(), l.time, l.color)).collect();
    // In view from step 5, red from step 15.
    assert_eq!(
        seen,
        [("101", drive.times[5], LightColor::GreenRound), ("101", drive.times[15], LightColor::Red)]
    );
}

#[test]
fn a_cut_or_changed_record_is_told_and_the_others_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.tfrecord");
    let bytes = fs::read(file()).unwrap();
    let second = usize::try_from(u64::from_le_bytes(bytes[..8].try_into().unwrap())).unwrap() + 16;

    fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    let (sources, _) = find_sources(Some(AdapterRef(&waymo::WaymoMotion)), std::slice::from_ref(&path));
    assert_eq!(sources.iter().map(|s| s.part).collect::<Vec<_>>(), [Some(0), Some(second as u64)]);
    let (drive, report) = read(&path, second as u64);
    assert!(drive.is_none() && codes(&report) == ["waymo.record.truncated"]);
    assert!(read(&path, 0).0.is_some());

    // One bit in the middle of the first record; then one in the length of the second.
    for (at, record) in [(second / 2, 0), (second, second as u64)] {
        let mut changed = bytes.clone();
        changed[at] ^= 1;
        fs::write(&path, &changed).unwrap();
        let (drive, report) = read(&path, record);
        assert!(drive.is_none() && codes(&report) == ["waymo.record.corrupt"], "{:?}", report.diagnostics);
    }
    // A file that is something else is not taken for one of ours.
    fs::write(&path, b"not a record at all, but a text").unwrap();
    let (sources, problems) =
        find_sources(Some(AdapterRef(&waymo::WaymoMotion)), std::slice::from_ref(&path));
    assert!(sources.is_empty() && problems[0].code == "ingest.nothing_found");
}

#[test]
fn a_record_of_another_message_is_refused() {
    // A record of field 1 = "abc" (a string where times are wanted); checksums by google_crc32c 1.7.
    let bytes = b"\x05\x00\x00\x00\x00\x00\x00\x00@LEN\x0a\x03abc@SUM";
    let mut record = bytes.to_vec();
    record[8..12].copy_from_slice(&[0xea, 0xb2, 0x04, 0x3e]);
    record[17..21].copy_from_slice(&[0x4d, 0x73, 0x94, 0x10]);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("x.tfrecord");
    fs::write(&path, &record).unwrap();
    let (drive, report) = read(&path, 0);
    assert!(drive.is_none() && codes(&report) == ["waymo.schema"], "{:?}", report.diagnostics);
}
