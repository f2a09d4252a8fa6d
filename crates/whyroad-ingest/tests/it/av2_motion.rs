//! The recorded motion forecasting scenario, where it is present, against numbers that pandas reads from the same file,
//! and copies of it with one thing wrong each.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_ingest::{Options, SourceReport, av2_motion, find_sources};
use whyroad_model::scene::Motion;
use whyroad_model::{Drive, ObjectClass, Severity};

const ID: &str = "0a1e6f0a-1817-4a98-b02e-db8c9327d151";

fn scenario() -> Option<PathBuf> {
    let root = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = root.join("av2/motion_forecasting").join(ID);
    if !path.exists() {
        crate::require::skipped("recorded", "no recorded data");
        return None;
    }
    Some(path)
}

fn read() -> Option<(Drive, SourceReport)> {
    let (drive, report) = av2_motion::read(&scenario()?, &Options::default());
    Some((drive.unwrap(), report))
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn the_scenario_is_found_and_every_row_accounted_for() {
    let Some(folder) = scenario() else { return };
    let (sources, problems) = find_sources(None, &[folder.parent().unwrap().to_owned()]);
    assert!(problems.is_empty());
    assert_eq!(sources.iter().map(|s| (s.format(), &s.path)).collect::<Vec<_>>(), [("av2-motion", &folder)]);
    let Some((drive, report)) = read() else { return };
    // pandas: 2434 rows, 58 tracks of which one is the AV with 110 rows.
    let count = &report.tables[0];
    assert_eq!(
        (count.table, count.read, count.kept["track"], count.kept["ego"]),
        ("scenario", 2434, 2324, 110)
    );
    assert!(report.tables.iter().all(|t| t.adds_up()) && !report.lost_input(), "{:?}", report.diagnostics);
    assert_eq!((drive.tracks.len(), drive.frame_count()), (57, 110));
    assert_eq!(drive.tracks.iter().map(|t| t.frames.len()).sum::<usize>(), 2324);
    // start_timestamp, and its end_timestamp 10.9 s later.
    assert_eq!(drive.times[0].0, 315_986_559_459_579_008);
    assert!(near(drive.times[109].seconds_since(drive.times[0]), 10.9, 1e-9));
    assert_eq!(
        (drive.meta.place.as_deref(), drive.meta.map_ref.as_deref()),
        (Some("Austin"), Some("austin_74806"))
    );
    assert!(drive.meta.missing.iter().any(|m| m.id() == "object sizes"));
    assert!(drive.tracks.iter().all(|t| t.length_m.iter().chain(&t.width_m).all(|v| v.is_nan())));
}

#[test]
fn classes_are_those_of_the_object_types() {
    let Some((drive, _)) = read() else { return };
    let mut rows: BTreeMap<ObjectClass, usize> = BTreeMap::new();
    for t in &drive.tracks {
        *rows.entry(t.class).or_default() += t.frames.len();
    }
    // pandas, rows by object_type; of the 1774 of vehicles 110 are the AV's.
    let expected = [
        (ObjectClass::Vehicle, 1664),
        (ObjectClass::Bicycle, 142),
        (ObjectClass::Pedestrian, 329),
        (ObjectClass::StaticObject, 167),
        (ObjectClass::Unknown, 22),
    ];
    assert_eq!(rows, expected.into_iter().collect());
}

#[test]
fn positions_headings_and_velocities_are_the_files_own() {
    let Some((drive, _)) = read() else { return };
    let drive = crate::estimated(drive);
    let expect = |m: &Motion, row: usize, want: [f64; 5]| {
        let got = [m.x[row], m.y[row], m.heading[row], m.vx[row], m.vy[row]];
        assert!(got.iter().zip(want).all(|(a, b)| near(*a, b, 1e-6)), "{got:?} for {want:?}");
    };
    let ego = drive.ego.as_ref().unwrap();
    expect(&ego.motion, 0, [-433.710315, 1326.42298, 1.502292, 0.387826, 5.870244]);
    expect(&ego.motion, 50, [-432.5334, 1344.101559, 1.501397, 0.104213, 1.372131]);
    expect(&ego.motion, 109, [-428.600805, 1381.22137, 1.407924, 1.575673, 9.645218]);
    for (id, frame, want) in [
        ("138951", 60, [-421.873403, 1446.962821, 1.486263, 0.072686, 0.704225]),
        ("139640", 56, [-424.100524, 1362.975772, 1.502749, 0.0, 0.0]),
        ("139640", 109, [-423.921931, 1371.508377, 1.511487, 0.015404, 1.688975]),
    ] {
        let t = drive.track(&id.into()).unwrap();
        expect(&t.motion, t.row_at(frame).unwrap(), want);
    }
    // Acceleration: numpy.polyfit of a parabola to the AV's speed along its heading over five frames, differentiated.
    for (frame, accel) in [(30, -3.9307), (70, 1.5955), (90, 1.3332)] {
        assert!(near(ego.motion.accel[frame], accel, 0.02), "frame {frame}: {}", ego.motion.accel[frame]);
    }
    assert_eq!((ego.length_m, ego.width_m), (4.877, 2.0));
}

#[test]
fn velocities_lead_from_the_first_position_to_the_last() {
    let Some((drive, _)) = read() else { return };
    let miss = |m: &Motion| {
        let n = m.len();
        let sum = |v: &[f64]| v.windows(2).map(|w| (w[0] + w[1]) / 2.0 * 0.1).sum::<f64>();
        let (dx, dy) = (m.x[n - 1] - m.x[0], m.y[n - 1] - m.y[0]);
        (dx.hypot(dy), (dx - sum(&m.vx)).hypot(dy - sum(&m.vy)))
    };
    // Two columns of the tracker that are not made of each other: np.trapezoid of the velocity against the
    // displacement.
    let (way, error) = miss(&drive.ego.as_ref().unwrap().motion);
    println!("ego: {way:.2} m, velocities miss by {error:.2} m");
    assert!(near(way, 55.04, 0.01) && near(error, 1.17, 0.01));
    for (id, way, error) in [("138951", 33.89, 2.36), ("139400", 44.49, 2.13), ("139544", 61.23, 3.70)] {
        let got = miss(&drive.track(&id.into()).unwrap().motion);
        assert!(near(got.0, way, 0.01) && near(got.1, error, 0.01), "{id}: {got:?}");
    }
}

#[test]
fn the_map_keeps_its_own_center_lines() {
    let Some((drive, report)) = read() else { return };
    let map = drive.map.unwrap();
    // json: 71 lane segments, 32 of them in intersections, 6 crossings, 2 drivable areas.
    let lanes_inside = map.lanes.iter().filter(|l| l.in_junction).count();
    assert_eq!(
        (map.lanes.len(), lanes_inside, map.crosswalks.len(), map.drivable_areas.len()),
        (71, 32, 6, 2)
    );
    let lane = map.lane("205119120").unwrap();
    assert_eq!(lane.center.len(), 18);
    assert_eq!((lane.center[0].x, lane.center[0].y), (-438.53, 1317.34));
    assert_eq!((lane.center[17].x, lane.center[17].y), (-435.94, 1350.0));
    // The file's center lines have no height; ours have the edges'.
    assert!(near(lane.center[0].z, (lane.left[0].z + lane.right[0].z) / 2.0, 0.2), "{:?}", lane.center[0]);
    assert!(!report.diagnostics.iter().any(|d| d.severity == Severity::Error), "{:?}", report.diagnostics);
}

fn copy(change: impl Fn(&Path)) -> Option<(Option<Drive>, Vec<&'static str>)> {
    let from = scenario()?;
    let dir = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(&from).unwrap().flatten() {
        fs::copy(entry.path(), dir.path().join(entry.file_name())).unwrap();
    }
    change(dir.path());
    let (drive, report) = av2_motion::read(dir.path(), &Options::default());
    Some((drive, report.diagnostics.iter().map(|d| d.code).filter(|c| *c != "av2.map.border").collect()))
}

#[test]
fn a_cut_file_is_no_drive_and_a_missing_map_is_a_drive_without_one() {
    let parquet = format!("scenario_{ID}.parquet");
    let Some((drive, codes)) = copy(|dir| {
        let bytes = fs::read(dir.join(&parquet)).unwrap();
        fs::write(dir.join(&parquet), &bytes[..bytes.len() / 2]).unwrap();
    }) else {
        return;
    };
    assert!(drive.is_none());
    assert_eq!(codes, ["av2.motion.unreadable"]);
    let Some((drive, codes)) =
        copy(|dir| fs::remove_file(dir.join(format!("log_map_archive_{ID}.json"))).unwrap())
    else {
        return;
    };
    assert_eq!(codes, ["av2.map.missing"]);
    assert!(drive.unwrap().meta.missing.iter().any(|m| m.id() == "map"));
}

/// A scenario of one car that drives along x at 10 m/s for three steps; `change` breaks it.
fn written(change: impl Fn(&mut Vec<(&'static str, ArrayRef)>)) -> (Option<Drive>, SourceReport) {
    let numbers = |v: [f64; 3]| Arc::new(Float64Array::from(v.to_vec())) as ArrayRef;
    let texts = |v: &str| Arc::new(StringArray::from(vec![v; 3])) as ArrayRef;
    let mut columns = vec![
        ("track_id", texts("AV")),
        ("object_type", texts("vehicle")),
        ("timestep", Arc::new(Int64Array::from(vec![0, 1, 2])) as ArrayRef),
        ("position_x", numbers([0.0, 1.0, 2.0])),
        ("position_y", numbers([0.0; 3])),
        ("heading", numbers([0.0; 3])),
        ("velocity_x", numbers([10.0; 3])),
        ("velocity_y", numbers([0.0; 3])),
    ];
    change(&mut columns);
    let dir = tempfile::tempdir().unwrap();
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let file = fs::File::create(dir.path().join("scenario_x.parquet")).unwrap();
    let mut writer = parquet::arrow::ArrowWriter::try_new(file, batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    av2_motion::read(dir.path(), &Options::default())
}

fn set(columns: &mut [(&'static str, ArrayRef)], name: &str, array: impl arrow_array::Array + 'static) {
    columns.iter_mut().find(|(n, _)| *n == name).unwrap().1 = Arc::new(array);
}

#[test]
fn each_thing_that_is_wrong_is_told_by_its_code() {
    let codes = |(drive, report): (Option<Drive>, SourceReport)| {
        let codes: Vec<&str> =
            report.diagnostics.iter().map(|d| d.code).filter(|c| *c != "av2.map.missing").collect();
        (
            drive.map(|d| (d.frame_count(), d.ego.is_some())),
            codes,
            report.tables.first().map_or(0, |t| t.dropped_total()),
        )
    };
    assert_eq!(codes(written(|_| ())), (Some((3, true)), vec![], 0));
    // A position that is not a number, and a step that comes twice.
    let bad = written(|c| set(c, "position_x", Float64Array::from(vec![0.0, f64::NAN, 2.0])));
    assert_eq!(codes(bad), (Some((3, true)), vec!["av2.motion.invalid"], 1));
    let twice = written(|c| set(c, "timestep", Int64Array::from(vec![0, 1, 1])));
    assert_eq!(codes(twice), (Some((2, true)), vec!["av2.motion.invalid"], 1));
    let no_ego = written(|c| set(c, "track_id", StringArray::from(vec!["7"; 3])));
    assert_eq!(codes(no_ego), (Some((3, false)), vec!["av2.motion.no_ego"], 0));
    let strange = written(|c| set(c, "object_type", StringArray::from(vec!["hovercraft"; 3])));
    assert_eq!(codes(strange), (Some((3, true)), vec!["av2.motion.type"], 0));
    let empty = written(|c| set(c, "heading", Float64Array::from(vec![f64::NAN; 3])));
    assert_eq!(codes(empty), (None, vec!["av2.motion.invalid", "av2.motion.empty"], 3));
    let (drive, report) = written(|c| c.retain(|(n, _)| *n != "heading"));
    assert!(drive.is_none());
    assert!(report.diagnostics[0].message.en.contains("'heading'"), "{:?}", report.diagnostics);
}
