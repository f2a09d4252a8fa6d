//! ScenarioNet scenarios pickled by Python and numpy and passed by MetaDrive's own `sanity_check`
//! (`tests/fixtures/scenarionet/make.py`); every expected value is that script's closed form, not our output.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, SourceReport, find_sources, scenarionet};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::road_map::LaneMark;
use whyroad_model::scene::LightColor;
use whyroad_model::{Drive, Need, ObjectClass};

const ALL: [&str; 5] = ["p2", "p3", "p4", "p5", "numpy1"];

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/scenarionet")
}

fn read(name: &str) -> (Drive, SourceReport) {
    let (drive, report) =
        scenarionet::read(&fixtures().join(format!("sd_byhand_{name}.pkl")), &Options::default());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive.unwrap(), report)
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn refused(bytes: &[u8]) -> SourceReport {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("sd_x.pkl");
    std::fs::write(&file, bytes).unwrap();
    let (drive, report) = scenarionet::read(&file, &Options::default());
    assert!(drive.is_none());
    report
}

/// Positions are float32 in the fixture.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-4
}

#[test]
fn every_protocol_and_both_numpys_give_the_same_drive() {
    let (first, _) = read("p4");
    for name in ALL {
        let (drive, report) = read(name);
        assert!(report.diagnostics.is_empty(), "{name}: {:?}", report.diagnostics);
        assert_eq!((drive.times.len(), drive.tracks.len()), (41, 3), "{name}");
        // `ts` counts seconds from the start of the scenario.
        assert!(drive.meta.missing.contains(&Need::Date), "{name}");
        assert_eq!(drive.times, first.times);
        assert_eq!(drive.map, first.map);
        assert_eq!(drive.lights, first.lights);
        for (a, b) in drive.tracks.iter().zip(&first.tracks) {
            assert_eq!(
                (&a.id, &a.frames, &a.motion.x, &a.motion.vx),
                (&b.id, &b.frames, &b.motion.x, &b.motion.vx)
            );
        }
    }
}

#[test]
fn ego_and_objects_are_where_the_script_puts_them() {
    let (drive, report) = read("p5");
    let drive = crate::estimated(drive);
    let ego = drive.ego.as_ref().unwrap();
    // x = -40 + 10 t at t = 1.5 s.
    assert!(
        near(ego.motion.x[15], -25.0) && near(ego.motion.vx[15], 10.0) && ego.motion.accel[15].abs() < 0.01
    );
    assert!(near(ego.length_m, 4.8) && near(ego.width_m, 2.0) && near(ego.height_m, 1.5));
    let cyclist = drive.track(&"30".into()).unwrap();
    // In view from frame 10: y = -6 + 2 t.
    assert_eq!((cyclist.class, cyclist.frames[0], cyclist.frames.len()), (ObjectClass::Bicycle, 10, 31));
    assert!(near(cyclist.motion.y[0], -4.0) && near(cyclist.motion.heading[0], std::f64::consts::FRAC_PI_2));
    // A `VEHICLE` of no stated kind.
    assert_eq!(drive.track(&"12".into()).unwrap().class, ObjectClass::Vehicle);
    assert!(near(drive.track(&"12".into()).unwrap().width_m[0], 2.5));
    assert_eq!(drive.track(&"cone".into()).unwrap().class, ObjectClass::Cone);
    // 4 objects of 41 rows, of which the cyclist's first 10 are not valid.
    let states = &report.tables[0];
    assert_eq!(
        (states.read, states.kept["ego"], states.kept["track"], states.set_aside["not_observed"]),
        (164, 41, 113, 10)
    );
}

/// nuScenes is localized in a plane: https://www.nuscenes.org/nuscenes, schema of `ego_pose`: "the z-coordinate is
/// always 0"; the boxes' heights are relative to that.
#[test]
fn a_set_localized_in_a_plane_has_no_heights() {
    let (waymo, _) = read("p2");
    assert!(waymo.ego.unwrap().motion.z.iter().all(|z| z.is_finite()));
    let bytes = std::fs::read(fixtures().join("sd_byhand_p2.pkl")).unwrap();
    // A string of protocol 2: X, its length in four bytes, the text.
    let (from, to) = (b"X\x05\0\0\0waymo", b"X\x08\0\0\0nuscenes");
    let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("sd_x.pkl");
    std::fs::write(&file, [&bytes[..at], to, &bytes[at + from.len()..]].concat()).unwrap();
    let drive = scenarionet::read(&file, &Options::default()).0.unwrap();
    assert_eq!(drive.meta.source, "nuscenes");
    let tracks = drive.tracks.iter().flat_map(|t| &t.motion.z);
    assert!(tracks.chain(&drive.ego.unwrap().motion.z).all(|z| z.is_nan()));
    let lanes = drive.map.unwrap().lanes;
    assert!(lanes.iter().flat_map(|l| l.center.iter().chain(&l.left)).all(|p| p.z.is_nan()));
}

