//! Other ways into the SUMO adapter: CSV, compressed files, several egos, a sensor's range and line of sight, and what
//! a network has beside lanes. Fixtures are made by others: the CSV by SUMO's `xml2csv.py` from `crossroads.fcd.xml`,
//! the compressed files by Python's `lzma` and by `zstd`. Geometry is worked out by hand beside each test.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::sumo::{EGO, EGO_SHARE, NET, OCCLUSION, SEED, SENSOR_RANGE, TYPES};
use whyroad_ingest::{AdapterRef, OptionValue, Options, SourceReport, find_sources, sumo};
use whyroad_model::Drive;
use whyroad_model::road_map::{LaneKind, Point3};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// A log of cars that drive east; each is `(id, type, x of the front bumper at 0 s, y, speed)`.
fn log(dir: &Path, cars: &[(&str, &str, f64, f64, f64)]) -> PathBuf {
    let mut text = String::from("<fcd-export>\n");
    for i in 0..20 {
        let t = f64::from(i) / 10.0;
        text += &format!("<timestep time=\"{t:.2}\">\n");
        for (id, kind, x, y, v) in cars {
            let x = x + v * t;
            text += &format!(
                r#"<vehicle id="{id}" x="{x:.2}" y="{y:.2}" angle="90" type="{kind}" speed="{v}"/>"#
            );
        }
        text += "</timestep>\n";
    }
    let file = dir.join("fcd.xml");
    fs::write(&file, text + "</fcd-export>\n").unwrap();
    file
}

const CAR: &str = "DEFAULT_VEHTYPE";

fn all(file: &Path, options: &Options) -> Vec<(Option<Drive>, SourceReport)> {
    let mut found = Vec::new();
    sumo::read_each(file, options, &mut |drive, report| {
        assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
        found.push((drive, report));
    });
    found
}

#[test]
fn csv_and_compressed_files_are_the_same_log() {
    let options = || {
        Options::default()
            .with(&NET, fixtures().join("crossroads.net.xml"))
            .with(&TYPES, fixtures().join("crossroads.rou.xml"))
    };
    let plain = sumo::read(&fixtures().join("crossroads.fcd.xml"), &options()).0.unwrap();
    let dir = tempfile::tempdir().unwrap();
    let table = fs::read_to_string(fixtures().join("crossroads_table.fcd.csv")).unwrap();
    // The plain header of `--output.column-header plain`, with commas; only vehicles have such a one.
    let rows = table
        .lines()
        .filter(|l| !l.contains("walker"))
        .map(|l| l.replace("vehicle_", "").replace("timestep_", ""));
    fs::write(dir.path().join("fcd.csv"), rows.map(|l| l.replace(';', ",") + "\n").collect::<String>())
        .unwrap();
    let files = [
        fixtures().join("crossroads_table.fcd.csv"),
        fixtures().join("compressed/crossroads.fcd.xml.xz"),
        fixtures().join("compressed/crossroads.fcd.xml.zst"),
    ];
    for file in files {
        let (drive, report) = sumo::read(&file, &options());
        let drive = drive.unwrap_or_else(|| panic!("{file:?}: {:?}", report.diagnostics));
        assert_eq!(drive.times, plain.times, "{file:?}");
        assert_eq!(format!("{:?}", drive.ego), format!("{:?}", plain.ego), "{file:?}");
        assert_eq!(format!("{:?}", drive.tracks), format!("{:?}", plain.tracks), "{file:?}");
    }
    let (drive, _) = sumo::read(&dir.path().join("fcd.csv"), &options());
    assert_eq!(format!("{:?}", drive.unwrap().ego), format!("{:?}", plain.ego));
}

#[test]
fn logs_are_found_by_name_and_other_csv_is_not() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["a.fcd.csv", "b_fcd.xml.xz", "fcd.csv.zst", "tripinfo.csv", "net.xml"] {
        fs::write(dir.path().join(name), "").unwrap();
    }
    let (sources, _) = find_sources(Some(AdapterRef(&sumo::Sumo)), &[dir.path().to_owned()]);
    let names: Vec<_> =
        sources.iter().map(|s| s.path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(names, ["a.fcd.csv", "b_fcd.xml.xz", "fcd.csv.zst"]);
}

