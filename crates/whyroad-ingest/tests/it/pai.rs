//! A tree in the layout of PhysicalAI-AV, made by `tests/fixtures/pai/make.py` and read by the publisher's own package
//! in `python/tests/test_pai_fixture.py`. Expected values are the script's closed form, computed here independently.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, SourceReport, find_sources, pai};
use whyroad_model::{Drive, Nanos, Need, ObjectClass, Severity, TrackId};

const FIRST: &str = "00000001-0000-4000-8000-000000000001";

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/pai")
}

fn read(root: &Path, row: u64) -> (Option<Drive>, SourceReport) {
    let mut out = None;
    pai::read_several(root, &[row], &Options::default(), &mut |drive, report| out = Some((drive, report)));
    let (drive, report) = out.unwrap();
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive, report)
}

fn codes(report: &SourceReport) -> Vec<&str> {
    report.diagnostics.iter().map(|d| d.code).collect()
}

/// A copy of the tree that a test may break.
fn copy(to: &Path) {
    fn all(from: &Path, to: &Path) {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap().flatten() {
            let (path, target) = (entry.path(), to.join(entry.file_name()));
            if path.is_dir() {
                all(&path, &target);
            } else {
                fs::copy(&path, &target).unwrap();
            }
        }
    }
    all(&fixtures().join("tree"), to);
}

#[test]
fn clips_of_downloaded_chunks_are_sources() {
    let (sources, problems) = find_sources(None, &[fixtures()]);
    assert!(crate::only_skipped(&problems), "{problems:?}");
    let rows: Vec<_> = sources.iter().map(|s| (s.format(), s.part)).collect();
    // The fourth clip is in chunk 1, which is not there.
    assert_eq!(rows, [("pai", Some(0)), ("pai", Some(1)), ("pai", Some(2))]);
}

#[test]
fn rear_axle_poses_become_the_motion_of_the_box_center() {
    let (drive, report) = read(&fixtures().join("tree"), 0);
    let drive = crate::estimated(drive.unwrap());
    assert_eq!(drive.meta.drive_id.as_str(), FIRST);
    assert_eq!(
        (drive.meta.place.as_deref(), drive.meta.source.as_str()),
        (Some("Germany"), "physical-ai-av made_up")
    );
    // -0.25 s to 4.0 s: tenths from -0.2 s on.
    assert_eq!(drive.times.len(), 43);
    let start = Options::default().start();
    assert_eq!((drive.times[0], drive.times[2]), (Nanos(start.0 - 200_000_000), start));
    let ego = drive.ego.as_ref().unwrap();
    assert_eq!((ego.length_m, ego.reference_to_centre_m), (4.8, 1.4));
    // At t = 3 s: heading 0.3, rear axle (100 sin 0.3, 100 (1 - cos 0.3)), center 1.4 m ahead of it.
    let a = 0.3f64;
    let (x, y) = (100.0 * a.sin() + 1.4 * a.cos(), 100.0 * (1.0 - a.cos()) + 1.4 * a.sin());
    let m = &ego.motion;
    assert!((m.x[32] - x).abs() < 1e-6 && (m.y[32] - y).abs() < 1e-6 && (m.z[32] - 0.8).abs() < 1e-9);
    assert!((m.heading[32] - a).abs() < 1e-9 && (m.yaw_rate[32] - 0.1).abs() < 1e-6);
    // The center moves on a circle of sqrt(100^2 + 1.4^2) m; its velocity along the heading is the rear axle's.
    assert!((m.speed(32) - 0.1 * 100.0f64.hypot(1.4)).abs() < 1e-4, "{}", m.speed(32));
    assert!((m.forward_speed(32) - 10.0).abs() < 1e-4);
    let missing = [Need::Map, Need::TrafficLights, Need::Route, Need::VehicleBus];
    assert!(missing.iter().all(|n| drive.meta.missing.contains(n)), "{:?}", drive.meta.missing);
    assert!(
        !drive.meta.missing.contains(&Need::Objects) && !drive.meta.missing.contains(&Need::CameraPictures)
    );
    let poses = report.tables.iter().find(|t| t.table == "egomotion").unwrap();
    assert_eq!((poses.read, poses.kept["pose"]), (426, 426));
}

