//! From files: two recordings that are equal up to a moment give identical Stage I content at that moment, whatever
//! comes later. The service shows the drive cut at the keyframe, estimated, and its signals; that is what is compared.

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_ipc::writer::FileWriter;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use whyroad_engine::recordings::LakeRecordings;
use whyroad_ingest::{Options, find_sources, ingest};
use whyroad_lake::Lake;
use whyroad_model::DriveId;

/// Writes recordings of two kinds, ingests them, and gives what Stage I would show of the drive at `keyframe_s` after
/// its start.
fn stage_one(dir: &Path, keyframe_s: f64) -> String {
    let lake_dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(lake_dir.path()).unwrap();
    let (sources, problems) = find_sources(None, &[dir.to_owned()]);
    assert!(sources.len() == 1, "{problems:?}");
    let options = Options::default().with_drive_id(DriveId::from("d"));
    let report = ingest(&sources[0], &options, &lake);
    assert!(report.outcome.is_some(), "{:?}", report.diagnostics);
    let recordings = LakeRecordings::open(lake, &[], &[]).unwrap();
    let whole = recordings.drive(&DriveId::from("d")).unwrap();
    let cut = Arc::new(whole.until(whole.times[0].plus_secs(keyframe_s + 1e-6)));
    let (signals, shown) = (recordings.signals(&cut), recordings.estimated(&cut));
    assert!(signals.frame_columns.contains_key("ego.accel"));
    let mut out = String::new();
    write!(out, "{shown:?}\n{signals:?}").unwrap();
    out
}

/// What happens after the moment in question.
#[derive(Clone, Copy, PartialEq)]
enum Future {
    Steady,
    /// The ego and the object brake, the object turns out to be a truck, the brake light goes on, it rains.
    Eventful,
    /// The recording ends there.
    None,
}

/// A drive in the table layout: the ego every `ego_step` s, an object every `object_step` s; equal up to `same_s`.
fn table(dir: &Path, (ego_step, object_step): (f64, f64), same_s: f64, future: Future) {
    let eventful = |t: f64| future == Future::Eventful && t > same_s + 1e-9;
    let there = |t: f64| future != Future::None || t <= same_s + 1e-9;
    let x = |t: f64| 10.0 * t - if eventful(t) { 3.0 * (t - same_s).powi(2) } else { 0.0 };
    let mut ego = "time_s,x_m,y_m,heading_rad,steering_rad,brake\n".to_owned();
    for i in 0.. {
        let t = f64::from(i) * ego_step;
        if t > 6.0 {
            break;
        }
        if there(t) {
            let brake = if eventful(t) { "true" } else { "" };
            writeln!(ego, "{t:.3},{:.6},0,0,{},{brake}", x(t), 0.01 * x(t)).unwrap();
        }
    }
    let mut objects = "time_s,track_id,class,x_m,y_m,heading_rad,length_m,width_m,height_m\n".to_owned();
    for i in 0.. {
        let t = f64::from(i) * object_step;
        if t > 6.0 {
            break;
        }
        if there(t) {
            let class = if eventful(t) {
                "truck"
            } else if t < 1.0 {
                "unknown"
            } else {
                "car"
            };
            writeln!(objects, "{t:.3},a,{class},{:.6},0,0,4.5,1.8,1.5", 25.0 + x(t)).unwrap();
        }
    }
    let mut context = "time_s,kind,value\n".to_owned();
    if eventful(6.0) {
        writeln!(context, "{:.3},weather,rain", same_s + 0.5).unwrap();
    }
    fs::write(
        dir.join("drive.json"),
        r#"{"source": "test",
        "ego": {"length_m": 4.8, "width_m": 1.9, "height_m": 1.5, "reference_to_centre_m": 0}}"#,
    )
    .unwrap();
    fs::write(dir.join("ego.csv"), ego).unwrap();
    fs::write(dir.join("objects.csv"), objects).unwrap();
    fs::write(dir.join("context.csv"), context).unwrap();
}

/// Every keyframe from 1 s on gives the same content for both futures, and another one once they differ.
fn assert_blind(write: impl Fn(&Path, f64, Future)) {
    for same_s in [1.0, 2.3, 3.0] {
        let of = |future| {
            let dir = tempfile::tempdir().unwrap();
            let log = dir.path().join("log");
            fs::create_dir(&log).unwrap();
            write(&log, same_s, future);
            (stage_one(&log, same_s), stage_one(&log, same_s + 1.0))
        };
        let (steady, later) = of(Future::Steady);
        let (eventful, later_eventful) = of(Future::Eventful);
        assert!(steady == eventful, "what follows {same_s} s is seen at {same_s} s");
        assert_ne!(later, later_eventful, "the recordings differ");
        assert!(steady.contains("TrackId(\"a\")"), "the object is there");
    }
}

#[test]
fn a_table_at_ten_hertz() {
    assert_blind(|dir, same_s, future| table(dir, (0.1, 0.1), same_s, future));
}

#[test]
fn a_table_with_objects_twice_a_second_and_poses_at_odd_times() {
    assert_blind(|dir, same_s, future| table(dir, (0.03, 0.5), same_s, future));
}

#[test]
fn a_recording_that_ends_at_the_keyframe() {
    let of = |future| {
        let dir = tempfile::tempdir().unwrap();
        table(dir.path(), (0.1, 0.1), 3.0, future);
        stage_one(dir.path(), 3.0)
    };
    assert_eq!(of(Future::Steady), of(Future::None));
}

