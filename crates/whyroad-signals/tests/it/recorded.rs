//! The recorded AV2 logs: observations in the raw data with Python (positions transformed to the city frame with the
//! recorded poses, points compared with the map's lane polygons) must be reproduced by the signals. Skipped if the data
//! is not present.
use crate::scene::{Table, near};
use std::path::PathBuf;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::Need;
use whyroad_model::Tri::{False, True};

/// The log whose folder begins with `prefix`, and the full id of its track that begins with `track`.
fn log(prefix: &str) -> Option<(whyroad_model::Drive, Table)> {
    let base = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let folder = std::fs::read_dir(base.join("av2/sensor_logs"))
        .ok()
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .find(|p| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with(prefix)));
    let Some(folder) = folder else {
        crate::require::skipped("recorded", "no recorded data");
        return None;
    };
    let (sources, _) = find_sources(None, &[folder]);
    let drive = read(&sources[0], &Options::default()).0.unwrap();
    let table = Table::of(&drive);
    Some((drive, table))
}

fn full_id(table: &Table, prefix: &str) -> String {
    table.0.targets.iter().find(|t| t.id.as_str().starts_with(prefix)).unwrap().id.0.clone()
}

#[test]
fn pittsburgh_3bffdcff_follows_one_car_through_a_bend() {
    let Some((_, t)) = log("3bffdcff") else { return };
    let lead = full_id(&t, "23f72b");
    for i in 0..156 {
        assert_eq!(t.flag(&lead, "target.is_lead", i), True, "frame {i}");
        // It turns with the bend of the junction, 20 to -30 deg in the raw poses, without ever being out of the lane.
        assert_eq!(t.ego_category("ego.lane_change", i), Some("none"));
    }
    // Raw: centers 21.98 m apart at first, 9.72 m at 15.0 s; lengths 4.877 m (ego) and 4.055 m.
    near(t.num(&lead, "target.gap", 0), 21.98 - (4.877 + 4.055) / 2.0, 0.15);
    near(t.num(&lead, "target.gap", 150), 9.72 - (4.877 + 4.055) / 2.0, 0.15);
    for i in 0..156 {
        // The arc is never shorter than the way between the boxes (to the decimeter by which corners project).
        assert!(t.num(&lead, "target.gap", i) >= t.num(&lead, "target.distance", i) - 0.15, "frame {i}");
    }
}

#[test]
fn pittsburgh_adcf7d18_waits_behind_one_car_and_a_bus_comes_in() {
    let Some((_, t)) = log("adcf7d18") else { return };
    let (lead, bus) = (full_id(&t, "f5e7cc"), full_id(&t, "d1cc41"));
    for i in 0..100 {
        assert_eq!(t.flag(&lead, "target.is_lead", i), True, "frame {i}");
    }
    // Stationary until about 5 s; the lead moves off at about 3 s.
    assert_eq!(
        (0..156).find(|&i| t.ego_flag("ego.standstill", i) == False).map(|i| (48..56).contains(&i)),
        Some(true)
    );
    let moves = (0..60).find(|&i| t.flag(&lead, "target.standstill", i) == False).unwrap();
    assert!((24..34).contains(&moves), "{moves}");
    // Raw: the bus's center enters the polygon of the ego's lane between 10.8 and 11.4 s, and stays.
    let enters = (0..156).find(|&i| t.flag(&bus, "target.in_ego_lane", i) == True).unwrap();
    assert!((108..=114).contains(&enters), "{enters}");
    for i in 115..156 {
        assert_eq!(t.flag(&bus, "target.is_lead", i), True, "frame {i}");
    }
    // Its wheels are over the line seconds before, and off it when it has come in.
    assert_eq!(t.flag(&bus, "target.wheel_over_line", 100), True);
    assert_eq!(t.flag(&bus, "target.wheel_over_line", 20), False);
    assert_eq!(t.flag(&bus, "target.large_vehicle", 100), True);
}

#[test]
fn pittsburgh_7fab2350_slows_and_stands_for_pedestrians() {
    let Some((_, t)) = log("7fab2350") else { return };
    let walker = full_id(&t, "de40f6");
    assert!((0..20).map(|i| t.ego("ego.speed", i)).fold(0.0, f64::max) > 10.9);
    for i in 102..=112 {
        assert_eq!(t.ego_flag("ego.standstill", i), True, "frame {i}");
    }
    for i in (20..100).step_by(20) {
        assert!(t.ego("ego.accel", i) < -0.1, "frame {i}");
    }
    // Raw: 8.1 m from the ego's recorded path at 9.9 s, 5.0 m at 15.4 s, nearing at a right angle.
    assert!(t.num(&walker, "target.path_lateral", 95).abs() > 7.0);
    assert!(t.num(&walker, "target.path_lateral", 115).abs() < 7.0);
    assert_eq!(t.category(&walker, "target.relation", 60), Some("crossing"));
    assert!(t.num(&walker, "target.crossing_angle", 90) > 1.2);
    assert_eq!(t.flag(&walker, "target.on_crosswalk", 120), True);
    assert_eq!(t.ego_category("ego.movement", 150), Some("left"));
}

#[test]
fn a_log_without_pose_gives_places_and_says_what_it_lacks() {
    let Some((drive, t)) = log("b87683ae") else { return };
    let track = &drive.tracks[0];
    near(t.num(track.id.as_str(), "target.longitudinal", track.frames[0] as usize), track.motion.x[0], 1e-9);
    assert_eq!(t.0.unavailable["target.ttc"], [Need::EgoPose]);
    assert_eq!(t.0.unavailable["target.on_crosswalk"], [Need::Map]);
}
