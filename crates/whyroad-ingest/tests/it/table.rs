//! The table layout: the example in `examples/table`, whose numbers follow from the formulas in its `make.py`, and
//! copies of it with one thing wrong each.
#![allow(clippy::unwrap_used)]

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_ingest::{Options, SourceReport, find_sources, table};
use whyroad_model::scene::{LightColor, TurnSignal};
use whyroad_model::vocabulary::{CONTEXT_KINDS, ContextValues, FACILITY_KINDS, LANE_TAGS, SIGN_KINDS};
use whyroad_model::{Drive, Need, ObjectClass, Severity};

fn example() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/table/following")
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// A copy of the example in which `change` did something, read.
fn changed(change: impl Fn(&Path)) -> (Option<Drive>, SourceReport) {
    let dir = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(example()).unwrap().flatten() {
        fs::copy(entry.path(), dir.path().join(entry.file_name())).unwrap();
    }
    change(dir.path());
    table::read(dir.path(), &Options::default())
}

fn edit(dir: &Path, file: &str, from: &str, to: &str) {
    let text = fs::read_to_string(dir.join(file)).unwrap();
    assert!(text.contains(from), "{file} has no '{from}'");
    fs::write(dir.join(file), text.replacen(from, to, 1)).unwrap();
}

/// Codes but for the note that the example's 20 Hz were resampled.
fn codes(report: &SourceReport) -> Vec<&'static str> {
    report.diagnostics.iter().map(|d| d.code).filter(|c| *c != "ingest.rate.resampled").collect()
}

#[test]
fn the_example_is_what_its_formulas_say() {
    let (sources, problems) = find_sources(None, &[example().parent().unwrap().to_owned()]);
    assert!(crate::only_skipped(&problems));
    assert_eq!(sources.iter().map(|s| s.format()).collect::<Vec<_>>(), ["table"]);
    let (drive, report) = table::read(&sources[0].path, &Options::default());
    let read = drive.unwrap();
    let drive = crate::estimated(read.clone());
    assert!(codes(&report).is_empty() && !report.lost_input(), "{:?}", report.diagnostics);
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    assert_eq!((drive.meta.drive_id.as_str(), drive.frame_count()), ("example-following", 41));
    assert_eq!(
        (drive.times[0].to_string(), drive.times[40].to_string()),
        ("2026-01-15T10:30:00.000Z".into(), "2026-01-15T10:30:04.000Z".into())
    );

    // The axle is at 8 t; the middle of the van 1.5 m ahead of it.
    let ego = drive.ego.as_ref().unwrap();
    assert!(
        (0..41)
            .all(|i| near(ego.motion.x[i], 0.8 * i as f64 + 1.5, 1e-9) && near(ego.motion.vx[i], 8.0, 1e-9))
    );
    assert!((0..41).all(|i| near(ego.motion.accel[i], 0.0, 1e-9) && ego.bus.speed_mps[i] == 7.9));
    // Brake from row 40, which is 2.0 s, on.
    assert!((0..41).all(|i| ego.bus.brake[i] == Some(i >= 20) && ego.bus.gear[i] == Some('D')));
    assert_eq!(ego.bus.turn_signal[7], Some(TurnSignal::Off));
    assert!(ego.bus.aeb.is_empty());

    let car = drive.track(&"car-1".into()).unwrap();
    assert_eq!((car.class, car.frames.len()), (ObjectClass::Car, 41));
    for (row, t) in [(0, 0.0), (15, 1.5), (40, 4.0)] {
        assert!(near(car.motion.x[row], 30.0 + 10.0 * t - t * t / 2.0, 1e-3));
        assert!(near(car.motion.vx[row], 10.0 - t, 1e-6) && near(car.motion.accel[row], -1.0, 1e-6));
    }
    let walker = drive.track(&"ped-1".into()).unwrap();
    // 1.0 s to 3.0 s, not from 2.1 s to 2.5 s: the gap of 0.6 s stays a gap.
    assert_eq!(
        read.track(&"ped-1".into()).unwrap().frames,
        (10..=30).filter(|f| !(21..=25).contains(f)).collect::<Vec<u32>>()
    );
    let row = walker.row_at(28).unwrap();
    assert!(near(walker.motion.y[row], -6.0 + 1.5 * 2.8, 1e-6) && near(walker.motion.vy[row], 1.5, 1e-5));

    let map = drive.map.as_ref().unwrap();
    assert_eq!(
        (map.lanes.len(), map.crosswalks.len(), map.stop_lines.len(), map.facilities.len()),
        (2, 1, 1, 1)
    );
    assert_eq!(
        (map.facilities[0].kind.as_str(), map.stop_lines[0].lane_ids[0].as_str()),
        ("speed_bump", "east-1")
    );
    // The second lane has no center line: it lies half way between its edges, at y = 3.5.
    let second = map.lane("east-2").unwrap();
    assert!(second.center.iter().all(|p| near(p.y, 3.5, 1e-9)) && second.speed_limit_mps == Some(13.89));
    let lights = drive.lights.as_ref().unwrap();
    assert_eq!(
        (lights.len(), lights[1].color, lights[1].time.seconds_since(drive.times[0])),
        (3, LightColor::Yellow, 1.5)
    );
    let context = drive.context.as_ref().unwrap();
    assert_eq!((context[0].kind.as_str(), context[0].value.as_str()), ("weather", "rain"));
}

