//! Small logs of our own with one thing wrong each. The scene: the ego drives north (yaw 90 degrees) at 10 m/s, its
//! rear axle at (100, 200 + 10 t); object `a` keeps 20 m ahead of the axle in its lane, so it is at (100, 220 + 10 t).
#![allow(clippy::unwrap_used)]

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use whyroad_ingest::{AdapterRef, Options, SourceReport, av2, find_sources, ingest};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::{Drive, ObjectClass, Severity};

const T0: i64 = 315_966_253_660_357_000;
const FRAME: i64 = 100_000_000;
const NORTH: [f64; 4] = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

#[derive(Clone)]
struct Row {
    frame: i64,
    id: &'static str,
    category: &'static str,
    size: [f64; 3],
    q: [f64; 4],
    t: [f64; 3],
}

fn row(frame: i64, id: &'static str, x: f64) -> Row {
    Row { frame, id, category: "REGULAR_VEHICLE", size: [4.5, 1.8, 1.5], q: IDENTITY, t: [x, 0.0, 0.5] }
}

fn column(values: impl IntoIterator<Item = f64>) -> ArrayRef {
    Arc::new(Float64Array::from_iter_values(values))
}

fn annotations(rows: &[Row]) -> RecordBatch {
    let times = Int64Array::from_iter_values(rows.iter().map(|r| T0 + r.frame * FRAME));
    let mut columns: Vec<(&str, ArrayRef)> = vec![
        ("timestamp_ns", Arc::new(times)),
        ("track_uuid", Arc::new(StringArray::from_iter_values(rows.iter().map(|r| r.id)))),
        ("category", Arc::new(StringArray::from_iter_values(rows.iter().map(|r| r.category)))),
    ];
    for (i, name) in ["length_m", "width_m", "height_m"].into_iter().enumerate() {
        columns.push((name, column(rows.iter().map(|r| r.size[i]))));
    }
    for (i, name) in ["qw", "qx", "qy", "qz"].into_iter().enumerate() {
        columns.push((name, column(rows.iter().map(|r| r.q[i]))));
    }
    for (i, name) in ["tx_m", "ty_m", "tz_m"].into_iter().enumerate() {
        columns.push((name, column(rows.iter().map(|r| r.t[i]))));
    }
    RecordBatch::try_from_iter(columns).unwrap()
}

/// Poses at (time in ns after T0, quaternion).
fn poses(rows: &[(i64, [f64; 4])]) -> RecordBatch {
    let mut columns: Vec<(&str, ArrayRef)> =
        vec![("timestamp_ns", Arc::new(Int64Array::from_iter_values(rows.iter().map(|r| T0 + r.0))))];
    for (i, name) in ["qw", "qx", "qy", "qz"].into_iter().enumerate() {
        columns.push((name, column(rows.iter().map(|r| r.1[i]))));
    }
    columns.push(("tx_m", column(rows.iter().map(|_| 100.0))));
    columns.push(("ty_m", column(rows.iter().map(|r| 200.0 + r.0 as f64 * 1e-8))));
    columns.push(("tz_m", column(rows.iter().map(|_| 0.0))));
    RecordBatch::try_from_iter(columns).unwrap()
}

/// Every 30 ms from 50 ms before the first frame: no annotation time has a pose of its own.
fn steady_poses(frames: i64) -> RecordBatch {
    poses(&(0..frames * 4).map(|i| (i * 30_000_000 - 50_000_000, NORTH)).collect::<Vec<_>>())
}

fn write(path: &Path, batches: &[RecordBatch]) {
    let options = IpcWriteOptions::default().try_with_compression(Some(CompressionType::LZ4_FRAME)).unwrap();
    let file = fs::File::create(path).unwrap();
    let mut w = FileWriter::try_new_with_options(file, &batches[0].schema(), options).unwrap();
    for b in batches {
        w.write(b).unwrap();
    }
    w.finish().unwrap();
}

