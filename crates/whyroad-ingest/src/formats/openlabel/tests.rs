//! A document written by hand: the ego drives north at 10 m/s, boxes in the frames of a lidar, the car and the world.

use super::*;
use serde_json::json;
use whyroad_model::ObjectClass;

fn read_json(v: &Value) -> (Option<Drive>, SourceReport) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.json");
    fs::write(&path, v.to_string()).unwrap();
    assert!(is_openlabel(&path));
    let (drive, report) = read(&path, &Options::default());
    assert!(report.tables.iter().all(RowCount::adds_up), "{:?}", report.tables);
    (drive, report)
}

fn codes(report: &SourceReport) -> Vec<&'static str> {
    report.diagnostics.iter().map(|d| d.code).collect()
}

/// Ten frames of 0.1 s. The car's x axis points north; the lidar is 1 m ahead and 2 m up, looking to the left.
fn document() -> Value {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let frame = |i: usize| {
        let y = i as f64;
        let cuboid = |val: &[f64], system: &str| json!({ "object_data": { "cuboid": [{ "name": "box", "val": val, "coordinate_system": system }] } });
        json!({
            "frame_properties": {
                "timestamp": format!("2024-05-01T10:00:0{:.1}Z", i as f64 / 10.0),
                "transforms": { "vehicle_to_odom": {
                    "src": "vehicle", "dst": "odom",
                    "transform_src_to_dst": { "quaternion": [0.0, 0.0, half, half], "translation": [5.0, y, 0.0] },
                } },
            },
            "objects": {
                // 20 m ahead of the car, 3 m to its left, as heavy as a van.
                "a": cuboid(&[20.0, 3.0, 1.0, 0.0, 0.0, 0.0, 4.5, 1.9, 2.0], "vehicle"),
                // 10 m along the lidar's x axis, which is the car's left: 1 m ahead, 10 m left.
                "b": cuboid(&[10.0, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0, 0.6, 0.6, 1.7], "lidar"),
                "c": cuboid(&[7.0, 8.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.4, 0.8], "odom"),
                "d": cuboid(&[7.0, 8.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.4, 0.8], "elsewhere"),
                "e": { "object_data": { "bbox": [{ "name": "2d", "val": [1, 2, 3, 4] }] } },
            },
        })
    };
    let frames: serde_json::Map<String, Value> = (0..10).map(|i| (i.to_string(), frame(i))).collect();
    json!({ "openlabel": {
        "metadata": { "schema_version": "1.0.0" },
        "coordinate_systems": {
            "odom": { "type": "scene_cs", "parent": "", "children": ["vehicle"] },
            "vehicle": { "type": "local_cs", "parent": "odom", "children": ["lidar"] },
            "lidar": { "type": "sensor_cs", "parent": "vehicle", "children": [], "pose_wrt_parent": {
                "matrix4x4": [0, -1, 0, 1, 1, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1] } },
            "elsewhere": { "type": "sensor_cs", "parent": "vehicle", "children": [] },
        },
        "objects": {
            "a": { "name": "a", "type": "vehicle.car" }, "b": { "name": "b", "type": "Pedestrian" },
            "c": { "name": "c", "type": "dragon" }, "d": { "name": "d", "type": "Car" },
            "e": { "name": "e", "type": "Car" },
        },
        "frames": frames,
    } })
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn boxes_of_all_systems_come_to_the_world() {
    let (drive, report) = read_json(&document());
    assert_eq!(codes(&report), ["openlabel.system.unknown", "openlabel.class"], "{:?}", report.diagnostics);
    let drive = drive.unwrap();
    assert_eq!(drive.times[0], Nanos::parse_iso("2024-05-01T10:00:00Z").unwrap());
    assert_eq!((drive.times.len(), drive.meta.frame_of_reference), (10, FrameOfReference::World));
    let ego = &drive.ego.as_ref().unwrap().motion;
    assert!(near(ego.x[4], 5.0) && near(ego.y[4], 4.0) && near(ego.heading[4], std::f64::consts::FRAC_PI_2));
    // Heading north, ahead is +y and left is -x.
    let car = drive.track(&"a".into()).unwrap();
    assert!(near(car.motion.x[4], 2.0) && near(car.motion.y[4], 24.0) && car.class == ObjectClass::Car);
    assert!(near(car.motion.heading[4], std::f64::consts::FRAC_PI_2) && near(car.length_m[4], 4.5));
    let walker = drive.track(&"b".into()).unwrap();
    assert!(near(walker.motion.x[0], -5.0) && near(walker.motion.y[0], 1.0) && near(walker.motion.z[0], 0.0));
    // The lidar looks to the car's left, that is west.
    assert!(near(walker.motion.heading[0].abs(), std::f64::consts::PI));
    let unknown = drive.track(&"c".into()).unwrap();
    assert!(
        near(unknown.motion.x[9], 7.0)
            && unknown.class == ObjectClass::Unknown
            && unknown.source_class == "dragon"
    );
    let count = &report.tables[0];
    assert_eq!((count.read, count.kept["track"]), (50, 30));
    assert_eq!((count.dropped["unknown_frame"], count.set_aside["no_position"]), (10, 10));
    assert!(drive.meta.missing.contains(&Need::EgoSize) && !drive.meta.missing.contains(&Need::EgoPose));
}

#[test]
fn a_transform_stated_the_other_way_round_is_inverted() {
    let mut v = document();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (i, frame) in v["openlabel"]["frames"].as_object_mut().unwrap().values_mut().enumerate() {
        // World to car: turned by -90 deg, so that (5, y) comes to the origin.
        frame["frame_properties"]["transforms"] = json!({ "t": {
            "src": "odom", "dst": "vehicle",
            "transform_src_to_dst": { "quaternion": [0.0, 0.0, -half, half], "translation": [-(i as f64), 5.0, 0.0] },
        } });
    }
    let drive = read_json(&v).0.unwrap();
    let ego = &drive.ego.as_ref().unwrap().motion;
    assert!(near(ego.x[4], 5.0) && near(ego.y[4], 4.0), "{} {}", ego.x[4], ego.y[4]);
}

#[test]
fn without_poses_positions_stay_relative_to_the_car() {
    let mut v = document();
    let systems = v["openlabel"]["coordinate_systems"].as_object_mut().unwrap();
    systems.remove("odom");
    for (i, frame) in v["openlabel"]["frames"].as_object_mut().unwrap().values_mut().enumerate() {
        frame["frame_properties"] = json!({ "timestamp": i as f64 / 10.0 });
    }
    let (drive, report) = read_json(&v);
    let drive = drive.unwrap();
    assert_eq!(drive.meta.frame_of_reference, FrameOfReference::Ego);
    assert!(drive.ego.is_none() && drive.meta.missing.contains(&Need::EgoPose));
    assert!(near(drive.track(&"a".into()).unwrap().motion.x[3], 20.0));
    assert_eq!(drive.times[0], Options::default().start());
    assert!(drive.meta.missing.contains(&Need::Date), "the start is a default, not a date");
    assert!(codes(&report).contains(&"openlabel.system.unknown"), "the boxes of the world and elsewhere");
}

#[test]
fn our_own_export_is_read() {
    // The layout of `dataset export openlabel`: boxes in the frame of the ego at t0, which is fixed, times from t0.
    let frame = |t: f64| {
        json!({
            "frame_properties": { "timestamp": t, "transforms": { "ego_to_ego_t0": {
                "src": "ego", "dst": "ego_t0",
                "transform_src_to_dst": { "quaternion": [0.0, 0.0, 0.0, 1.0], "translation": [10.0 * t, 0.0, 0.0] },
            } } },
            "objects": { "7": { "object_data": { "cuboid": [{ "name": "box", "coordinate_system": "ego_t0",
                "val": [30.0, 3.5, 0.0, 0.0, 0.0, 0.0, 1.0, 4.5, 1.8, 0.0] }] } } },
        })
    };
    let frames: serde_json::Map<String, Value> =
        (0..5).map(|i| (i.to_string(), frame(-0.2 + f64::from(i) / 10.0))).collect();
    let v = json!({ "openlabel": {
        "metadata": { "schema_version": "1.0.0" },
        "coordinate_systems": {
            "ego_t0": { "type": "scene_cs", "parent": "", "children": ["ego"] },
            "ego": { "type": "local_cs", "parent": "ego_t0", "children": [] },
        },
        "frames": frames,
        "objects": { "7": { "name": "7", "type": "car", "coordinate_system": "ego_t0" } },
        "actions": {}, "contexts": {}, "relations": {},
    } });
    let (drive, report) = read_json(&v);
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    let drive = drive.unwrap();
    let (ego, car) = (&drive.ego.as_ref().unwrap().motion, drive.track(&"7".into()).unwrap());
    assert!(near(ego.x[0], -2.0) && near(ego.x[4], 2.0) && near(car.motion.x[2], 30.0));
    assert!(car.height_m[0].is_nan(), "a height of 0 is not stated");
}

#[test]
fn what_is_not_a_document_or_has_no_times_is_reported() {
    let (drive, report) = read_json(&json!({ "openlabel": { "frames": { "0": {} } } }));
    assert!(drive.is_none() && codes(&report) == ["openlabel.time.missing"]);
    let (drive, report) = read_json(&json!([{ "openlabel": 1 }]));
    assert!(drive.is_none() && codes(&report) == ["openlabel.file.unreadable"]);
    let no_systems =
        json!({ "openlabel": { "frames": { "0": { "frame_properties": { "timestamp": 0 } } } } });
    assert_eq!(codes(&read_json(&no_systems).1), ["openlabel.system.missing"]);
}

/// The usual document of camera and box logs: it names the world's system, and no frame leads to it.
#[test]
fn a_world_without_transforms_is_only_named() {
    let mut v = document();
    for frame in v["openlabel"]["frames"].as_object_mut().unwrap().values_mut() {
        frame["frame_properties"].as_object_mut().unwrap().remove("transforms");
        frame["objects"].as_object_mut().unwrap().retain(|id, _| id == "a");
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.json");
    // As editors on Windows save it: with a byte order mark.
    fs::write(&path, format!("\u{feff}{v}")).unwrap();
    let (drive, report) = read(&path, &Options::default());
    let drive = drive.unwrap();
    assert!(report.tables[0].dropped_total() == 0, "{:?}", report.tables);
    assert_eq!(drive.meta.frame_of_reference, FrameOfReference::Ego);
    assert!(near(drive.track(&"a".into()).unwrap().motion.x[3], 20.0) && drive.ego.is_none());
}

/// A date without an offset from UTC is a time that nobody can place, not an absent one.
#[test]
fn a_date_without_an_offset_is_named() {
    let mut v = document();
    for frame in v["openlabel"]["frames"].as_object_mut().unwrap().values_mut() {
        frame["frame_properties"]["timestamp"] = json!("2024-05-01T10:00:00");
    }
    let (drive, report) = read_json(&v);
    assert!(drive.is_none() && codes(&report) == ["openlabel.time.missing"]);
    let d = &report.diagnostics[0];
    assert!(
        d.message.en.contains("not understood (for example \"2024-05-01T10:00:00\")"),
        "{}",
        d.message.en
    );
    assert!(d.hint.as_ref().unwrap().en.contains("offset from UTC"));
}

/// The standard lets static objects have their box at the document instead of in each frame.
#[test]
fn boxes_of_the_document_itself_are_counted() {
    let mut v = document();
    let cuboid = v["openlabel"]["frames"]["0"]["objects"]["c"]["object_data"].clone();
    v["openlabel"]["objects"]["99"] = json!({ "name": "99", "type": "Car", "object_data": cuboid });
    let count = &read_json(&v).1.tables[0];
    assert_eq!((count.read, count.set_aside["static_box"]), (51, 1));
}