#[test]
fn what_a_sensor_model_tells_is_kept() {
    // Two columns more: the walker half seen behind the car in every row, one cell of the car's out of range.
    let (drive, report) = changed(|dir| {
        let text = fs::read_to_string(dir.join("objects.csv")).unwrap();
        let more = |(i, line): (usize, &str)| match i {
            0 => format!("{line},visible_share,occluder\n"),
            _ if line.contains("ped-1") => format!("{line},0.5,car-1\n"),
            1 => format!("{line},50,\n"),
            _ => format!("{line},,\n"),
        };
        fs::write(dir.join("objects.csv"), text.lines().enumerate().map(more).collect::<String>()).unwrap();
    });
    let drive = drive.unwrap();
    let walker = drive.track(&"ped-1".into()).unwrap();
    assert!(
        walker.visible_share.len() == walker.frames.len() && walker.visible_share.iter().all(|s| *s == 0.5)
    );
    assert!(walker.occluder.iter().all(|o| *o == Some("car-1".into())) && !walker.occluder.is_empty());
    let car = drive.track(&"car-1".into()).unwrap();
    assert!(car.visible_share.is_empty() && car.occluder.is_empty(), "a share of 50 is none");
    assert_eq!(codes(&report).len(), 1, "{:?}", report.diagnostics);
}