/// Two lanes in a row; the first also names a successor that is not there, as do both ends at the border.
fn map_json(extra_successor: &str) -> String {
    let lane = |id: u32, y: f64, links: &str| {
        format!(
            r#""{id}":{{"id":{id},"is_intersection":false,"lane_type":"VEHICLE","left_lane_mark_type":"DASHED_YELLOW",
            "right_lane_mark_type":"SOLID_WHITE","left_neighbor_id":null,"right_neighbor_id":null,{links},
            "left_lane_boundary":[{{"x":98,"y":{y},"z":0}},{{"x":98,"y":{0},"z":0}}],
            "right_lane_boundary":[{{"x":102,"y":{y},"z":0}},{{"x":102,"y":{0},"z":0}}]}}"#,
            y + 100.0
        )
    };
    // A wide lane far off on either side makes the middle of the map lie away from its border.
    let (a, b) = (
        lane(1, 150.0, &format!(r#""successors":[2{extra_successor}],"predecessors":[77]"#)),
        lane(2, 250.0, r#""successors":[],"predecessors":[]"#),
    );
    let far = |id: u32, x: f64| {
        format!(
            r#""{id}":{{"id":{id},"is_intersection":false,"lane_type":"BIKE","successors":[],"predecessors":[],
            "left_lane_boundary":[{{"x":{x},"y":150,"z":0}},{{"x":{x},"y":350,"z":0}}],
            "right_lane_boundary":[{{"x":{0},"y":150,"z":0}},{{"x":{0},"y":350,"z":0}}]}}"#,
            x + 3.0
        )
    };
    let (west, east) = (far(3, 0.0), far(4, 200.0));
    format!(
        r#"{{"lane_segments":{{{a},{b},{west},{east}}},"pedestrian_crossings":{{}},"drivable_areas":{{}}}}"#
    )
}

struct Log {
    dir: tempfile::TempDir,
}

