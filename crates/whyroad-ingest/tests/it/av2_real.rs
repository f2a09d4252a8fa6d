//! The recorded AV2 logs, where they are present: every row accounted for, and numbers against Python.
//! Expected numbers were computed with pandas and numpy from the raw files: speeds as the slope of a straight
//! line (`numpy.polyfit`) through the raw 170 Hz axle poses within 0.1 s either side; positions as R p + t with
//! a rotation matrix written out from the quaternion.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::path::PathBuf;
use whyroad_ingest::{SourceReport, av2};
use whyroad_model::scene::FrameOfReference;
use whyroad_model::{Drive, ObjectClass, Severity};

fn log(prefix: &str) -> Option<PathBuf> {
    let data = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let logs = std::fs::read_dir(data.join("av2/sensor_logs")).ok();
    let found = logs.and_then(|logs| {
        logs.flatten()
            .map(|e| e.path())
            .find(|p| p.file_name().unwrap().to_string_lossy().starts_with(prefix))
    });
    if found.is_none() {
        crate::require::skipped("recorded", "no recorded data");
    }
    found
}

fn read(prefix: &str) -> Option<(Drive, SourceReport)> {
    let (drive, report) = av2::read(&log(prefix)?, None);
    Some((drive.unwrap(), report))
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn every_row_is_read_and_kept() {
    // Rows, tracks and frames: pandas `len`, `nunique` on the raw files; 3bffdcff has 156 rows of the ego among its
    // rows.
    for (prefix, rows, ego, tracks, frames) in [
        ("7fab2350", 11364, 0, 114, 156),
        ("3bffdcff", 12342, 156, 115, 156),
        ("adcf7d18", 12078, 0, 146, 156),
        ("b87683ae", 6542, 0, 74, 157),
    ] {
        let Some((drive, report)) = read(prefix) else { return };
        let count = &report.tables[0];
        let counted = (count.table, count.read, count.kept_total(), count.dropped_total());
        assert_eq!(counted, ("annotations", rows, rows, 0));
        assert_eq!(count.kept.get("ego").copied().unwrap_or(0), ego);
        assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
        assert_eq!((drive.tracks.len(), drive.frame_count()), (tracks, frames));
        assert_eq!(drive.tracks.iter().map(|t| t.frames.len()).sum::<usize>(), rows - ego);
        assert!(report.diagnostics.iter().all(|d| d.severity != Severity::Error));
        // Nothing on these logs moves faster than it can.
        assert!(
            report.diagnostics.iter().all(|d| d.code != "ingest.speed.impossible"),
            "{:?}",
            report.diagnostics
        );
    }
}

#[test]
fn ego_speed_is_that_of_the_raw_poses() {
    for (prefix, speeds) in [
        ("7fab2350", [(20, 10.312), (50, 6.433), (90, 1.293), (120, 1.457)]),
        ("3bffdcff", [(20, 7.293), (50, 5.917), (90, 6.731), (120, 2.817)]),
        ("adcf7d18", [(20, 0.003), (50, 0.335), (90, 3.321), (120, 3.989)]),
    ] {
        let Some((drive, _)) = read(prefix) else { return };
        let drive = crate::estimated(drive);
        let ego = drive.ego.unwrap();
        for (frame, expected) in speeds {
            // The center swings round the axle in a bend, and our window is twice as long: 0.1 m/s of room.
            let speed = ego.motion.speed(frame);
            assert!(near(speed, expected, 0.1), "{prefix} frame {frame}: {speed} for {expected}");
            assert!(near(ego.motion.forward_speed(frame), expected, 0.1));
        }
    }
}

#[test]
fn ego_pose_is_the_middle_of_the_car() {
    // Frame 100: R (1.339, 0, 0.438) + t, and the yaw of R.
    for (prefix, center, yaw) in [
        ("7fab2350", [5224.8241, 2384.7275, 69.5608], -0.57638),
        ("3bffdcff", [5077.1132, 2480.2982, 63.4232], -0.33555),
        ("adcf7d18", [1483.9710, 217.1196, 13.4663], 0.35154),
    ] {
        let Some((drive, _)) = read(prefix) else { return };
        let m = drive.ego.unwrap().motion;
        let got = [m.x[100], m.y[100], m.z[100]];
        assert!(got.iter().zip(center).all(|(a, b)| near(*a, b, 1e-3)), "{prefix}: {got:?}");
        assert!(near(m.heading[100], yaw, 1e-4), "{prefix}: {}", m.heading[100]);
    }
}

#[test]
fn tracks_are_where_r_p_plus_t_puts_them() {
    type Row = (usize, f64, f64, f64, f64);
    let expected: [(&str, &str, [Row; 2]); 3] = [
        (
            "7fab2350",
            "cfb81ca8-c0aa-4917-b7c1-cff9554c780a",
            [(0, 5250.7542, 2376.5430, 70.4649, -2.16706), (155, 5250.7350, 2376.4454, 70.4525, -2.16501)],
        ),
        (
            "3bffdcff",
            "23f72b4f-0098-495f-ad55-20b3d2c6a66f",
            [(0, 5029.4135, 2474.3756, 61.7884, 0.35370), (155, 5099.2135, 2468.0577, 64.4443, -0.52910)],
        ),
        (
            "adcf7d18",
            "f5e7cc26-f036-4128-995a-3c804c6b2ead",
            [(56, 1485.7559, 217.7593, 13.5987, 0.32013), (111, 1516.2408, 228.7563, 13.4862, 0.35547)],
        ),
    ];
    for (prefix, track, rows) in expected {
        let Some((drive, _)) = read(prefix) else { return };
        let t = drive.track(&track.into()).unwrap();
        for (frame, x, y, z, heading) in rows {
            let i = t.row_at(frame).unwrap();
            let m = &t.motion;
            assert!(
                near(m.x[i], x, 1e-3) && near(m.y[i], y, 1e-3) && near(m.z[i], z, 1e-3),
                "{track} at {frame}"
            );
            assert!(near(m.heading[i], heading, 1e-4), "{track} at {frame}: {}", m.heading[i]);
        }
    }
}

#[test]
fn a_log_without_pose_and_map_is_kept_and_says_so() {
    let Some((drive, report)) = read("b87683ae") else { return };
    assert!(drive.ego.is_none() && drive.map.is_none());
    assert_eq!(drive.meta.frame_of_reference, FrameOfReference::Ego);
    assert!(
        ["ego pose", "map", "lidar points in boxes"].iter().all(|m| drive
            .meta
            .missing
            .iter()
            .any(|x| x.id() == *m))
    );
    let codes: Vec<_> = report.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["av2.pose.missing", "av2.map.missing"]);
    for t in &drive.tracks {
        assert!(t.motion.vx.iter().chain(&t.motion.accel).chain(&t.interior_points).all(|v| v.is_nan()));
        assert!(t.motion.x.iter().all(|v| v.abs() < 300.0), "relative to the ego");
    }
    let cyclists = drive.tracks.iter().filter(|t| t.class == ObjectClass::Bicyclist);
    assert_eq!(cyclists.map(|t| t.frames.len()).sum::<usize>(), 144);
}