#[test]
fn lanes_get_their_edges_from_the_lines_they_name() {
    let (drive, _) = read("p4");
    let map = drive.map.unwrap();
    let lane = map.lane("100").unwrap();
    // The line 1.8 m to the left, the curb 1.6 m to the right; the curb is named for the first half only.
    assert!(
        lane.left.iter().all(|p| near(p.y, 1.8)) && lane.right.iter().all(|p| near(p.y, -1.6)),
        "{lane:?}"
    );
    assert_eq!((lane.left_mark, lane.right_mark), (LaneMark::Dashed, LaneMark::Unknown));
    assert_eq!((lane.left_neighbor.as_deref(), lane.right_neighbor.as_deref()), (Some("102"), None));
    assert_eq!(lane.successors, ["101"]);
    // 30 mph.
    assert!(near(lane.speed_limit_mps.unwrap(), 13.4112));
    // 102 names no line: it has no edges, but an outline of 50 m by 3.4 m.
    let other = map.lane("102").unwrap();
    assert!(other.left.is_empty() && near(other.width_m.unwrap(), 3.4));
    // 101 lies between two lanes, so it is the junction's, and 100 leads into it.
    assert!(map.lane("101").unwrap().in_junction && !lane.in_junction);
    assert_eq!((map.junctions.len(), lane.junction_id.as_deref()), (1, Some("junction_101")));
    assert_eq!(map.signs[0].lane_ids, ["102"]);
    let kinds: Vec<_> = map.facilities.iter().map(|f| f.kind.as_str()).collect();
    assert_eq!((kinds, map.crosswalks.len()), (vec!["speed_bump", "driveway"], 1));
    assert_eq!((map.crosswalks[0].boundary.len(), map.stop_lines[0].lane_ids[0].as_str()), (5, "101"));
}

#[test]
fn light_states_begin_where_they_change_and_end_unseen() {
    let (drive, _) = read("p3");
    let lights = drive.lights.unwrap();
    let changes: Vec<_> = lights.iter().map(|l| (l.time.seconds_since(drive.times[0]), l.color)).collect();
    let expected = [
        (0.0, LightColor::GreenRound),
        (1.0, LightColor::Yellow),
        (2.0, LightColor::Red),
        (3.1, LightColor::Unknown),
    ];
    for (got, want) in changes.iter().zip(&expected) {
        assert!(near(got.0, want.0) && got.1 == want.1, "{changes:?}");
    }
    assert!(changes.len() == 4 && lights.iter().all(|l| l.lane_id == "101"));
}

#[test]
fn a_pickle_with_a_command_is_refused_by_name() {
    // pickle.dumps of an object whose __reduce__ gives (os.system, ("touch /tmp/x",)), protocol 4; then hidden as a
    // track of a scenario, protocol 2.
    let alone = b"\x80\x04\x95\x22\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94\x8c\x07touch x\x94\x85\x94R\x94.";
    let hidden = b"\x80\x02}X\x06\x00\x00\x00trackscposix\nsystem\nX\x07\x00\x00\x00touch x\x85Rs.";
    for bytes in [&alone[..], &hidden[..]] {
        let report = refused(bytes);
        assert_eq!(codes(&report), ["scenarionet.pickle.forbidden"]);
        assert!(report.diagnostics[0].message.en.contains("posix.system"), "{:?}", report.diagnostics);
    }
}