impl Log {
    fn new(rows: &[RecordBatch]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        write(&dir.path().join("annotations.feather"), rows);
        Self { dir }
    }
    fn with_poses(self, batch: &RecordBatch) -> Self {
        write(&self.dir.path().join("city_SE3_egovehicle.feather"), std::slice::from_ref(batch));
        self
    }
    fn with_map(self, text: &str) -> Self {
        fs::create_dir(self.dir.path().join("map")).unwrap();
        fs::write(self.dir.path().join("map/log_map_archive_x____PIT_city_1.json"), text).unwrap();
        self
    }
    fn read(&self) -> (Option<Drive>, SourceReport) {
        let (drive, report) = av2::read(self.dir.path(), None);
        assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
        (drive, report)
    }
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn following(frames: i64) -> Vec<Row> {
    (0..frames).map(|f| row(f, "a", 20.0)).collect()
}

#[test]
fn a_lead_at_a_constant_distance_has_the_egos_speed_and_not_zero() {
    let log = Log::new(&[annotations(&following(20))]).with_poses(&steady_poses(20)).with_map(&map_json(""));
    let (drive, report) = log.read();
    let drive = crate::estimated(drive.unwrap());
    assert_eq!(codes(&report), ["av2.map.border"]);
    let (ego, a) = (drive.ego.as_ref().unwrap(), &drive.tracks[0]);
    for i in 0..20 {
        let y = 200.0 + i as f64;
        let t = |v: f64, want: f64| assert!((v - want).abs() < 1e-5, "frame {i}: {v} for {want}");
        t(a.motion.x[i], 100.0);
        t(a.motion.y[i], y + 20.0);
        t(a.motion.vx[i], 0.0);
        t(a.motion.vy[i], 10.0);
        t(a.motion.accel[i], 0.0);
        t(a.motion.heading[i], FRAC_PI_2);
        // The box center is 1.339 m ahead of the rear axle.
        t(ego.motion.y[i], y + 1.339);
        t(ego.motion.forward_speed(i), 10.0);
    }
    assert!(a.interior_points.iter().all(|p| p.is_nan()), "no such column: unknown, not 0");
    let map = drive.map.unwrap();
    assert_eq!(map.lane("2").unwrap().predecessors, ["1"], "completed from lane 1's successors");
    let center = &map.lane("1").unwrap().center;
    assert!(center.iter().all(|p| (p.x - 100.0).abs() < 1e-9) && center.len() == 101);
}

#[test]
fn a_truncated_file_keeps_its_readable_batches_and_the_other_logs_go_on() {
    let batches: Vec<_> = following(20).chunks(5).map(annotations).collect();
    let folder = tempfile::tempdir().unwrap();
    for (name, keep) in [("cut", 0.5), ("short", 0.01), ("whole", 1.0)] {
        let dir = folder.path().join(name);
        fs::create_dir(&dir).unwrap();
        let file = dir.join("annotations.feather");
        write(&file, &batches);
        write(&dir.join("city_SE3_egovehicle.feather"), &[steady_poses(20)]);
        let bytes = fs::read(&file).unwrap();
        fs::write(&file, &bytes[..(bytes.len() as f64 * keep) as usize]).unwrap();
    }
    let lake = Lake::create_or_open(folder.path().join("lake")).unwrap();
    let (sources, problems) = find_sources(Some(AdapterRef(&av2::Av2)), &[folder.path().to_owned()]);
    assert_eq!((sources.len(), problems.len()), (3, 0));
    let reports: Vec<_> = sources.iter().map(|s| ingest(s, &Options::default(), &lake)).collect();
    let [cut, short, whole] = &reports[..] else { panic!("three logs") };

    assert_eq!(cut.outcome, Some(WriteOutcome::Written));
    assert!(cut.lost_input() && codes(cut).contains(&"av2.feather.truncated"));
    let rows = cut.tables[0].kept_total();
    assert!(rows > 0 && rows < 20 && rows % 5 == 0, "{rows} rows: whole batches");

    assert_eq!(short.outcome, None);
    let error = short.diagnostics.iter().find(|d| d.severity == Severity::Error).unwrap();
    assert!(error.code == "av2.feather.truncated" && error.hint.is_some());
    assert!(error.location.file.as_ref().unwrap().ends_with("annotations.feather"));

    assert_eq!(
        (whole.outcome, whole.lost_input(), whole.tables[0].kept_total()),
        (Some(WriteOutcome::Written), false, 20)
    );
    assert_eq!(lake.drive_ids().len(), 2);
    // The same input once more changes nothing.
    assert_eq!(ingest(&sources[2], &Options::default(), &lake).outcome, Some(WriteOutcome::Unchanged));
}

#[test]
fn a_lane_id_that_leads_nowhere_is_told_and_the_lane_is_kept() {
    // Lane 1 ends at (100, 250): 100 m from every side of the map. Its predecessor 77 is at the border.
    let log = Log::new(&[annotations(&following(5))]).with_poses(&steady_poses(5)).with_map(&map_json(",99"));
    let (drive, report) = log.read();
    let dangling: Vec<_> = report.diagnostics.iter().filter(|d| d.code == "av2.map.dangling").collect();
    assert_eq!(dangling.len(), 1);
    assert_eq!(dangling[0].severity, Severity::Warning);
    assert!(dangling[0].message.en.contains("lane 1 names 99"), "{}", dangling[0].message.en);
    assert!(dangling[0].hint.is_some());
    assert!(codes(&report).contains(&"av2.map.border"));
    let map = drive.unwrap().map.unwrap();
    assert_eq!(map.lanes.len(), 4);
    assert_eq!(map.lane("1").unwrap().successors, ["2", "99"]);
}

#[test]
fn an_empty_log_is_a_clear_error() {
    let (drive, report) = Log::new(&[annotations(&[])]).with_poses(&steady_poses(3)).read();
    assert!(drive.is_none());
    assert_eq!(codes(&report), ["av2.log.empty"]);

    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("0a1e6f0a-1817-4a98-b02e-db8c9327d151")).unwrap();
    let (sources, _) = find_sources(None, &[folder.path().to_owned()]);
    let (drive, report) = av2::read(&sources[0].path, None);
    assert!(drive.is_none());
    assert_eq!(codes(&report), ["av2.log.missing"]);
}