#[test]
fn a_csv_that_breaks_off_keeps_what_it_has() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("fcd.csv");
    let head = "timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle\n";
    fs::write(&file, format!("{head}0.0;ego;1;0;90\n0.1;ego;2;0;90\n0.2;ego;3")).unwrap();
    let (drive, report) = sumo::read(&file, &Options::default());
    assert_eq!(drive.unwrap().frame_count(), 2);
    assert!(report.diagnostics.iter().any(|d| d.code == "sumo.fcd.broken") && report.lost_input());
}

#[test]
fn each_ego_is_a_drive_and_the_others_are_its_tracks() {
    let dir = tempfile::tempdir().unwrap();
    let file = log(
        dir.path(),
        &[("a", CAR, 0.0, 0.0, 10.0), ("b", CAR, 30.0, 0.0, 8.0), ("c", CAR, 60.0, 0.0, 8.0)],
    );
    let named = Options::default().with(&EGO, "b").with(&EGO, "nobody").with(&EGO, "a");
    let found = all(&file, &named);
    assert_eq!(found.len(), 3);
    let drive = found[0].0.as_ref().unwrap();
    assert!(drive.meta.drive_id.as_str().ends_with("-b"), "{}", drive.meta.drive_id);
    assert_eq!(drive.tracks.iter().map(|t| t.id.as_str()).collect::<Vec<_>>(), ["a", "c"]);
    // b's front bumper is at 30 m, its center half of 5 m behind.
    assert_eq!(drive.ego.as_ref().unwrap().motion.x[0], 27.5);
    assert!(found[1].0.is_none() && found[1].1.diagnostics.iter().any(|d| d.code == "sumo.ego.missing"));
    let other = found[2].0.as_ref().unwrap();
    assert_ne!(other.meta.content_hash, drive.meta.content_hash);

    let share =
        |share: f64, seed: u64| all(&file, &Options::default().with(&EGO_SHARE, share).with(&SEED, seed));
    assert_eq!(share(1.0, 3).len(), 3);
    let none = share(0.0, 3);
    assert!(
        none.len() == 1
            && none[0].0.is_none()
            && none[0].1.diagnostics.iter().any(|d| d.code == "sumo.ego.none_drawn")
    );
}

#[test]
fn a_share_draws_motor_vehicles_only_and_the_same_ones_again() {
    let dir = tempfile::tempdir().unwrap();
    let ids: Vec<String> = (0..200).map(|i| format!("v{i}")).collect();
    let cars: Vec<_> = ids
        .iter()
        .enumerate()
        .map(|(i, id)| {
            (id.as_str(), if i % 2 == 0 { CAR } else { "DEFAULT_BIKETYPE" }, 10.0 * i as f64, 0.0, 5.0)
        })
        .collect();
    let file = log(dir.path(), &cars);
    let drawn = |seed| -> Vec<String> {
        let found = all(&file, &Options::default().with(&EGO_SHARE, 0.3).with(&SEED, seed));
        found.iter().filter_map(|(d, _)| Some(d.as_ref()?.meta.drive_id.to_string())).collect()
    };
    let first = drawn(1);
    // 100 cars at 0.3: 30 expected, deviation 4.6.
    assert!((15..=45).contains(&first.len()), "{}", first.len());
    assert!(first == drawn(1) && first != drawn(2));
    let even = |id: &String| id.rsplit('v').next().unwrap().parse::<usize>().unwrap() % 2 == 0;
    assert!(first.iter().all(even), "a bicycle was drawn: {first:?}");
}

#[test]
fn the_sensor_sees_so_far() {
    let dir = tempfile::tempdir().unwrap();
    // The gap of centers grows from 79 m by 1 m/s: over 80 m from 1.1 s on, so 11 of 20 frames are within.
    let file = log(
        dir.path(),
        &[("ego", CAR, 0.0, 0.0, 10.0), ("fast", CAR, 79.0, 0.0, 11.0), ("far", CAR, 200.0, 0.0, 10.0)],
    );
    let (drive, report) = all(&file, &Options::default().with(&SENSOR_RANGE, 80.0)).remove(0);
    let drive = drive.unwrap();
    assert_eq!(
        drive.tracks.iter().map(|t| (t.id.as_str(), t.frames.len())).collect::<Vec<_>>(),
        [("fast", 11)]
    );
    assert_eq!(report.tables[0].set_aside.get("out_of_range"), Some(&(9 + 20)));
    assert!(drive.tracks[0].interior_points.iter().all(|p| p.is_nan()), "nothing is said of sight");
}