#[test]
fn objects_that_share_one_array_cannot_become_more_rows_than_the_file_has_bytes() {
    // A scenario of 100 steps whose 5000 objects all are one dict: 500 000 rows of 26 kB.
    let mut b = b"\x80\x02}(X\x08\x00\x00\x00metadata}X\x02\x00\x00\x00ts](".to_vec();
    (0..100u8).for_each(|i| b.extend([b'K', i]));
    b.extend(b"esX\x06\x00\x00\x00tracks}(");
    b.extend(b"K\x00}X\x05\x00\x00\x00state}X\x08\x00\x00\x00position](");
    (0..100).for_each(|_| b.extend(b"K\x01K\x02\x86"));
    b.extend(b"ess\x72\x00\x00\x00\x00");
    for i in 1..5000u16 {
        b.extend([&b"M"[..], &i.to_le_bytes(), b"h\x00"].concat());
    }
    b.extend(b"uu.");
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("sd_x.pkl");
    std::fs::write(&file, &b).unwrap();
    let (_, report) = scenarionet::read(&file, &Options::default());
    assert!(
        report.tables[0].adds_up() && report.tables[0].dropped["invalid"] > 400_000,
        "{:?}",
        report.tables
    );
}

#[test]
fn what_is_no_scenario_says_where() {
    let report = refused(b"\x80\x02}X\x06\x00\x00\x00tracks}s.");
    assert_eq!(codes(&report), ["scenarionet.schema"]);
    assert_eq!(report.diagnostics[0].location.pointer.as_deref(), Some("/metadata/ts"));
    let whole = std::fs::read(fixtures().join("sd_byhand_p4.pkl")).unwrap();
    assert_eq!(codes(&refused(&whole[..whole.len() / 2])), ["scenarionet.pickle.unreadable"]);
}

#[test]
fn a_database_is_recognised_and_the_same_scenario_comes_in_once() {
    let (sources, problems) = find_sources(None, &[fixtures()]);
    assert!(
        crate::only_skipped(&problems)
            && sources.len() == 5
            && sources.iter().all(|s| s.format() == "scenarionet")
    );
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let outcome = || whyroad_ingest::ingest(&sources[1], &Options::default(), &lake).outcome;
    assert_eq!((outcome(), outcome()), (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged)));
}

/// Scenes of nuScenes in ScenarioNet pickles. Classes: the objects by `metadata.type`, counted by Python's pickle
/// (cars, trucks with trailers, buses, construction vehicles, motorcycles, bicycles). Poses: the rows from the step
/// backwards on (-0.35, -0.42 and -1.91 m along the heading within 0.1 s), by numpy.
#[test]
fn scenes_of_nuscenes_have_categories_and_no_impossible_pose() {
    let root = std::env::var_os("WHYROAD_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let root = root.join("nuscenes_scenarionet");
    if !root.is_dir() {
        crate::require::skipped("recorded", "no recorded data");
        return;
    }
    for (file, classes, unknown_from) in [
        ("nuscenes_0/sd_nuscenes_v1.0-mini_scene-0061.pkl", [14, 5, 2, 2, 3, 3], Some(188)),
        ("nuscenes_0/sd_nuscenes_v1.0-mini_scene-0103.pkl", [59, 1, 0, 0, 2, 5], Some(194)),
        ("nuscenes_1/sd_nuscenes_v1.0-mini_scene-0553.pkl", [22, 3, 2, 0, 0, 1], None),
        ("nuscenes_1/sd_nuscenes_v1.0-mini_scene-0655.pkl", [95, 11, 2, 2, 0, 0], Some(197)),
        ("nuscenes_2/0.pkl", [16, 3, 1, 1, 0, 1], None),
    ] {
        let (sources, _) = find_sources(None, &[root.join(file)]);
        let (drive, report) = whyroad_ingest::read(&sources[0], &Options::default());
        let drive = drive.unwrap();
        let count = |class: ObjectClass| drive.tracks.iter().filter(|t| t.class == class).count();
        let found = [
            ObjectClass::Car,
            ObjectClass::Truck,
            ObjectClass::Bus,
            ObjectClass::LargeVehicle,
            ObjectClass::Motorcycle,
            ObjectClass::Bicycle,
        ];
        assert_eq!(found.map(count), classes, "{file}");
        assert_eq!(count(ObjectClass::Vehicle), 0, "{file}");
        let x = &drive.ego.as_ref().unwrap().motion.x;
        assert_eq!(x.iter().position(|x| x.is_nan()), unknown_from, "{file}");
        assert!(x[unknown_from.unwrap_or(x.len())..].iter().all(|x| x.is_nan()), "{file}");
        assert_eq!(codes(&report).contains(&"ingest.pose.impossible"), unknown_from.is_some(), "{file}");
    }
}
