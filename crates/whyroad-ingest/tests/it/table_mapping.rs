//! Mapping files of the table layout: `examples/table_fleet` is the drive of `examples/table`, written by the same
//! formulas in another fleet's form; and mapping files with one thing wrong each.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{AdapterRef, Options, SourceReport, find_sources_with, formats, table};
use whyroad_model::scene::TurnSignal;
use whyroad_model::{Diagnostic, Drive, Need, ObjectClass};

fn examples(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name)
}

fn format() -> AdapterRef {
    formats::by_name("table").unwrap()
}

fn near(a: &[f64], b: &[f64]) -> bool {
    let same = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6 || (a.is_nan() && b.is_nan());
    a.len() == b.len() && a.iter().zip(b).all(same)
}

fn codes(diagnostics: &[Diagnostic]) -> Vec<&'static str> {
    diagnostics.iter().map(|d| d.code).filter(|c| *c != "ingest.rate.resampled").collect()
}

/// The fleet's drive by a changed mapping.
fn by(change: impl Fn(String) -> String) -> (Option<Drive>, SourceReport) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("m.yaml");
    fs::write(&file, change(fs::read_to_string(examples("table_fleet/fleet.yaml")).unwrap())).unwrap();
    table::read(&examples("table_fleet/following"), &Options::default().with(&table::MAPPING, file))
}