#[test]
fn bad_rows_are_dropped_counted_and_named() {
    let mut rows = following(10);
    rows[3].q = [0.0; 4];
    rows[4].t[0] = f64::NAN;
    rows.push(row(5, "a", 99.0));
    rows[6].size[1] = -1.0;
    rows.push(Row { category: "HOVERCRAFT", ..row(2, "h", 5.0) });
    rows.extend((0..10).map(|f| row(f, "b", 10.0)));
    let (drive, report) = Log::new(&[annotations(&rows)]).with_poses(&steady_poses(10)).read();
    let count = &report.tables[0];
    assert_eq!(count.dropped.get("invalid"), Some(&2));
    assert_eq!(count.dropped.get("duplicate"), Some(&1));
    assert_eq!((count.read, count.kept_total()), (22, 19));
    let expected = [
        "av2.annotations.category",
        "av2.annotations.duplicate",
        "av2.annotations.invalid",
        "av2.annotations.size",
        "av2.map.missing",
    ];
    let mut found = codes(&report);
    found.sort_unstable();
    assert_eq!(found, expected);
    let drive = drive.unwrap();
    let a = drive.track(&"a".into()).unwrap();
    let y = a.motion.y[a.row_at(5).unwrap()];
    assert!((y - 225.0).abs() < 1e-9, "the first of two rows is kept, not y = {y}");
    let h = drive.track(&"h".into()).unwrap();
    assert_eq!((h.class, h.source_class.as_str()), (ObjectClass::Unknown, "HOVERCRAFT"));
    assert!(a.width_m[a.row_at(6).unwrap()].is_nan());
}

#[test]
fn a_track_that_re_enters_keeps_its_gap_and_gets_no_speed_from_it() {
    // Unseen from frame 5 to 14, and 30 m further ahead afterwards.
    let mut rows: Vec<Row> =
        (0..5).chain(15..20).map(|f| row(f, "a", if f < 5 { 20.0 } else { 50.0 })).collect();
    rows.extend((0..20).map(|f| row(f, "b", 10.0)));
    let (drive, _) = Log::new(&[annotations(&rows)]).with_poses(&steady_poses(20)).read();
    let drive = crate::estimated(drive.unwrap());
    let a = drive.track(&"a".into()).unwrap();
    assert_eq!(a.frames, [0, 1, 2, 3, 4, 15, 16, 17, 18, 19]);
    assert!(a.motion.vy.iter().all(|v| (v - 10.0).abs() < 1e-5), "{:?}", a.motion.vy);
}

#[test]
fn speeds_that_cannot_be_become_unknown() {
    // A pedestrian who keeps 5 m ahead of a car at 10 m/s and then jumps by 2 m a frame: 30 m/s over ground, in the
    // nine steps between ten rows.
    let walker = |f: i64| Row { category: "PEDESTRIAN", ..row(f, "p", 5.0 + 2.0 * f as f64) };
    let rows: Vec<Row> = (0..10).map(walker).chain(following(10)).collect();
    let (drive, report) = Log::new(&[annotations(&rows)]).with_poses(&steady_poses(10)).read();
    let warning = report.diagnostics.iter().find(|d| d.code == "ingest.speed.impossible").unwrap();
    assert!(warning.message.en.starts_with("9 rows of 1 tracks"), "{}", warning.message.en);
    let drive = crate::estimated(drive.unwrap());
    let p = drive.track(&"p".into()).unwrap();
    assert!(p.motion.vx.iter().all(|v| v.is_nan()) && p.motion.x.iter().all(|v| !v.is_nan()));
    assert_eq!(report.tables[0].dropped_total(), 0, "positions are kept");
}

#[test]
fn poses_may_be_disordered_doubled_or_end_early() {
    // Backward in the file, one twice, one no rotation, and none after frame 6.
    let mut list: Vec<(i64, [f64; 4])> = (0..=13).map(|i| (i * 50_000_000, NORTH)).collect();
    list.swap(2, 9);
    list.push((100_000_000, NORTH));
    list.push((620_000_000, [9.0, 0.0, 0.0, 0.0]));
    let (drive, report) = Log::new(&[annotations(&following(10))]).with_poses(&poses(&list)).read();
    let drive = crate::estimated(drive.unwrap());
    assert_eq!(drive.frame_count(), 7);
    assert!(drive.ego.unwrap().motion.vy.iter().all(|v| (v - 10.0).abs() < 1e-6));
    let mut found = codes(&report);
    found.sort_unstable();
    assert_eq!(
        found,
        ["av2.map.missing", "av2.pose.backward_time", "av2.pose.invalid", "av2.pose.uncovered"]
    );
    let pose = report.tables.iter().find(|t| t.table == "pose").unwrap();
    assert_eq!((pose.read, pose.kept_total(), pose.dropped_total()), (16, 14, 2));
    assert_eq!(report.tables[0].dropped.get("no_pose"), Some(&3));
}