#[test]
fn parquet_and_csv_give_the_same_drive() {
    let (csv, _) = changed(|_| ());
    // The same objects as Parquet, numbers as numbers.
    let (parquet, report) = changed(|dir| {
        let text = fs::read_to_string(dir.join("objects.csv")).unwrap();
        let mut lines = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let rows: Vec<_> = lines.collect();
        let columns = header.iter().enumerate().map(|(j, name)| {
            let cells: Vec<&str> = rows.iter().map(|r| r[j]).collect();
            let array: ArrayRef = match *name {
                "track_id" | "class" => Arc::new(StringArray::from(cells)),
                _ => Arc::new(cells.iter().map(|c| c.parse::<f64>().ok()).collect::<Float64Array>()),
            };
            (*name, array)
        });
        let batch = RecordBatch::try_from_iter(columns).unwrap();
        let file = fs::File::create(dir.join("objects.parquet")).unwrap();
        let mut writer = parquet::arrow::ArrowWriter::try_new(file, batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();
        fs::remove_file(dir.join("objects.csv")).unwrap();
    });
    assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
    let text = |d: Option<Drive>| d.unwrap().tracks.iter().map(|t| format!("{t:?}")).collect::<Vec<_>>();
    assert_eq!(text(csv), text(parquet));
}

#[test]
fn unknown_names_are_told_with_the_nearest_known_one() {
    let (drive, report) = changed(|dir| edit(dir, "ego.csv", "heading_rad", "heading_rads"));
    // The required column is then missing.
    assert!(drive.is_none());
    assert_eq!(codes(&report), ["table.column.unknown", "table.column.missing"]);
    let found = report.diagnostics.iter().find(|d| d.code == "table.column.unknown").unwrap();
    assert!(found.hint.as_ref().unwrap().en.contains("'heading_rad'"), "{found:?}");
    let absent = report.diagnostics.iter().find(|d| d.code == "table.column.missing").unwrap();
    assert!(
        absent.message.en.contains("'heading_rad' or 'heading_deg'")
            && absent.location.file.as_deref().unwrap().ends_with("ego.csv")
    );

    let (drive, report) = changed(|dir| edit(dir, "objects.csv", "car-1,car,", "car-1,spaceship,"));
    assert_eq!(codes(&report), ["table.class.unknown"]);
    let car = drive.unwrap();
    let car = car.track(&"car-1".into()).unwrap();
    // By time: the first row alone is not known.
    assert_eq!(car.class_at(0), (ObjectClass::Unknown, "spaceship"));
    assert_eq!((car.class, car.class_at(1)), (ObjectClass::Car, (ObjectClass::Car, "car")));

    // Usual names are known.
    let (drive, report) = changed(|dir| edit(dir, "objects.csv", "car-1,car,", "car-1,Van,"));
    assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
    assert_eq!(drive.unwrap().track(&"car-1".into()).unwrap().class_at(0), (ObjectClass::Car, "Van"));

    let (drive, report) = changed(|dir| edit(dir, "drive.yaml", "licence:", "license:"));
    assert!(drive.is_some() && codes(&report) == ["table.meta.unknown"]);
    assert!(report.diagnostics[0].hint.as_ref().unwrap().en.contains("'licence'"));
}

#[test]
fn bad_cells_and_rows_are_counted_with_their_numbers() {
    // Row 1 is the header, so the first row of data is row 2.
    let (drive, report) = changed(|dir| {
        edit(dir, "objects.csv", "0.1,car-1,car,30.995,0,0,9.9", "0.1,car-1,car,thirty,0,0,9.9");
        edit(dir, "objects.csv", "0.2,car-1,car,31.98,0,0,9.8,4.5", "0.2,car-1,car,31.98,0,0,9.8,long");
        edit(dir, "objects.csv", "0.3,car-1", "soon,car-1");
        edit(dir, "objects.csv", "0.5,car-1", "0.4,car-1");
    });
    let drive = drive.unwrap();
    let count = report.tables.iter().find(|t| t.table == "objects").unwrap();
    assert_eq!(
        (count.read, count.dropped.clone()),
        (57, [("duplicate", 1), ("no_position", 1), ("no_time", 1)].into_iter().collect())
    );
    assert!(count.adds_up() && report.lost_input());
    let messages: Vec<&str> = report.diagnostics.iter().map(|d| d.message.en.as_str()).collect();
    for part in [
        "1 cells of column 'x_m' are not a number and count as unknown: rows 3; for example 'thirty'",
        "1 cells of column 'length_m' are not a number above 0 and count as unknown: rows 4; for example 'long'",
        "1 cells of column 'time_s' are not a number of seconds and count as unknown: rows 5; for example 'soon'",
        "1 rows dropped (no position): rows 3",
        "1 rows dropped (no time): rows 5",
        "1 rows dropped (duplicate): rows 7",
    ] {
        assert!(messages.contains(&part), "'{part}' is not in {messages:?}");
    }
    // A single lost row is less than 0.25 s away from its neighbors and is filled; an unknown length is not.
    let car = drive.track(&"car-1".into()).unwrap();
    assert!(near(car.motion.x[1], (30.0 + 31.98) / 2.0, 1e-9));
    assert!(car.length_m[2].is_nan() && car.length_m[4] == 4.5);
}

#[test]
fn irregular_times_are_brought_to_tenths_and_angles_go_the_short_way() {
    let (drive, report) = changed(|dir| {
        let mut text = String::from("time,x_m,y_m,heading_deg\n");
        // At 0, 0.03, 0.17 ... s, 10 m/s along -x, the heading passing through 180 degrees; then a hole of a second.
        for t in [0.0, 0.03, 0.17, 0.26, 0.41, 0.5, 1.5, 1.56, 1.7] {
            let heading = 179.0 + 10.0 * t;
            let heading = if heading > 180.0 { heading - 360.0 } else { heading };
            text += &format!("2026-01-15T10:30:0{t:.2}Z,{:.6},0,{heading:.6}\n", -10.0 * t);
        }
        fs::write(dir.join("ego.csv"), text).unwrap();
    });
    let drive = drive.unwrap();
    assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
    let seconds: Vec<f64> = drive.times.iter().map(|t| t.seconds_since(drive.times[0])).collect();
    let expected = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 1.5, 1.6, 1.7];
    assert!(
        seconds.len() == 9 && seconds.iter().zip(expected).all(|(a, b)| near(*a, b, 1e-6)),
        "{seconds:?}"
    );
    let m = &drive.ego.as_ref().unwrap().motion;
    for (i, t) in expected.iter().enumerate() {
        let turned = whyroad_ingest::angles::wrap_angle((179.0 + 10.0 * t).to_radians());
        assert!(near(m.heading[i], turned, 1e-5), "at {t} s: {} for {turned}", m.heading[i]);
        // The middle is 1.5 m ahead of the axle, interpolated between samples that turn by at most 1.5 degrees.
        assert!(near(m.x[i], -10.0 * t + 1.5 * turned.cos(), 1e-3));
    }
}