#[test]
fn a_fleets_tables_give_the_drive_of_the_layout() {
    let options = Options::default().with(&table::MAPPING, examples("table_fleet/fleet.yaml"));
    let (sources, problems) = find_sources_with(Some(format()), &[examples("table_fleet")], &options);
    assert!(problems.is_empty() && sources.len() == 1, "{problems:?}");
    let (drive, report) = table::read(&sources[0].path, &options);
    let fleet = drive.unwrap();
    let (layout, _) = table::read(&examples("table/following"), &Options::default());
    let layout = layout.unwrap();
    assert_eq!(codes(&report.diagnostics), ["table.column.unread"], "{:?}", report.diagnostics);
    assert!(report.diagnostics.iter().any(|d| d.message.en.contains("gps_fix")), "{:?}", report.diagnostics);
    assert!(!report.lost_input() && report.tables.iter().all(|t| t.adds_up()));

    assert_eq!((fleet.meta.drive_id.as_str(), &fleet.meta.source), ("following", &layout.meta.source));
    assert_eq!((&fleet.meta.licence, &fleet.meta.place), (&layout.meta.licence, &layout.meta.place));
    assert_eq!(fleet.times, layout.times);
    let (a, b) = (fleet.ego.unwrap(), layout.ego.clone().unwrap());
    assert!(near(&a.motion.x, &b.motion.x) && near(&a.motion.y, &b.motion.y), "positions");
    assert!(near(&a.motion.heading, &b.motion.heading) && near(&a.motion.forward, &b.motion.forward));
    assert!(
        near(&a.bus.speed_mps, &b.bus.speed_mps) && a.bus.brake == b.bus.brake && a.bus.gear == b.bus.gear
    );
    // Not in the layout's example: 10 degrees to the left; the first blinker is 255, which means unknown.
    assert!(a.bus.steering.iter().all(|v| (v - 10.0_f64.to_radians()).abs() < 1e-9));
    assert_eq!((a.bus.turn_signal[0], a.bus.turn_signal[1]), (None, Some(TurnSignal::Off)));

    for (name, theirs, class) in [("car-1", "1", ObjectClass::Car), ("ped-1", "2", ObjectClass::Pedestrian)] {
        let (a, b) = (
            fleet.tracks.iter().find(|t| t.id.as_str() == theirs).unwrap(),
            layout.track(&name.into()).unwrap(),
        );
        assert_eq!((a.class, &a.frames), (class, &b.frames));
        assert!(near(&a.motion.x, &b.motion.x) && near(&a.motion.y, &b.motion.y));
        // The layout's example has its headings with six digits.
        assert!(a.motion.heading.iter().zip(&b.motion.heading).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(near(&a.length_m, &b.length_m) && near(&a.motion.forward, &b.motion.forward));
        assert!(a.motion.forward.iter().all(|v| v.is_finite()));
    }
    let of = |id: &str| fleet.tracks.iter().find(|t| t.id.as_str() == id).unwrap();
    // A width of -1 is unknown; the height is stated for cars alone. The fleet's own class names stay.
    assert!(of("2").width_m.iter().all(|w| w.is_nan()) && of("2").height_m.iter().all(|h| h.is_nan()));
    assert!(of("1").height_m.iter().all(|h| *h == 1.5));
    assert_eq!(of("1").class_at(0), (ObjectClass::Car, "PKW"));

    let (a, b) = (fleet.map.unwrap(), layout.map.unwrap());
    for (a, b) in a.lanes.iter().zip(&b.lanes) {
        let line = |points: &[whyroad_model::road_map::Point3]| {
            points.iter().flat_map(|p| [p.x, p.y]).collect::<Vec<_>>()
        };
        assert!(
            near(&line(&a.center), &line(&b.center)) && near(&line(&a.left), &line(&b.left)),
            "{a:?}, {b:?}"
        );
        assert_eq!((&a.id, &a.left_neighbor), (&b.id, &b.left_neighbor));
    }
    // 50 km/h.
    assert!(a.lanes.len() == 2 && (a.lanes[0].speed_limit_mps.unwrap() - 13.888_888_9).abs() < 1e-6);
    assert!(fleet.lights.is_none() && fleet.meta.missing.contains(&Need::TrafficLights));
}

#[test]
fn mistakes_of_a_mapping_have_their_place_and_a_hint() {
    let cases = [
        (
            "unit: km/h }\n      bus",
            "unit: km/hour }\n      bus",
            "'km/hour' is not a unit",
            "m/s, cm/s, km/h",
        ),
        ("speed_mps: { column: v,", "sped_mps: { column: v,", "unknown field 'sped_mps'", "'speed_mps'"),
        ("axes: north_east_down", "axes: north_east", "'north_east' is unknown", "'north_east_up'"),
        ("classes: { PKW: car", "classes: { PKW: vehicel", "'vehicel' is unknown", "'vehicle'"),
        ("  lanes:", "  lane:", "unknown field 'lane'", "'lanes'"),
        ("unknown: [\"NULL\"]", "unknown: [-1]", "'-1' cannot mean unknown in every column", "unknown: [-1]"),
        ("brake: pedal", "brake: { unit: m }", "needs either 'column' or 'value'", "column:"),
        ("track_id: id", "track_id: { column: id, unit: m }", "has no unit", "delete 'unit'"),
        ("file: \"*_pose.csv\"", "file: ../pose.csv", "not the name of a CSV", "*"),
        ("place: nowhere", "drive_id: x", "unknown field 'drive_id'", "known fields"),
    ];
    for (from, to, message, hint) in cases {
        let (drive, report) = by(|text| {
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1)
        });
        assert!(drive.is_none(), "{to}");
        let d = &report.diagnostics[0];
        assert_eq!(
            (d.code, report.diagnostics.len()),
            ("table.mapping", 1),
            "{to}: {:?}",
            report.diagnostics
        );
        assert!(d.message.en.contains(message) && d.hint.as_ref().unwrap().en.contains(hint), "{to}: {d:?}");
        assert!(d.location.line.is_some_and(|l| l > 1) && d.location.column.is_some(), "{to}: {d:?}");
    }
    // Before anything is looked for.
    let options = Options::default().with(&table::MAPPING, PathBuf::from("no/such/file.yaml"));
    let (sources, problems) = find_sources_with(Some(format()), &[examples("table_fleet")], &options);
    assert!(sources.is_empty() && codes(&problems) == ["table.mapping"], "{problems:?}");
}