#[test]
fn an_ego_row_is_the_ego_and_not_a_track() {
    let ego = |f: i64, x: f64| Row { category: "EGO_VEHICLE", size: [5.0, 2.1, 1.6], ..row(f, "ego", x) };
    for (x, center, note) in [(0.0, 1.339, true), (1.5, 1.5, false)] {
        let rows: Vec<Row> = following(5).into_iter().chain((0..5).map(|f| ego(f, x))).collect();
        let (drive, report) = Log::new(&[annotations(&rows)]).with_poses(&steady_poses(5)).read();
        let drive = drive.unwrap();
        assert_eq!(drive.tracks.len(), 1);
        let e = drive.ego.unwrap();
        assert_eq!((e.length_m, e.width_m, e.height_m, e.reference_to_centre_m), (5.0, 2.1, 1.6, center));
        assert_eq!(codes(&report).contains(&"av2.ego.box_at_axle"), note);
    }
}

#[test]
fn what_is_no_feather_and_what_is_no_map_are_named() {
    let log = Log::new(&[annotations(&following(5))]).with_poses(&steady_poses(5)).with_map("{ not json");
    let (drive, report) = log.read();
    assert!(drive.unwrap().map.is_none());
    assert!(codes(&report).contains(&"av2.map.unreadable") && report.lost_input());
    fs::write(log.dir.path().join("annotations.feather"), "timestamp_ns,track_uuid\n").unwrap();
    let (drive, report) = log.read();
    assert!(drive.is_none());
    assert_eq!(codes(&report), ["av2.feather.unreadable"]);
}

/// Annotations at 2 Hz: frames every 0.1 s, the ego from its poses at 33 Hz, the object, which goes at constant speed,
/// on the straight line between two annotations. A gap of 1 s stays one.
#[test]
fn annotations_of_another_rate_are_brought_to_tenths() {
    let rows: Vec<Row> = (0..10).map(|i| row(5 * i, "a", 20.0)).collect();
    let log = Log::new(&[annotations(&rows)]).with_poses(&steady_poses(46));
    let (drive, report) = log.read();
    assert!(codes(&report).contains(&"ingest.rate.resampled"), "{:?}", report.diagnostics);
    let drive = crate::estimated(drive.unwrap());
    let (ego, a) = (drive.ego.as_ref().unwrap(), &drive.tracks[0]);
    assert_eq!((drive.times.len(), a.frames.len()), (46, 46));
    for i in 0..46 {
        let t = |v: f64, want: f64| assert!((v - want).abs() < 1e-5, "frame {i}: {v} for {want}");
        t(a.motion.y[i], 220.0 + i as f64);
        t(ego.motion.y[i], 201.339 + i as f64);
        t(ego.motion.forward_speed(i), 10.0);
    }
    let gappy: Vec<Row> = rows.into_iter().filter(|r| r.frame != 20).collect();
    let log = Log::new(&[annotations(&gappy)]).with_poses(&steady_poses(46));
    let frames = log.read().0.unwrap().tracks[0].frames.clone();
    assert!(frames.contains(&15) && !frames.contains(&20) && frames.contains(&25));
}

/// Annotations in microseconds beside poses in nanoseconds: no frame has a pose, and that is an error.
#[test]
fn poses_of_another_clock_are_reported() {
    let late = poses(&(0..80).map(|i| (3_600_000_000_000 + i * 30_000_000, NORTH)).collect::<Vec<_>>());
    let (drive, report) = Log::new(&[annotations(&following(20))]).with_poses(&late).read();
    assert!(codes(&report).contains(&"av2.pose.uncovered") && report.lost_input());
    assert!(drive.unwrap().meta.missing.contains(&whyroad_model::Need::EgoPose));
}
