//! The recorded comma2k19 segment, where it is present, against numbers that NumPy gets from the same arrays (states:
//! from cantools' decoding of the raw CAN), and copies of it with one thing wrong each.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, START, SourceReport, comma2k19, find_sources};
use whyroad_model::scene::TurnSignal;
use whyroad_model::{Drive, Nanos, Need, ObjectClass, Severity};

fn data(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = root.join(path);
    if !path.exists() {
        crate::require::skipped("recorded", "no recorded data");
        return None;
    }
    Some(path)
}

fn route() -> Option<PathBuf> {
    data("comma2k19/Example_1/b0c9d2329ad1606b|2018-08-02--08-34-47")
}

fn toyota() -> Options {
    match data("opendbc/_toyota_2017.dbc") {
        Some(file) => Options::default().with(&comma2k19::DBC, file),
        None => Options::default(),
    }
}

fn read() -> Option<(Drive, SourceReport)> {
    let (drive, report) = comma2k19::read(&route()?, &toyota());
    Some((drive.unwrap(), report))
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// Median and mean of squares in one pass over pairs.
fn ratio_and_rms(a: &[f64], b: &[f64]) -> (f64, f64) {
    let mut ratios: Vec<f64> = a.iter().zip(b).map(|(a, b)| a / b).filter(|r| r.is_finite()).collect();
    ratios.sort_by(f64::total_cmp);
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).filter(|s| s.is_finite()).collect();
    (ratios[ratios.len() / 2], (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

#[test]
fn a_route_is_found_and_every_row_accounted_for() {
    let Some(route) = route() else { return };
    // From the data set's folder, without being told the format; the same from the one segment.
    let (sources, problems) = find_sources(None, &[route.parent().unwrap().to_owned()]);
    assert!(problems.is_empty());
    assert_eq!(sources.iter().map(|s| (s.format(), &s.path)).collect::<Vec<_>>(), [("comma2k19", &route)]);
    let Some((drive, report)) = read() else { return };
    let (of_segment, _) = comma2k19::read(&route.join("40"), &toyota());
    assert_eq!(of_segment.unwrap().meta, drive.meta);

    assert_eq!(drive.meta.drive_id.as_str(), "b0c9d2329ad1606b-2018-08-02--08-34-47_40");
    // 1200 poses at 20 Hz, 59.949 s: 600 frames; 10100 radar returns, 148 targets by slot and new_track (NumPy).
    assert_eq!(drive.frame_count(), 600);
    let read_rows: Vec<_> = report.tables.iter().map(|t| (t.table, t.read, t.dropped_total())).collect();
    assert_eq!(read_rows, [("pose", 1200, 0), ("radar", 10100, 0)]);
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    // GPS week 2012, second 404106.397, less 18 leap seconds (Python's datetime).
    assert_eq!(drive.times[0].to_string(), "2018-08-02T16:14:48.397Z");
    assert!(drive.times.windows(2).all(|w| near(w[1].seconds_since(w[0]), 0.1, 1e-6)));
}

#[test]
fn the_ego_moves_as_its_pose_and_its_wheels_say() {
    let Some((drive, _)) = read() else { return };
    let ego = drive.ego.unwrap();
    let m = &ego.motion;
    // NumPy: ECEF to east, north, up at 37.72100001 N 122.47229909 W, interpolated at the frames.
    for (i, [x, y, z], speed) in [
        (0, [0.0, 0.0, 0.0], 7.9411),
        (100, [5.842, 147.413, -4.833], 19.9799),
        (300, [22.094, 521.419, -5.582], 17.0161),
        (599, [43.065, 1009.761, 7.942], 11.6254),
    ] {
        assert!(
            near(m.x[i], x, 2e-3) && near(m.y[i], y, 2e-3) && near(m.z[i], z, 2e-3),
            "frame {i}: {:?}",
            (m.x[i], m.y[i], m.z[i])
        );
        assert!(near(m.speed(i), speed, 1e-3), "frame {i}: {}", m.speed(i));
    }
    // Rotation matrix of the quaternion, first column, in the local frame (the nearest pose is within 0.5 ms).
    assert!(near(m.heading[100], 1.543_079, 1e-3) && near(m.heading[300], 1.542_994, 1e-3));
    // Along the heading, not against or across it.
    assert!((0..600).all(|i| m.forward_speed(i) > 0.99 * m.speed(i)));

    // The car's own speed reads 0.9 % low against the pose: median ratio 0.99142 and RMS 0.1554 m/s in three dimensions
    // (NumPy); ours is over ground, and the road's 5 % of slope is worth a tenth of a percent.
    let over_ground: Vec<f64> = (0..600).map(|i| m.speed(i)).collect();
    let (ratio, rms) = ratio_and_rms(&ego.bus.speed_mps, &over_ground);
    println!("CAN speed against pose: median ratio {ratio:.4}, RMS {rms:.4} m/s");
    assert!(near(ratio, 0.9914, 0.002), "{ratio}");
    assert!(near(rms, 0.1554, 0.02), "{rms}");
    assert!(near(ego.bus.speed_mps[100], 19.8330, 1e-3) && near(ego.bus.speed_mps[300], 16.8835, 1e-3));
    // np.radians(np.interp(...)) of the steering wheel's angle.
    assert!(near(ego.bus.steering[100], -0.055_619, 1e-5) && near(ego.bus.steering[599], -0.017_453, 1e-5));
}

/// `(from, to, value)` of equal consecutive values.
fn runs<T: Copy + PartialEq>(values: &[T]) -> Vec<(usize, usize, T)> {
    let mut out: Vec<(usize, usize, T)> = Vec::new();
    for (i, &v) in values.iter().enumerate() {
        match out.last_mut() {
            Some(run) if run.2 == v => run.1 = i,
            _ => out.push((i, i, v)),
        }
    }
    out
}

#[test]
fn states_of_the_bus_are_those_that_cantools_decodes() {
    let Some((drive, _)) = read() else { return };
    let bus = drive.ego.unwrap().bus;
    // The last message at or before each frame, decoded by cantools: VSC1S07.BRKON, PCM_CRUISE_SM.CRUISE_CONTROL_STATE
    // (2 disabled, 6 enabled), GEAR_PACKET.GEAR (0 D), BLINKERS_STATE.TURN_SIGNALS (3 none). Before the first message:
    // unknown.
    let (yes, no) = (Some(true), Some(false));
    let brake = [
        (0, 0, None),
        (1, 105, no),
        (106, 180, yes),
        (181, 222, no),
        (223, 248, yes),
        (249, 298, no),
        (299, 324, yes),
        (325, 562, no),
        (563, 599, yes),
    ];
    assert_eq!(runs(&bus.brake), brake);
    assert_eq!(runs(&bus.cruise), [(0, 4, None), (5, 90, no), (91, 599, yes)]);
    assert_eq!(runs(&bus.gear), [(0, 8, None), (9, 599, Some('D'))]);
    assert_eq!(runs(&bus.turn_signal), [(0, 84, None), (85, 599, Some(TurnSignal::Off))]);
    // Nothing else is on this bus: no throttle, emergency braking or route.
    assert!(bus.throttle.is_empty() && bus.aeb.is_empty() && bus.route_command.is_empty());
}

#[test]
fn radar_returns_are_where_the_radar_says() {
    let Some((drive, _)) = read() else { return };
    // NumPy: 148 targets, 5121 pairs of target and frame with a return within 0.05 s of the frame.
    assert_eq!(drive.tracks.len(), 148);
    assert_eq!(drive.tracks.iter().map(|t| t.frames.len()).sum::<usize>(), 5121);
    let ego = drive.ego.as_ref().unwrap();
    // Slot and part, frame, forward, left, relative speed: rows of the array.
    for (id, frame, forward, left, relative) in [
        ("radar_530_0000", 100, 36.66, -2.72, -2.875),
        ("radar_535_0007", 100, 72.22, -0.76, -4.125),
        ("radar_535_0007", 300, 34.42, 0.12, -2.6),
        ("radar_537_0000", 300, 52.22, -3.88, -1.45),
    ] {
        let t = drive.track(&id.into()).unwrap();
        let row = t.row_at(frame).unwrap();
        let (s, c) = ego.motion.heading[frame].sin_cos();
        let (dx, dy) = (t.motion.x[row] - ego.motion.x[frame], t.motion.y[row] - ego.motion.y[frame]);
        assert!(near(dx * c + dy * s, forward + 4.605 / 2.0, 1e-6), "{id}: forward");
        assert!(near(dy * c - dx * s, left, 1e-6), "{id}: left");
        assert!(
            near(t.motion.forward_speed(row), ego.motion.forward_speed(frame) + relative, 1e-6),
            "{id}: speed"
        );
        assert_eq!((t.class, t.length_m[row]), (ObjectClass::Unknown, 0.0));
    }
}

#[test]
fn the_lead_that_the_radar_sees_closes_as_its_relative_speed_says() {
    let Some((drive, _)) = read() else { return };
    // Two quantities of the radar that know nothing of each other (range and Doppler), brought through our frames:
    // over 52 s the integral of the relative speed is the change of distance. In the raw array the two differ by 1.71 m
    // (-59.04 m of range, -57.33 m of np.trapezoid of speed over 1055 returns); so must they here.
    let ego = drive.ego.as_ref().unwrap();
    let t = drive.track(&"radar_535_0007".into()).unwrap();
    let ahead: Vec<f64> = t
        .frames
        .iter()
        .enumerate()
        .map(|(row, &f)| {
            let f = f as usize;
            let (s, c) = ego.motion.heading[f].sin_cos();
            (t.motion.x[row] - ego.motion.x[f]) * c + (t.motion.y[row] - ego.motion.y[f]) * s
        })
        .collect();
    let relative: Vec<f64> = t
        .frames
        .iter()
        .enumerate()
        .map(|(r, &f)| t.motion.forward_speed(r) - ego.motion.forward_speed(f as usize))
        .collect();
    let n = ahead.len();
    assert!(n > 500 && t.frames.windows(2).all(|w| w[1] == w[0] + 1));
    let traveled: f64 = relative.windows(2).map(|w| (w[0] + w[1]) / 2.0 * 0.1).sum();
    assert!(
        near(ahead[n - 1] - ahead[0] - traveled, -1.71, 0.1),
        "{} against {traveled}",
        ahead[n - 1] - ahead[0]
    );
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// A copy of the segment in which `change` did something, read; the codes that it gives.
fn broken(
    options: &Options,
    change: impl Fn(&Path),
) -> Option<(Option<Drive>, SourceReport, Vec<&'static str>)> {
    let route = route()?;
    let dir = tempfile::tempdir().unwrap();
    let segment = dir.path().join("route/40");
    for part in ["global_pose", "processed_log/CAN"] {
        copy(&route.join("40").join(part), &segment.join(part));
    }
    change(&segment);
    let (drive, report) = comma2k19::read(&dir.path().join("route"), options);
    let codes = report.diagnostics.iter().map(|d| d.code).collect();
    Some((drive, report, codes))
}

#[test]
fn a_cut_array_is_named_and_the_rest_is_kept() {
    let Some((drive, report, codes)) = broken(&toyota(), |s| {
        let file = s.join("processed_log/CAN/radar/value");
        let bytes = fs::read(&file).unwrap();
        fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    }) else {
        return;
    };
    assert_eq!(codes, ["comma2k19.array.unreadable"]);
    assert!(
        report.lost_input()
            && report.diagnostics[0].location.file.as_deref().unwrap().ends_with("radar/value")
    );
    let drive = drive.unwrap();
    assert!(drive.tracks.is_empty() && drive.meta.missing.iter().any(|m| m.id() == "radar"));
    assert!(drive.ego.unwrap().bus.brake.len() == 600);
}

#[test]
fn a_missing_array_is_a_missing_signal_and_without_poses_there_is_no_drive() {
    let Some((drive, _, codes)) =
        broken(&toyota(), |s| fs::remove_dir_all(s.join("processed_log/CAN/steering_angle")).unwrap())
    else {
        return;
    };
    let drive = drive.unwrap();
    assert!(codes.is_empty() && drive.meta.missing.iter().any(|m| m.id() == "steering angle"));
    assert!(drive.ego.unwrap().bus.steering.is_empty());
    let Some((drive, report, codes)) =
        broken(&toyota(), |s| fs::remove_file(s.join("global_pose/frame_positions")).unwrap())
    else {
        return;
    };
    assert!(drive.is_none());
    assert_eq!(codes, ["comma2k19.pose.missing"]);
    assert_eq!(report.diagnostics[0].severity, Severity::Error);
}

#[test]
fn arrays_of_unequal_length_are_left_out() {
    let Some((drive, _, codes)) = broken(&toyota(), |s| {
        fs::copy(s.join("processed_log/CAN/radar/t"), s.join("processed_log/CAN/raw_can/t")).unwrap();
    }) else {
        return;
    };
    // No raw CAN is left, so the DBC cannot lead to anything either.
    assert_eq!(codes, ["comma2k19.array.shape"]);
    assert!(drive.unwrap().ego.unwrap().bus.brake.is_empty());
}

#[test]
fn a_dbc_that_is_absent_unreadable_or_of_another_car_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        fs::write(dir.path().join(name), text).unwrap();
        Options::default().with(&comma2k19::DBC, dir.path().join(name))
    };
    let foreign = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: XXX\n\nBO_ 100 DEMO: 8 XXX\n SG_ SPEED : 7|16@0- (0.01,0) [0|0] \"m/s\" XXX\n";
    for (options, code) in [
        (Options::default(), "comma2k19.dbc.missing"),
        (write("page.dbc", "<html/>"), "comma2k19.dbc.unreadable"),
        (
            Options::default().with(&comma2k19::DBC, dir.path().join("nowhere.dbc")),
            "comma2k19.dbc.unreadable",
        ),
        (write("other.dbc", foreign), "comma2k19.dbc.foreign"),
    ] {
        let Some((drive, _, codes)) = broken(&options, |_| ()) else { return };
        assert_eq!(codes, [code]);
        let drive = drive.unwrap();
        assert!(
            ["brake", "cruise", "gear", "turn signal"].iter().all(|m| drive
                .meta
                .missing
                .iter()
                .any(|x| x.id() == *m))
        );
        assert_eq!(drive.ego.unwrap().bus.speed_mps.len(), 600);
    }
}

#[test]
fn without_gps_time_the_start_is_the_one_given() {
    let start = Nanos::parse_iso("2020-02-03T04:05:06.000Z").unwrap();
    let options = toyota().with(&START, start);
    let Some((drive, _, _)) =
        broken(&options, |s| fs::remove_file(s.join("global_pose/frame_gps_times")).unwrap())
    else {
        return;
    };
    let drive = drive.unwrap();
    assert_eq!(drive.times[0], start);
    assert!(!drive.meta.missing.contains(&Need::Date));
}