/// An AV2 sensor log: poses every 30 ms, so that no annotation has one of its own; the category changes later on.
fn av2(dir: &Path, same_s: f64, future: Future) {
    const START: i64 = 315_966_253_660_357_000;
    let eventful = |t: f64| future == Future::Eventful && t > same_s + 1e-9;
    let x = |t: f64| 10.0 * t - if eventful(t) { 3.0 * (t - same_s).powi(2) } else { 0.0 };
    let ns = |t: f64| START + (t * 1e9).round() as i64;
    let numbers = |v: Vec<f64>| -> ArrayRef { Arc::new(Float64Array::from(v)) };
    let save = |name: &str, columns: Vec<(&str, ArrayRef)>| {
        let batch = RecordBatch::try_from_iter(columns).unwrap();
        let file = fs::File::create(dir.join(name)).unwrap();
        let mut writer = FileWriter::try_new(file, &batch.schema()).unwrap();
        writer.write(&batch).unwrap();
        writer.finish().unwrap();
    };
    let times: Vec<f64> = (0..60).map(|i| f64::from(i) / 10.0).collect();
    let n = times.len();
    let constant = |v: f64| numbers(vec![v; n]);
    let category = |t: &f64| if eventful(*t) { "BOX_TRUCK" } else { "REGULAR_VEHICLE" };
    let integers = |v: Vec<i64>| -> ArrayRef { Arc::new(Int64Array::from(v)) };
    let texts = |v: Vec<&str>| -> ArrayRef { Arc::new(StringArray::from(v)) };
    save(
        "annotations.feather",
        vec![
            ("timestamp_ns", integers(times.iter().map(|t| ns(*t)).collect())),
            ("track_uuid", texts(vec!["a"; n])),
            ("category", texts(times.iter().map(category).collect())),
            ("length_m", constant(4.5)),
            ("width_m", constant(1.8)),
            ("height_m", constant(1.5)),
            ("qw", constant(1.0)),
            ("qx", constant(0.0)),
            ("qy", constant(0.0)),
            ("qz", constant(0.0)),
            // 25 m ahead of the rear axle, until the object brakes.
            ("tx_m", numbers(times.iter().map(|t| if eventful(*t) { 22.0 } else { 25.0 }).collect())),
            ("ty_m", constant(0.0)),
            ("tz_m", constant(0.5)),
        ],
    );
    let poses: Vec<f64> = (0..210).map(|i| f64::from(i) * 0.03 - 0.05).collect();
    let same = |v: f64| numbers(vec![v; poses.len()]);
    save(
        "city_SE3_egovehicle.feather",
        vec![
            ("timestamp_ns", integers(poses.iter().map(|t| ns(*t)).collect())),
            ("qw", same(1.0)),
            ("qx", same(0.0)),
            ("qy", same(0.0)),
            ("qz", same(0.0)),
            ("tx_m", numbers(poses.iter().map(|t| x(*t)).collect())),
            ("ty_m", same(0.0)),
            ("tz_m", same(0.0)),
        ],
    );
}

#[test]
fn an_av2_log() {
    assert_blind(av2);
}

/// A drive without a map whose ego goes round a corner of 12 m radius from 16 m on, at 10 m/s, or from the moment in
/// question on straight; an object stands beside the road.
fn corner(dir: &Path, same_s: f64, future: Future) {
    let pose = |t: f64| {
        let ends = if future == Future::Eventful { same_s } else { f64::INFINITY };
        let turned = ((10.0 * t.min(ends) - 16.0) / 12.0).clamp(0.0, std::f64::consts::FRAC_PI_2);
        let on = (10.0 * t - 16.0 - 12.0 * turned).max(0.0);
        let (x, y) = ((10.0 * t).min(16.0) + 12.0 * turned.sin(), 12.0 * (1.0 - turned.cos()));
        (x + on * turned.cos(), y + on * turned.sin(), turned)
    };
    let mut ego = "time_s,x_m,y_m,heading_rad\n".to_owned();
    let mut objects = "time_s,track_id,class,x_m,y_m,heading_rad,length_m,width_m,height_m\n".to_owned();
    for i in 0..80 {
        let t = f64::from(i) / 10.0;
        let (x, y, heading) = pose(t);
        writeln!(ego, "{t:.3},{x:.6},{y:.6},{heading:.6}").unwrap();
        writeln!(objects, "{t:.3},a,car,40,-8,0,4.5,1.8,1.5").unwrap();
    }
    fs::write(
        dir.join("drive.json"),
        r#"{"source": "test",
        "ego": {"length_m": 4.8, "width_m": 1.9, "height_m": 1.5, "reference_to_centre_m": 0}}"#,
    )
    .unwrap();
    fs::write(dir.join("ego.csv"), ego).unwrap();
    fs::write(dir.join("objects.csv"), objects).unwrap();
}

#[test]
fn a_turn_without_a_map_that_only_the_way_behind_it_proves() {
    assert_blind(corner);
    let dir = tempfile::tempdir().unwrap();
    corner(dir.path(), 3.0, Future::Steady);
    let proven = |keyframe_s: f64| stage_one(dir.path(), keyframe_s).contains("\"ego.movement\": Category");
    // The turn ends at 34.8 m; the straight behind it is known 13 m later.
    assert!(!proven(3.4) && !proven(4.6) && proven(5.1));
}