#[test]
fn what_nobody_can_guess_is_asked_for() {
    for (change, code, part) in [
        (("drive.yaml", "source: example-van\n", ""), "table.meta.invalid", "'source' is missing"),
        (
            ("drive.yaml", "  reference_to_centre_m: 1.5   # the pose is that of the rear axle\n", ""),
            "table.meta.invalid",
            "'ego.reference_to_centre_m' is missing",
        ),
        (("drive.yaml", "2026-01-15T10:30:00.000Z", "yesterday"), "table.meta.invalid", "start_time"),
        (("drive.yaml", "ego:\n", "ego: [\n"), "table.meta.invalid", "it cannot be read"),
        (
            ("drive.yaml", "reference_to_centre_m: 1.5", "reference_to_centre_m: 14"),
            "table.meta.invalid",
            "not on the car",
        ),
        (
            ("drive.yaml", "reference_to_centre_m: 1.5", "reference_to_centre_m: 1,5"),
            "table.meta.invalid",
            "'1,5'",
        ),
    ] {
        let (drive, report) = changed(|dir| edit(dir, change.0, change.1, change.2));
        assert!(drive.is_none(), "{change:?}");
        assert_eq!(codes(&report), [code], "{change:?}");
        let d = &report.diagnostics[0];
        assert!(d.message.en.contains(part) && d.severity == Severity::Error, "{d:?}");
    }
    let (drive, report) = changed(|dir| fs::remove_file(dir.join("ego.csv")).unwrap());
    assert!(drive.is_none() && codes(&report) == ["table.ego.missing"]);
    let (drive, report) = changed(|dir| {
        ["lanes", "areas", "lights", "context"]
            .iter()
            .for_each(|f| fs::remove_file(dir.join(format!("{f}.csv"))).unwrap())
    });
    let missing = drive.unwrap().meta.missing;
    assert!(
        codes(&report).is_empty()
            && ["map", "traffic lights", "weather and surface"]
                .iter()
                .all(|m| missing.iter().any(|x| x.id() == *m))
    );
}

