//! A nuScenes set written by the published schema and loaded by nuScenes' own devkit 1.2
//! (`tests/fixtures/nuscenes/make.py`); expected values are that script's closed form and what the devkit printed.
#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, SourceReport, find_sources, nuscenes};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::road_map::LaneMark;
use whyroad_model::scene::TurnSignal;
use whyroad_model::{Drive, ObjectClass};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/nuscenes")
}

fn first() -> (Drive, SourceReport) {
    let (drive, report) = nuscenes::read(&fixtures().join("v1.0-byhand"), 0, &Options::default());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive.unwrap(), report)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn each_scene_is_a_drive_with_its_own_rows_only() {
    let (sources, problems) = find_sources(None, &[fixtures()]);
    assert!(
        crate::only_skipped(&problems) && sources.iter().all(|s| s.format() == "nuscenes"),
        "{sources:?}"
    );
    let drives: Vec<Drive> =
        sources.iter().map(|s| whyroad_ingest::read(s, &Options::default()).0.unwrap()).collect();
    let ids: Vec<_> =
        drives.iter().map(|d| (d.meta.drive_id.as_str(), d.times.len(), d.tracks.len())).collect();
    assert_eq!(ids, [("scene-0001", 21, 2), ("scene-0002", 6, 1)]);
    assert_eq!(drives[1].tracks[0].class, ObjectClass::Bus);
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let outcome = || whyroad_ingest::ingest(&sources[0], &Options::default(), &lake).outcome;
    assert_eq!((outcome(), outcome()), (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged)));
}

#[test]
fn scenes_read_together_are_what_each_is_alone() {
    let set = fixtures().join("v1.0-byhand");
    let mut together = Vec::new();
    // Scene 7 is not in the set: it is told of, and the others are there.
    nuscenes::read_several(&set, &[1, 7, 0], &Options::default(), &mut |drive, report| {
        together.push((drive.map(|d| (d.meta, d.tracks)), report));
    });
    for ((drive, report), index) in together.iter().zip([1, 7, 0]) {
        let (alone, said) = nuscenes::read(&set, index, &Options::default());
        assert_eq!(drive.is_some(), index != 7);
        let alone = alone.map(|d| (d.meta, d.tracks));
        assert_eq!(format!("{drive:?} {report:?}"), format!("{alone:?} {said:?}"));
    }
    let sources = find_sources(None, &[fixtures()]).0;
    assert_eq!(whyroad_ingest::batches(&sources).map(<[_]>::len).collect::<Vec<_>>(), [2]);
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let mut outcomes = Vec::new();
    let mut ingest = || {
        whyroad_ingest::ingest_each(&sources, &Options::default(), &lake, &mut |r| outcomes.push(r.outcome));
    };
    ingest();
    ingest();
    let (new, old) = (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged));
    assert_eq!(outcomes, [new, new, old, old]);
}

#[test]
fn the_ego_is_the_middle_of_the_car_at_the_frames() {
    let (drive, report) = first();
    let drive = crate::estimated(drive);
    let ego = drive.ego.as_ref().unwrap();
    assert_eq!(drive.times[0].0, 1_533_151_603_500_000_000);
    // The rear axle is at 600 + 10 t, the middle 1.385 m ahead.
    for (i, x) in ego.motion.x.iter().enumerate() {
        assert!(
            near(*x, 601.385 + i as f64) && near(ego.motion.vx[i], 10.0) && ego.motion.accel[i].abs() < 1e-6
        );
    }
    let codes: Vec<_> = report.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["ingest.rate.resampled"]);
}