#[test]
fn boxes_in_the_rig_at_their_own_time_come_to_rest_in_the_world() {
    let (drive, report) = read(&fixtures().join("tree"), 0);
    let drive = crate::estimated(drive.unwrap());
    let ids: Vec<_> = drive.tracks.iter().map(|t| (t.id.as_str(), t.class)).collect();
    // Track 0 is the ego itself.
    assert_eq!(
        ids,
        [
            ("12", ObjectClass::Truck),
            ("31", ObjectClass::Pedestrian),
            ("40", ObjectClass::Unknown),
            ("7", ObjectClass::Car)
        ]
    );
    let truck = drive.track(&TrackId::from("12")).unwrap();
    for row in 0..truck.frames.len() {
        assert!((truck.motion.x[row] - 40.0).abs() < 1e-6 && (truck.motion.y[row] - 5.0).abs() < 1e-6);
        assert!((truck.motion.heading[row] - 0.5).abs() < 1e-9 && truck.motion.speed(row) < 1e-6);
    }
    let car = drive.track(&TrackId::from("7")).unwrap();
    // Rows from 0.03 to 3.43 s: frames from 0.1 to 3.4 s; at frame 22, 2.0 s, x = 36.
    assert_eq!((car.frames[0], car.frames[car.frames.len() - 1]), (3, 36));
    let row = car.row_at(22).unwrap();
    assert!((car.motion.x[row] - 36.0).abs() < 1e-6 && (car.motion.vx[row] - 8.0).abs() < 1e-6);
    assert_eq!((car.length_m[row], car.width_m[row], car.height_m[row]), (4.5, 1.8, 1.5));
    let codes = codes(&report);
    for code in
        ["pai.obstacles.invalid", "pai.obstacles.class", "pai.obstacles.partial", "ingest.rate.resampled"]
    {
        assert!(codes.contains(&code), "{codes:?}");
    }
    let rows = report.tables.iter().find(|t| t.table == "obstacles").unwrap();
    assert_eq!((rows.kept["ego"], rows.kept["track"], rows.dropped["unknown_frame"]), (35, 139, 1));
}

#[test]
fn camera_frames_are_named_where_they_are() {
    let (drive, _) = read(&fixtures().join("tree"), 0);
    let media = drive.unwrap().media.unwrap();
    assert_eq!(media.len(), 40);
    let last = &media[39];
    assert_eq!((last.camera.as_str(), last.index), ("camera_front_wide_120fov", 39));
    assert_eq!(last.time, Options::default().start().plus_secs(3.8));
    let archive = "camera/camera_front_wide_120fov/camera_front_wide_120fov.chunk_0000.zip";
    assert_eq!(last.uri, format!("{archive}!/{FIRST}.camera_front_wide_120fov.mp4"));
}

#[test]
fn what_was_not_downloaded_is_unknown_and_not_empty() {
    let (drive, report) = read(&fixtures().join("tree"), 1);
    let drive = drive.unwrap();
    for need in [Need::Objects, Need::EgoSize, Need::CameraPictures] {
        assert!(drive.meta.missing.contains(&need), "{need:?}");
    }
    assert_eq!(codes(&report), ["pai.dimensions.missing", "pai.obstacles.missing"]);
    assert!(drive.ego.as_ref().unwrap().length_m.is_nan());
    // 0 to 1.0 and 1.5 to 2.5 s: the gap has no frames.
    assert_eq!(drive.times.len(), 22);
    assert!((drive.times[11].seconds_since(drive.times[10]) - 0.5).abs() < 1e-9);
    let (none, report) = read(&fixtures().join("tree"), 2);
    assert!(none.is_none() && codes(&report) == ["pai.clip.invalid"]);
}

#[test]
fn broken_files_are_reported_and_the_rest_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    copy(dir.path());
    let obstacles = dir.path().join("labels/obstacle.offline/obstacle.offline.chunk_0000.zip");
    let whole = fs::read(&obstacles).unwrap();
    // A changed byte inside the member: the archive's check sum finds it.
    let mut changed = whole.clone();
    changed[whole.len() / 2] ^= 0x55;
    for broken in [changed, whole[..whole.len() / 2].to_vec(), b"not an archive".to_vec()] {
        fs::write(&obstacles, broken).unwrap();
        let (drive, report) = read(dir.path(), 0);
        assert!(drive.unwrap().meta.missing.contains(&Need::Objects));
        assert!(codes(&report).contains(&"pai.obstacles.unreadable") && report.lost_input());
    }
    fs::write(dir.path().join("labels/egomotion/egomotion.chunk_0000.zip"), "?").unwrap();
    let (drive, report) = read(dir.path(), 0);
    assert!(drive.is_none() && codes(&report) == ["pai.egomotion.unreadable"]);
    fs::write(
        dir.path().join("features.csv"),
        "feature,chunk_path,clip_files_in_zip\negomotion,../../secret.zip,{}\n",
    )
    .unwrap();
    let (drive, report) = read(dir.path(), 0);
    assert!(drive.is_none() && report.diagnostics[0].severity == Severity::Error);
    assert_eq!(codes(&report), ["pai.tree.unreadable"]);
}