/// What a table says that cannot be is reported, and counts as unknown: never as none, zero or infinite.
#[test]
fn what_contradicts_itself_is_reported() {
    // A row that was cut off costs itself.
    let (drive, report) = changed(|dir| {
        let text = fs::read_to_string(dir.join("objects.csv")).unwrap();
        fs::write(dir.join("objects.csv"), &text[..text.trim_end().rfind(',').unwrap() - 20]).unwrap();
    });
    assert!(drive.is_some_and(|d| d.tracks.len() == 2) && codes(&report) == ["table.row.dropped"]);
    // Columns in another form.
    let (drive, report) = changed(|dir| {
        let text = fs::read_to_string(dir.join("ego.csv")).unwrap();
        fs::write(dir.join("ego.csv"), text.replace(',', ";")).unwrap();
    });
    assert!(drive.is_none() && codes(&report) == ["table.file.unreadable"]);
    assert!(report.diagnostics[0].message.en.contains("separated by semicolons"), "{:?}", report.diagnostics);
    // A header alone says that there are no lights; rows that cannot be used say nothing.
    let header = |dir: &Path, file: &str| {
        let text = fs::read_to_string(dir.join(file)).unwrap();
        fs::write(dir.join(file), text.lines().next().unwrap()).unwrap();
    };
    let (drive, report) = changed(|dir| header(dir, "lights.csv"));
    assert!(drive.is_some_and(|d| d.lights.is_some_and(|states| states.is_empty())));
    assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
    let (drive, report) =
        changed(|dir| fs::write(dir.join("lights.csv"), "time_s,lane_id,colour\n,east-1,red\n").unwrap());
    assert!(drive.is_some_and(|d| d.lights.is_none() && d.meta.missing.contains(&Need::TrafficLights)));
    assert_eq!(codes(&report), ["table.row.dropped", "table.file.empty"]);
    let (drive, report) = changed(|dir| header(dir, "ego.csv"));
    assert!(drive.is_none() && codes(&report) == ["table.file.empty"]);
    // Another name, or another form, of a table.
    for name in ["object.csv", "objects.csv.gz", "Objects.CSV", "objects.tsv"] {
        let (drive, report) = changed(|dir| fs::rename(dir.join("objects.csv"), dir.join(name)).unwrap());
        assert!(drive.is_some_and(|d| d.meta.missing.contains(&Need::Objects)), "{name}");
        assert_eq!(codes(&report), ["table.file.unread"], "{name}");
    }
    let (_, report) = changed(|dir| fs::write(dir.join("notes.csv"), "a\n").unwrap());
    assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
    // Seconds since 1970.
    let (drive, report) =
        changed(|dir| edit(dir, "drive.yaml", "2026-01-15T10:30:00.000Z", "1990-01-15T10:30:00.000Z"));
    assert!(drive.is_some() && codes(&report).is_empty());
    let (drive, report) = changed(|dir| {
        let text = fs::read_to_string(dir.join("ego.csv")).unwrap();
        let late = text.lines().enumerate().map(|(i, line)| match line.split_once(',') {
            Some((time, rest)) if i > 0 => format!("{},{rest}\n", 1.77e9 + time.parse::<f64>().unwrap()),
            _ => format!("{line}\n"),
        });
        fs::write(dir.join("ego.csv"), late.collect::<String>()).unwrap();
    });
    assert!(drive.is_none() && codes(&report) == ["table.time.epoch"]);
    // A size that is none.
    let (drive, report) = changed(|dir| edit(dir, "objects.csv", ",4.5,", ",-4.5,"));
    assert!(drive.is_some_and(|d| d.track(&"car-1".into()).unwrap().length_m[0].is_nan()));
    assert_eq!(codes(&report), ["table.cell.invalid"]);
}

/// Rows of objects at times without a frame are not in the lake, and not counted as if they were.
#[test]
fn objects_behind_the_last_pose_are_counted_apart() {
    let (drive, report) = changed(|dir| {
        // The ego's log ends after 2 s, at 20 rows per second.
        let text = fs::read_to_string(dir.join("ego.csv")).unwrap();
        let first: Vec<&str> = text.lines().take(42).collect();
        fs::write(dir.join("ego.csv"), first.join("\n")).unwrap();
    });
    let drive = drive.unwrap();
    let stored: usize = drive.tracks.iter().map(|t| t.frames.len()).sum();
    let count = report.tables.iter().find(|t| t.table == "objects").unwrap();
    assert!(count.adds_up() && count.kept_total() == stored, "{count:?}, {stored} in the drive");
}

/// The example's tables count seconds; only its drive file says when they begin.
#[test]
fn without_a_start_time_the_date_is_missing() {
    assert!(!changed(|_| ()).0.unwrap().meta.missing.contains(&Need::Date));
    let (drive, _) = changed(|dir| edit(dir, "drive.yaml", "start_time: 2026-01-15T10:30:00.000Z\n", ""));
    assert!(drive.unwrap().meta.missing.contains(&Need::Date));
}

#[test]
fn a_lake_is_not_taken_for_tables() {
    let dir = tempfile::tempdir().unwrap();
    let (drive, _) = table::read(&example(), &Options::default());
    let lake = whyroad_lake::Lake::create_or_open(dir.path()).unwrap();
    lake.write_drive(&drive.unwrap()).unwrap();
    assert!(table::find_drives(dir.path()).is_empty());
}

/// The first column of every row of a file.
fn retime(dir: &Path, file: &str, to: impl Fn(f64) -> f64) {
    let text = fs::read_to_string(dir.join(file)).unwrap();
    let rows = text.lines().enumerate().map(|(i, line)| match line.split_once(',') {
        Some((time, rest)) if i > 0 => format!("{},{rest}\n", to(time.parse().unwrap())),
        _ => format!("{line}\n"),
    });
    fs::write(dir.join(file), rows.collect::<String>()).unwrap();
}