#[test]
fn objects_are_interpolated_between_keyframes_and_not_over_a_missing_one() {
    let (read, report) = first();
    let drive = crate::estimated(read.clone());
    let car = drive.tracks.iter().find(|t| t.class == ObjectClass::Car).unwrap();
    // x = 620 + 5 t and heading 3.0 + 0.4 t, over pi from frame 4 on.
    assert_eq!(car.frames.len(), 21);
    for i in 0..21 {
        let heading = 3.0 + 0.04 * i as f64;
        let wrapped = if heading > TAU / 2.0 { heading - TAU } else { heading };
        assert!(near(car.motion.x[i], 620.0 + 0.5 * i as f64) && near(car.motion.heading[i], wrapped), "{i}");
        assert!(near(car.motion.vx[i], 5.0) && near(car.motion.yaw_rate[i], 0.4));
    }
    assert!(near(car.length_m[0], 4.5) && near(car.width_m[0], 1.9) && near(car.interior_points[5], 20.0));
    let walker = drive.tracks.iter().find(|t| t.class == ObjectClass::Pedestrian).unwrap();
    // Annotated at 0, 0.5, 1.5 and 2 s.
    let annotated = read.track(&walker.id).unwrap();
    assert_eq!(annotated.frames, [0, 1, 2, 3, 4, 5, 15, 16, 17, 18, 19, 20]);
    // The devkit's box_velocity at each of its four keyframes: 1.5 m/s along y.
    assert!(walker.motion.vy.iter().all(|v| near(*v, 1.5)) && near(walker.motion.heading[0], FRAC_PI_2));
    let rows = report.tables.iter().find(|t| t.table == "annotations").unwrap();
    assert_eq!((rows.read, rows.kept["track"]), (9, 9));
}

#[test]
fn the_bus_tells_what_its_readme_says() {
    let bus = first().0.ego.unwrap().bus;
    // 36 km/h; 250 of 1000; pedal from message 3 (1.52 s); left signal from message 2 (1.02 s); gear 7 is driving.
    assert!(bus.speed_mps.iter().all(|v| near(*v, 10.0)) && bus.throttle.iter().all(|v| near(*v, 0.25)));
    assert_eq!([bus.brake[15], bus.brake[16]], [Some(false), Some(true)]);
    assert_eq!([bus.turn_signal[10], bus.turn_signal[11]], [Some(TurnSignal::Off), Some(TurnSignal::Left)]);
    assert!(bus.gear.iter().all(|g| *g == Some('D')));
    // The file's right-positive -0.1 rad/s is a turn to the left: 0.1 rad after a second.
    assert!(near(bus.steering[10], 0.1), "{:?}", bus.steering);
}

#[test]
fn lanes_come_from_their_arc_lines_and_far_ones_stay_away() {
    let (drive, _) = first();
    let map = drive.map.unwrap();
    assert_eq!(map.lanes.iter().map(|l| l.id.as_str()).collect::<Vec<_>>(), ["lane-a", "turn-b"]);
    let lane = map.lane("lane-a").unwrap();
    assert!(lane.left.iter().all(|p| near(p.y, 1601.8)) && lane.right.iter().all(|p| near(p.y, 1598.2)));
    assert_eq!((lane.left_mark, lane.right_mark), (LaneMark::DoubleSolid, LaneMark::Dashed));
    assert!(near(lane.width_m.unwrap(), 3.6) && lane.successors == ["turn-b"]);
    let turn = map.lane("turn-b").unwrap();
    // Ends where the devkit's discretize_lane does; half way it is on the circle around (630, 1616) of 16 m.
    let end = turn.center[turn.center.len() - 1];
    assert!(turn.in_junction && near(end.x, 646.0) && near(end.y, 1616.0), "{end:?}");
    assert!(turn.center.iter().all(|p| near((p.x - 630.0).hypot(p.y - 1616.0), 16.0)));
    assert_eq!((map.crosswalks.len(), map.junctions.len()), (1, 1));
    let stop = &map.stop_lines[0];
    assert!(
        stop.lane_ids == ["lane-a"] && near(stop.line[0].y, 1601.8) && near(stop.line[1].y, 1598.2),
        "{stop:?}"
    );
}

#[test]
fn pictures_are_named_with_their_times_and_a_missing_table_is_told() {
    let (drive, _) = first();
    let media = drive.media.unwrap();
    assert!(media.len() == 5 && media[1].camera == "CAM_FRONT" && media[1].time == drive.times[5]);
    let dir = tempfile::tempdir().unwrap();
    for table in ["scene", "sample", "sample_annotation", "log"] {
        let name = format!("{table}.json");
        std::fs::copy(fixtures().join("v1.0-byhand").join(&name), dir.path().join(&name)).unwrap();
    }
    let (drive, report) = nuscenes::read(dir.path(), 0, &Options::default());
    assert!(drive.is_none() && report.diagnostics[0].code == "nuscenes.table.unreadable");
    assert!(report.diagnostics[0].location.file.as_ref().unwrap().ends_with("category.json"));
}