#[test]
fn the_map_is_whole_and_its_links_agree() {
    // Counts: Python over the map's JSON. Links beyond the border are 21 successors and 14 predecessors.
    let Some((drive, report)) = read("7fab2350") else { return };
    let map = drive.map.unwrap();
    assert_eq!((map.lanes.len(), map.crosswalks.len(), map.drivable_areas.len()), (183, 11, 13));
    assert_eq!(map.lanes.iter().filter(|l| l.in_junction).count(), 73);
    // shapely's union of the 73 junction lanes has 14 parts.
    assert_eq!(map.junctions.len(), 14);
    for l in &map.lanes {
        for next in l.successors.iter().filter_map(|s| map.lane(s)) {
            assert!(next.predecessors.contains(&l.id), "{} -> {}", l.id, next.id);
            let (a, b) = (l.center.last().unwrap(), next.center[0]);
            assert!(
                (a.x - b.x).hypot(a.y - b.y) < 1.0,
                "lane {} does not end where {} begins",
                l.id,
                next.id
            );
        }
        assert!(l.junction_id.is_some() || !l.in_junction);
    }
    let border: Vec<_> = report
        .diagnostics
        .iter()
        .filter(|d| d.code == "av2.map.border")
        .map(|d| d.message.en.as_str())
        .collect();
    assert!(
        border.len() == 2
            && border[0].starts_with("14 predecessors")
            && border[1].starts_with("21 successors"),
        "{border:?}"
    );
}

#[test]
fn a_real_file_that_was_cut_is_an_error() {
    let Some(real) = log("7fab2350") else { return };
    let dir = tempfile::tempdir().unwrap();
    for name in ["annotations.feather", "city_SE3_egovehicle.feather"] {
        let bytes = std::fs::read(real.join(name)).unwrap();
        let end = if name == "annotations.feather" { bytes.len() * 2 / 3 } else { bytes.len() };
        std::fs::write(dir.path().join(name), &bytes[..end]).unwrap();
    }
    let (drive, report) = av2::read(dir.path(), None);
    assert!(drive.is_none(), "its one record batch is incomplete");
    let error = report.diagnostics.iter().find(|d| d.severity == Severity::Error).unwrap();
    assert_eq!(error.code, "av2.feather.truncated");
    assert!(
        error.hint.is_some()
            && error.location.file.as_deref().is_some_and(|f| f.ends_with("annotations.feather"))
    );
}