/// Objects an hour later than the ego: none can be placed, and they are unknown, not absent.
#[test]
fn objects_of_another_clock_are_unknown() {
    let lake = tempfile::tempdir().unwrap();
    let dir = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(example()).unwrap().flatten() {
        fs::copy(entry.path(), dir.path().join(entry.file_name())).unwrap();
    }
    retime(dir.path(), "objects.csv", |t| t + 3600.0);
    let (sources, _) = find_sources(None, &[dir.path().to_owned()]);
    let lake = whyroad_lake::Lake::create_or_open(lake.path()).unwrap();
    let report = whyroad_ingest::ingest(&sources[0], &Options::default(), &lake);
    assert!(codes(&report).contains(&"ingest.objects.unused"), "{:?}", report.diagnostics);
    assert!(report.missing.contains(&Need::Objects) && report.lost_input());
}

/// A clock that is set back by 2 s in the middle: those rows are lost and counted, none is put between others.
#[test]
fn a_clock_that_is_set_back_is_reported() {
    let (drive, report) = changed(|dir| retime(dir, "ego.csv", |t| if t > 3.0 { t - 2.0 } else { t }));
    let count = report.tables.iter().find(|t| t.table == "ego").unwrap();
    // 20 rows from 3.05 s on, of which the last ones do not come after 3 s again.
    assert_eq!(count.dropped["out_of_order"], 20);
    assert!(report.lost_input() && codes(&report).contains(&"table.row.dropped"), "{:?}", report.diagnostics);
    let x = drive.unwrap().ego.unwrap().motion.x;
    assert!(x.windows(2).all(|w| w[1] > w[0]), "{x:?}");
}

/// Milliseconds in `time_s`: 0.05 s become 50 s; a drive of hours is not invented.
#[test]
fn times_in_another_unit_are_refused() {
    let (drive, report) = changed(|dir| retime(dir, "ego.csv", |t| t * 1000.0));
    assert!(drive.is_none() && codes(&report).contains(&"ingest.time.step"), "{:?}", report.diagnostics);
}

/// A road without crosswalks, stop lines and ramps: unknown, unless the map is declared to have all of them
/// (`docs/reference/table-format.md`).
#[test]
fn a_layer_may_be_complete_and_empty() {
    use whyroad_model::road_map::{LayerState, MapLayer};
    let layers = |declared: &str| {
        let (drive, report) = changed(|dir| {
            if dir.join("areas.csv").exists() {
                fs::remove_file(dir.join("areas.csv")).unwrap();
            }
            edit(dir, "drive.yaml", "licence:", &format!("{declared}licence:"));
        });
        assert!(codes(&report).is_empty(), "{:?}", report.diagnostics);
        let map = drive.unwrap().map.unwrap();
        ([MapLayer::Crosswalks, MapLayer::StopLines, MapLayer::Ramps].map(|l| map.layer(l)), map.complete_for)
    };
    let (found, kinds) = layers("map_complete_for: [crosswalks, ramps]\n");
    assert_eq!(found, [LayerState::Complete, LayerState::Absent, LayerState::Complete]);
    assert_eq!(kinds, ["acceleration", "deceleration", "ramp"]);
}