#[test]
fn vehicles_hide_what_is_behind_them() {
    let dir = tempfile::tempdir().unwrap();
    let cars = [
        ("ego", CAR, 0.0, 0.0, 10.0),
        // 20 m ahead, straight behind it one of the same width, and one a lane to the left.
        ("near", CAR, 20.0, 0.0, 10.0),
        ("behind", CAR, 40.0, 0.0, 10.0),
        ("left", CAR, 40.0, 3.2, 10.0),
        // Behind the ego, one whose edge lies on the line y = 0 (cars are 1.8 m wide) and so hides half of the last.
        ("shade", CAR, -10.0, -0.9, 10.0),
        ("half", CAR, -30.0, 0.0, 10.0),
    ];
    let options = Options::default().with(&OCCLUSION, OptionValue::Flag);
    let file = log(dir.path(), &cars);
    let (drive, report) = all(&file, &options).remove(0);
    let drive = drive.unwrap();
    let seen = |id: &str| drive.tracks.iter().find(|t| t.id.as_str() == id).map(|t| t.interior_points[0]);
    assert_eq!((seen("near"), seen("behind"), seen("left")), (Some(100.0), None, Some(100.0)));
    assert_eq!(report.tables[0].set_aside.get("hidden"), Some(&20));
    assert_eq!((seen("shade"), seen("half")), (Some(100.0), Some(50.0)));
    let half = drive.track(&"half".into()).unwrap();
    assert_eq!((half.visible_share[0], &half.occluder[0]), (0.5, &Some("shade".into())));
    let near = drive.track(&"near".into()).unwrap();
    assert!(near.visible_share.iter().all(|s| *s == 1.0) && near.occluder.is_empty());
    assert!(
        drive
            .tracks
            .iter()
            .all(|t| t.motion.len() == t.frames.len() && t.turn_signal.len() <= t.frames.len())
    );
}

#[test]
fn a_roundabout_is_a_facility_and_closed_lanes_have_their_users() {
    let dir = tempfile::tempdir().unwrap();
    // A square ring driven counter-clockwise, lanes 4 m wide around (0, 0) at 20 m: its outer edge is at 22 m.
    let corners = [("a", 20, -20), ("b", 20, 20), ("c", -20, 20), ("d", -20, -20)];
    let mut net = String::from("<net>\n");
    for i in 0..4 {
        let ((from, x0, y0), (to, x1, y1)) = (corners[i], corners[(i + 1) % 4]);
        net += &format!(
            r#"<edge id="{from}{to}" from="{from}" to="{to}"><lane id="{from}{to}_0" index="0" speed="8.33" length="40" width="4" shape="{x0},{y0},1 {x1},{y1},3"/></edge>"#
        );
        net += "\n";
    }
    net += r#"<edge id="s" from="d" to="a"><lane id="s_0" disallow="passenger private truck" speed="13.89" shape="0,50 50,50"/><lane id="s_1" disallow="all" shape="0,54 50,54"/></edge>
<roundabout nodes="a b c d" edges="da bc ab cd"/></net>"#;
    fs::write(dir.path().join("net.xml"), net).unwrap();
    let file = log(dir.path(), &[("ego", CAR, 20.0, 0.0, 1.0)]);
    let map = all(&file, &Options::default()).remove(0).0.unwrap().map.unwrap();
    let ring = &map.facilities[0];
    assert_eq!(
        (ring.kind.as_str(), ring.id.as_str(), map.facilities.len()),
        ("roundabout", "roundabout_ab", 1)
    );
    let area: f64 = ring.boundary.windows(2).map(|w| w[0].x * w[1].y - w[1].x * w[0].y).sum::<f64>() / 2.0;
    // Four outer edges of 40 m at 22 m; the corners between them are cut: 44 x 44 m less four triangles of 2 x 2 / 2.
    assert!((area - (44.0 * 44.0 - 4.0 * 2.0)).abs() < 1e-6, "{area}");
    assert_eq!(map.lane("s_0").unwrap().kind, LaneKind::Bus);
    assert!(map.lane("s_1").is_none());
    let lane = map.lane("ab_0").unwrap();
    assert_eq!(lane.speed_limit_mps, Some(8.33));
    // The grade: 2 m of height over 40 m.
    assert_eq!((lane.center[0].z, lane.center[1].z), (1.0, 3.0));
}