/// A copy of the set with the first timestamp of `table` replaced.
fn with_timestamp(table: &str, value: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(fixtures().join("v1.0-byhand")).unwrap().map(Result::unwrap) {
        let mut text = std::fs::read_to_string(entry.path()).unwrap();
        if entry.file_name() == table {
            let at = text.find("\"timestamp\":").unwrap() + "\"timestamp\":".len();
            let end = at + text[at..].find([',', '}']).unwrap();
            text.replace_range(at..end, value);
        }
        std::fs::write(dir.path().join(entry.file_name()), text).unwrap();
    }
    dir
}

/// Frames would be made for the whole time in between: 54 years, 122 GB.
#[test]
fn a_timestamp_of_zero_makes_no_millions_of_frames() {
    let reference = first().0.times.len();
    for (table, value) in ["sample.json", "ego_pose.json", "sample_data.json"]
        .into_iter()
        .flat_map(|t| ["0", "-9000000000000000000", "9000000000000000000"].map(|v| (t, v)))
    {
        let dir = with_timestamp(table, value);
        let (drive, report) = nuscenes::read(dir.path(), 0, &Options::default());
        let codes: Vec<_> = report.diagnostics.iter().map(|d| d.code).collect();
        match drive {
            None => assert!(codes.contains(&"ingest.time.span"), "{table} {value}: {codes:?}"),
            Some(drive) => assert!(drive.times.len() <= reference, "{table} {value}"),
        }
        assert!(table != "sample.json" || codes.contains(&"ingest.time.span"), "{value}: {codes:?}");
    }
}

/// Microseconds that fit into 64 bits, and nanoseconds that do not: 292,000 years.
#[test]
fn timestamps_that_are_too_great_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(fixtures().join("v1.0-byhand")).unwrap().map(Result::unwrap) {
        let text = std::fs::read_to_string(entry.path()).unwrap();
        let mut changed = String::new();
        for part in text.split_inclusive("\"timestamp\":") {
            let end = part.find(|c: char| !c.is_ascii_digit()).unwrap();
            let time = part[..end].parse::<i64>().map(|t| (t + 9_200_000_000_000_000_000).to_string());
            changed += &(time.unwrap_or_else(|_| part[..end].to_owned()) + &part[end..]);
        }
        std::fs::write(dir.path().join(entry.file_name()), changed).unwrap();
    }
    let (drive, report) = nuscenes::read(dir.path(), 0, &Options::default());
    let codes: Vec<_> = report.diagnostics.iter().map(|d| d.code).collect();
    assert!(drive.is_none() && codes == ["nuscenes.table.unreadable"], "{codes:?}");
}

#[test]
fn timestamps_may_be_integers_floats_or_texts() {
    let reference = first().0;
    for form in ["{}.0", "{}e0", "\"{}\"", "\"{}.0\""] {
        let dir = tempfile::tempdir().unwrap();
        let set = dir.path().join("v1.0-byhand");
        std::fs::create_dir(&set).unwrap();
        for entry in std::fs::read_dir(fixtures().join("v1.0-byhand")).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            let mut parts = text.split("\"timestamp\":");
            let mut changed = parts.next().unwrap().to_owned();
            for part in parts {
                let part = part.trim_start();
                let end = part.find(|c: char| !c.is_ascii_digit()).unwrap();
                changed += &format!("\"timestamp\": {}{}", form.replace("{}", &part[..end]), &part[end..]);
            }
            std::fs::write(set.join(path.file_name().unwrap()), changed).unwrap();
        }
        let (drive, report) = nuscenes::read(&set, 0, &Options::default());
        let drive = drive.unwrap_or_else(|| panic!("{form}: {:?}", report.diagnostics));
        assert_eq!(drive.times, reference.times, "{form}");
        assert_eq!(format!("{:?}", drive.tracks), format!("{:?}", reference.tracks), "{form}");
    }
}