#[test]
fn every_word_of_the_closed_lists_comes_through() {
    let words = |known: &[&str]| known.iter().map(|w| (*w).to_owned()).collect::<Vec<String>>();
    let (drive, report) = changed(|dir| {
        edit(dir, "drive.yaml", "licence:", "map_complete_for: [tunnel, stop]\nlicence:");
        edit(dir, "lanes.csv", "speed_limit_mps\n", "speed_limit_mps,tags\n");
        edit(dir, "lanes.csv", "false,13.89\n", &format!("false,13.89,{}\n", LANE_TAGS.join("; ")));
        edit(dir, "lanes.csv", "false,13.89\n", "false,13.89,\n");
        let mut areas = String::from("area_id,kind,boundary_xyz_m\n");
        FACILITY_KINDS.iter().for_each(|k| areas += &format!("{k},{k},0 0; 1 0; 1 1\n"));
        fs::write(dir.join("areas.csv"), areas).unwrap();
        let mut signs = String::from("sign_id,kind,x_m,y_m,lane_ids,value\n");
        SIGN_KINDS.iter().for_each(|k| signs += &format!("{k},{k},50,-3,east-1,8.33\n"));
        fs::write(dir.join("signs.csv"), signs).unwrap();
        let mut context = String::from("time_s,kind,value\n");
        for (i, (kind, values)) in CONTEXT_KINDS.iter().enumerate() {
            let values = match values {
                ContextValues::Words(words) => words.to_vec(),
                ContextValues::Number(_) => vec!["12.5"],
            };
            values.iter().for_each(|v| context += &format!("0.{i:02},{kind},{v}\n"));
        }
        fs::write(dir.join("context.csv"), context).unwrap();
    });
    assert!(codes(&report).is_empty() && !report.lost_input(), "{:?}", report.diagnostics);
    let drive = drive.unwrap();
    let map = drive.map.as_ref().unwrap();
    assert_eq!(map.lane("east-1").unwrap().tags, words(LANE_TAGS));
    let sorted = |mut v: Vec<String>| {
        v.sort();
        v
    };
    assert_eq!(
        map.facilities.iter().map(|f| f.kind.clone()).collect::<Vec<_>>(),
        sorted(words(FACILITY_KINDS))
    );
    assert_eq!(map.signs.iter().map(|s| s.kind.clone()).collect::<Vec<_>>(), sorted(words(SIGN_KINDS)));
    assert_eq!((map.signs[0].value, map.signs[0].lane_ids[0].as_str()), (Some(8.33), "east-1"));
    assert_eq!(map.complete_for, ["stop", "tunnel"]);
    let count: usize = CONTEXT_KINDS
        .iter()
        .map(|(_, v)| match v {
            ContextValues::Words(w) => w.len(),
            ContextValues::Number(_) => 1,
        })
        .sum();
    assert_eq!(drive.context.unwrap().len(), count);
}

#[test]
fn words_in_no_list_are_told_and_end_what_was_known() {
    let (drive, report) = changed(|dir| {
        edit(dir, "areas.csv", "bump,speed_bump", "bump,speedbump");
        edit(dir, "lanes.csv", "speed_limit_mps\n", "speed_limit_mps,tags\n");
        edit(dir, "lanes.csv", "false,13.89\n", "false,13.89,ramp; acceleratoin\n");
        edit(dir, "lanes.csv", "false,13.89\n", "false,13.89,\n");
        let rows =
            "time_s,kind,value\n0,weather,rain\n1,weather,hail\n0,mood,good\n0,visibility,far\n2,weather,\n";
        fs::write(dir.join("context.csv"), rows).unwrap();
    });
    let drive = drive.unwrap();
    let told: Vec<(String, String)> = report
        .diagnostics
        .iter()
        .filter(|d| d.code == "table.word.unknown")
        .map(|d| (d.message.en.clone(), d.hint.as_ref().unwrap().en.clone()))
        .collect();
    for (word, hint) in [
        ("'speedbump'", "'speed_bump'"),
        ("'acceleratoin'", "'acceleration'"),
        ("'hail'", "clear, rain, snow, fog"),
        ("'mood'", "weather, visibility"),
    ] {
        assert!(told.iter().any(|(m, h)| m.contains(word) && h.contains(hint)), "{word}: {told:?}");
    }
    assert!(report.lost_input() && codes(&report).contains(&"table.cell.invalid"));
    let map = drive.map.as_ref().unwrap();
    assert!(map.facilities.is_empty() && map.lane("east-1").unwrap().tags == ["ramp"]);
    let context: Vec<(String, String)> =
        drive.context.unwrap().into_iter().map(|c| (c.kind, c.value)).collect();
    let unknown = "unknown".to_owned();
    assert_eq!(
        context,
        [
            ("visibility".into(), unknown.clone()),
            ("weather".into(), "rain".into()),
            ("weather".into(), unknown.clone()),
            ("weather".into(), unknown)
        ]
    );
}

#[test]
fn the_guides_name_every_word() {
    for page in
        ["docs/reference/table-format.md", "docs/reference/table-format.zh.md", "docs/reference/lake.md"]
    {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(page);
        let text = fs::read_to_string(path).unwrap();
        let mut words: Vec<&str> =
            [LANE_TAGS, FACILITY_KINDS, SIGN_KINDS].into_iter().flatten().copied().collect();
        for (kind, values) in CONTEXT_KINDS {
            words.push(kind);
            if let ContextValues::Words(list) = values {
                words.extend_from_slice(list);
            }
        }
        let missing: Vec<_> = words.into_iter().filter(|w| !text.contains(w)).collect();
        assert!(missing.is_empty(), "{page} lacks {missing:?}");
    }
}