#[test]
fn what_a_mapping_names_and_a_drive_lacks_is_unknown_and_reported() {
    let (drive, report) = by(|text| text.replace("column: v_wheels", "column: v_wheel"));
    assert!(drive.is_some_and(|d| d.ego.unwrap().bus.speed_mps.is_empty()));
    assert_eq!(codes(&report.diagnostics), ["table.mapping.absent", "table.column.unread"]);
    assert!(report.diagnostics[0].hint.as_ref().unwrap().en.contains("v_wheels"), "{:?}", report.diagnostics);
    // No file of objects: they are unknown, and the road is not empty.
    let (drive, report) = by(|text| text.replace("*_objects.csv", "*_tracks.csv"));
    assert!(drive.is_some_and(|d| d.meta.missing.contains(&Need::Objects)));
    assert!(codes(&report.diagnostics).contains(&"table.mapping.absent"), "{:?}", report.diagnostics);
    // One folder is one drive.
    let (drive, report) = by(|text| text.replace("*_pose.csv", "*.csv"));
    assert!(drive.is_none() && codes(&report.diagnostics)[0] == "table.mapping.ambiguous");
    // A cell that is no number is reported under the fleet's own name of the column.
    let dir = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(examples("table_fleet/following")).unwrap().flatten() {
        fs::copy(entry.path(), dir.path().join(entry.file_name())).unwrap();
    }
    let edit = |file: &str, from: &str, to: &str| {
        let path = dir.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    };
    edit("2026-01-15_pose.csv", "28,44", "fast");
    let options = Options::default().with(&table::MAPPING, examples("table_fleet/fleet.yaml"));
    let (_, report) = table::read(dir.path(), &options);
    let bad = report.diagnostics.iter().find(|d| d.code == "table.cell.invalid").unwrap();
    assert!(bad.message.en.contains("'v_wheels'") && bad.message.en.contains("'fast'"), "{bad:?}");
    // The folder's own drive file comes before the mapping.
    fs::write(dir.path().join("drive.yaml"), "drive_id: a\nego: { length_m: 6.0 }\n").unwrap();
    let (drive, report) = table::read(dir.path(), &options);
    let drive = drive.unwrap();
    let ego = drive.ego.unwrap();
    assert_eq!((drive.meta.drive_id.as_str(), drive.meta.source.as_str()), ("a", "example-van"));
    assert_eq!((ego.length_m, ego.width_m), (6.0, 2.0), "{:?}", report.diagnostics);
}

/// Without a mapping, a folder of other names is none of the layout.
#[test]
fn a_fleets_folder_is_found_only_with_its_mapping() {
    let (sources, _) = find_sources_with(Some(format()), &[examples("table_fleet")], &Options::default());
    assert!(sources.is_empty());
    assert!(Path::new(&examples("table_fleet/fleet.yaml")).exists());
}

/// Another column, unit and words: the compass, a left-handed simulator, knots and shares in percent. By hand: a car
/// that heads north-west at 10 kn, 3 m north and 4 m east of the origin, turning left by 10 degrees a second.
#[test]
fn units_axes_and_constants_are_those_of_their_definitions() {
    let dir = tempfile::tempdir().unwrap();
    let rows: String = (0..5).map(|k| format!("{},3,4,1,315,10,-10,50,4.8\n", 100 * k)).collect();
    fs::write(dir.path().join("ego.csv"), format!("t,n,e,up,course,knots,rate,gas,x_m\n{rows}")).unwrap();
    let file = dir.path().join("m.yaml");
    let text = "drive: { source: s, ego: { reference_to_centre_m: 0 } }\naxes: AXES\nheadings: clockwise_from_north\n\
        tables: { ego: { columns: { time_s: { column: t, unit: ms }, x_m: n, y_m: e, z_m: up, \
        heading_deg: course, speed_mps: { column: knots, unit: kn }, yaw_rate_radps: { column: rate, unit: deg/s }, \
        throttle: { column: gas, unit: '%' }, bus_speed_mps: { value: 36, unit: km/h } } } }\n";
    for (axes, z) in [("north_east_up", 1.0), ("ned", -1.0)] {
        fs::write(&file, text.replace("AXES", axes)).unwrap();
        let (drive, report) =
            table::read(dir.path(), &Options::default().with(&table::MAPPING, file.clone()));
        let Some(ego) = drive.and_then(|d| d.ego) else { panic!("{:?}", report.diagnostics) };
        let m = &ego.motion;
        assert_eq!((m.x[2], m.y[2], m.z[2]), (4.0, 3.0, z));
        assert!((m.heading[2] - 135.0_f64.to_radians()).abs() < 1e-9);
        assert!((m.yaw_rate[2] - 10.0_f64.to_radians()).abs() < 1e-9, "to the left is positive");
        // 10 kn = 18.52 km/h.
        assert!((m.forward[2] - 18.52 / 3.6).abs() < 1e-9, "{}", m.forward[2]);
        assert_eq!((ego.bus.throttle[2], ego.bus.speed_mps[2]), (0.5, 10.0));
    }
}