#[test]
fn a_ring_of_two_lanes_driven_clockwise_reaches_to_its_outer_edge() {
    let dir = tempfile::tempdir().unwrap();
    // Traffic on the left: lanes are counted from the left, so that lane 0 at 20 m is the outer one, lane 1 at 16 m the
    // inner one.
    let at = |name: &str, r: i32| match name {
        "a" => (r, -r),
        "b" => (-r, -r),
        "c" => (-r, r),
        _ => (r, r),
    };
    let names = ["a", "b", "c", "d"];
    let mut net = String::from("<net lefthand=\"true\">\n");
    for i in 0..4 {
        let (from, to) = (names[i], names[(i + 1) % 4]);
        net += &format!(r#"<edge id="{from}{to}" from="{from}" to="{to}">"#);
        for (lane, r) in [(0, 20), (1, 16)] {
            let ((x0, y0), (x1, y1)) = (at(from, r), at(to, r));
            net += &format!(
                r#"<lane id="{from}{to}_{lane}" index="{lane}" speed="8.33" length="40" width="4" shape="{x0},{y0} {x1},{y1}"/>"#
            );
        }
        net += "</edge>\n";
    }
    net += r#"<roundabout nodes="a b c d" edges="ab bc cd da"/></net>"#;
    fs::write(dir.path().join("net.xml"), net).unwrap();
    let file = log(dir.path(), &[("ego", CAR, 20.0, 0.0, 1.0)]);
    let map = all(&file, &Options::default()).remove(0).0.unwrap().map.unwrap();
    let area = &map.facilities.iter().find(|f| f.kind == "roundabout").unwrap().boundary;
    // The outer edge is at 22 m, that of the inner lane at 18 m.
    assert!(within(area, Point3 { x: 21.5, y: 0.1, z: 0.0 }));
    assert!(!within(area, Point3 { x: 22.5, y: 0.1, z: 0.0 }));
}

/// Crossings of a ray to the east with the outline: odd inside.
fn within(outline: &[Point3], p: Point3) -> bool {
    let crosses = |w: &&[Point3]| {
        let (a, b) = (w[0], w[1]);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    outline.windows(2).filter(crosses).count() % 2 == 1
}

#[test]
fn a_roundabout_reaches_to_the_give_way_lines() {
    // A ring of four arms by netconvert: a road's lanes end at its give-way line and begin where the exit's mouth ends.
    let dir = tempfile::tempdir().unwrap();
    let net = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth/traffic/seen-ring/net.xml.gz");
    let options = Options::default().with(&NET, net);
    let file = log(dir.path(), &[("ego", CAR, 100.0, 4.95, 1.0)]);
    let map = all(&file, &options).remove(0).0.unwrap().map.unwrap();
    let area = &map.facilities.iter().find(|f| f.kind == "roundabout").unwrap().boundary;
    let between = |a: Point3, b: Point3, m: f64| {
        let f = m / (b.x - a.x).hypot(b.y - a.y);
        Point3 { x: a.x + f * (b.x - a.x), y: a.y + f * (b.y - a.y), z: 0.0 }
    };
    let (mut arms, mut inside) = (0, 0);
    for lane in &map.lanes {
        let (first, last) = (&lane.center[..2], &lane.center[lane.center.len() - 2..]);
        if lane.id.starts_with("ring") || lane.id.starts_with(':') {
            let midst = lane.center.iter().skip(1).take(lane.center.len().saturating_sub(2));
            assert!(midst.clone().all(|p| within(area, *p)), "{}", lane.id);
            inside += midst.count();
        } else if lane.id.starts_with('o') {
            // Half a meter before and beyond the line.
            assert!(!within(area, between(last[1], last[0], 0.5)), "{}", lane.id);
            assert!(within(area, between(last[1], last[0], -0.5)), "{}", lane.id);
            arms += 1;
        } else {
            assert!(within(area, between(first[0], first[1], -0.5)), "{}", lane.id);
            assert!(!within(area, between(first[0], first[1], 0.5)), "{}", lane.id);
            arms += 1;
        }
    }
    assert!(arms >= 8 && inside > 50, "{arms} {inside}");
}
