//! MCAP recordings written by the format's own libraries: ROS 2 in lz4 chunks, Foxglove's protobuf in zstd chunks, JSON
//! without chunks (`tests/fixtures/mcap/make.py`). One drive told three ways; expected values are its closed form.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, SourceReport, find_sources, mcap};
use whyroad_lake::{Lake, WriteOutcome};
use whyroad_model::scene::TurnSignal;
use whyroad_model::{Drive, ObjectClass};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/mcap").join(name)
}

fn with_mapping() -> Options {
    Options::default().with(&mcap::MAPPING, fixture("fleet.yaml"))
}

fn read(name: &str, options: &Options) -> (Drive, SourceReport) {
    let (drive, report) = mcap::read(&fixture(name), options);
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive.unwrap(), report)
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3
}

/// The ego on its circle, moved `forward` along its heading.
fn ego(t: f64, forward: f64) -> (f64, f64, f64) {
    let a = 0.2 * t;
    (50.0 * a.sin() + forward * a.cos(), 50.0 - 50.0 * a.cos() + forward * a.sin(), a)
}

fn check_ego(drive: &Drive, forward: f64) {
    let m = &drive.ego.as_ref().unwrap().motion;
    assert_eq!((drive.times.len(), drive.times[0].0), (21, 1_700_000_000_000_000_000));
    for i in 0..21 {
        let (x, y, a) = ego(i as f64 / 10.0, forward);
        assert!(near(m.x[i], x) && near(m.y[i], y) && near(m.heading[i], a), "{i}");
        assert!(
            (m.yaw_rate[i] - 0.2).abs() < 1e-3
                && (m.vx[i].hypot(m.vy[i]) - 10.0).abs() < 0.01 + 0.03 * forward
        );
    }
}

/// 20 m ahead of the ego and 3 m to its left.
fn check_car(drive: &Drive, id: &str) {
    let car = drive.track(&id.into()).unwrap();
    assert!(car.class == ObjectClass::Car && car.frames.len() == 21 && near(car.length_m[0], 4.5));
    for i in 0..21 {
        let (x, y, a) = ego(i as f64 / 10.0, 20.0);
        let want = (x - 3.0 * a.sin(), y + 3.0 * a.cos());
        assert!(
            near(car.motion.x[i], want.0) && near(car.motion.y[i], want.1) && near(car.motion.heading[i], a),
            "{i}"
        );
    }
}

#[test]
fn ros2_odometry_and_detections_in_the_cars_frame() {
    let (drive, report) = read("ros2_lz4.mcap", &Options::default());
    let drive = crate::estimated(drive);
    check_ego(&drive, 0.0);
    check_car(&drive, "1");
    // 50 Hz to 10 Hz; a topic that nothing reads; one detection has no id.
    assert_eq!(codes(&report), ["ingest.rate.resampled", "mcap.topic.unread", "mcap.rows.dropped"]);
    let objects = report.tables.iter().find(|t| t.table == "objects").unwrap();
    assert_eq!((objects.read, objects.kept["track"], objects.dropped["no_id"]), (22, 21, 1));
    assert!(drive.meta.missing.contains(&whyroad_model::Need::EgoSize));
}

#[test]
fn foxglove_messages_in_the_worlds_frame() {
    let (drive, report) = read("foxglove_zstd.mcap", &Options::default());
    let drive = crate::estimated(drive);
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    check_ego(&drive, 0.0);
    check_car(&drive, "7");
    let walker = drive.track(&"8".into()).unwrap();
    assert!(
        walker.class == ObjectClass::Pedestrian
            && near(walker.motion.vy[10], 1.5)
            && near(walker.motion.y[20], 1.0)
    );
}

#[test]
fn a_fleets_own_messages_by_a_mapping_file() {
    let (drive, report) = read("fleet.mcap", &with_mapping());
    let drive = crate::estimated(drive);
    assert!(report.diagnostics.is_empty(), "{:?}", report.diagnostics);
    check_ego(&drive, 1.4);
    let ego = drive.ego.as_ref().unwrap();
    assert!(near(ego.length_m, 4.8) && near(ego.reference_to_centre_m, 1.4));
    let bus = &ego.bus;
    assert!(
        bus.speed_mps.iter().all(|v| near(*v, 10.0))
            && bus.turn_signal.iter().all(|s| *s == Some(TurnSignal::Left))
    );
    assert_eq!((bus.brake[9], bus.brake[10], bus.gear[0]), (Some(false), Some(true), Some('D')));
    let walker = drive.track(&"8".into()).unwrap();
    assert!(
        walker.class == ObjectClass::Pedestrian
            && near(walker.motion.y[10], -0.5)
            && near(walker.width_m[0], 0.7)
    );
}

#[test]
fn without_a_mapping_the_topics_are_named_and_a_wrong_mapping_says_where() {
    let (drive, report) = mcap::read(&fixture("fleet.mcap"), &Options::default());
    assert!(drive.is_none() && codes(&report) == ["mcap.ego.missing"]);
    assert!(
        report.diagnostics[0].message.en.contains("/gps/pose (fleet.gps.pose)"),
        "{:?}",
        report.diagnostics
    );
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("m.yaml");
    fs::write(&file, "topics:\n  /a: { role: ego, postion: p }\n").unwrap();
    let (_, report) = mcap::read(&fixture("fleet.mcap"), &Options::default().with(&mcap::MAPPING, file));
    assert_eq!(codes(&report), ["mcap.mapping"]);
    assert!(report.diagnostics[0].message.en.contains("postion"), "{:?}", report.diagnostics);
}

/// A misspelled topic of objects: they are unknown, and the message names the topic that the file has.
#[test]
fn a_topic_that_is_not_in_the_file_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("m.yaml");
    let text = fs::read_to_string(fixture("fleet.yaml")).unwrap().replace("/tracks:", "/trackz:");
    fs::write(&file, text).unwrap();
    let (drive, report) = mcap::read(&fixture("fleet.mcap"), &Options::default().with(&mcap::MAPPING, file));
    assert_eq!(codes(&report), ["mcap.topic.absent", "mcap.topic.unread"]);
    assert!(report.diagnostics[0].message.en.contains("/trackz"));
    assert!(
        report.diagnostics[0].hint.as_ref().unwrap().en.contains("/tracks ("),
        "{:?}",
        report.diagnostics
    );
    let missing = drive.unwrap().meta.missing;
    assert!(missing.contains(&whyroad_model::Need::Objects));
    assert!(!read("fleet.mcap", &with_mapping()).0.meta.missing.contains(&whyroad_model::Need::Objects));
}

/// The MCAP specification: after 8 bytes of magic each record is an opcode, a length of 8 bytes and its body; a message
/// (5) has its time after a channel and a number, 2 + 4 bytes.
fn without_messages(bytes: &[u8], dropped: impl Fn(u64) -> bool) -> Vec<u8> {
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let (mut out, mut at) = (bytes[..8].to_vec(), 8);
    while at + 9 <= bytes.len() {
        let end = (at + 9 + number(at + 1) as usize).min(bytes.len());
        if bytes[at] != 5 || !dropped(number(at + 15)) {
            out.extend_from_slice(&bytes[at..end]);
        }
        at = end;
    }
    out.extend_from_slice(&bytes[at..]);
    out
}

/// docs/reference/formats.md: where the ego is missing there are no frames. At 5 Hz, without 0.9 s to 1.3 s.
#[test]
fn a_gap_of_the_ego_has_no_frames() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("gap.mcap");
    let bytes = fs::read(fixture("fleet.mcap")).unwrap();
    let tenths = |time: u64| (time - 1_700_000_000_000_000_000 + 50_000_000) / 100_000_000;
    let gap = |time: u64| tenths(time) % 2 == 1 || (9..=13).contains(&tenths(time));
    fs::write(&path, without_messages(&bytes, gap)).unwrap();
    let (drive, _) = mcap::read(&path, &with_mapping());
    let drive = drive.unwrap();
    let frames: Vec<u64> = drive.times.iter().map(|t| tenths(t.0 as u64)).collect();
    assert_eq!(frames, [0, 1, 2, 3, 4, 5, 6, 7, 8, 14, 15, 16, 17, 18, 19, 20]);
    assert!(drive.ego.unwrap().motion.x.iter().all(|x| x.is_finite()));
}

#[test]
fn what_a_cut_or_changed_file_still_has_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("cut.mcap");
    let bytes = fs::read(fixture("fleet.mcap")).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 3]).unwrap();
    let (drive, report) = mcap::read(&path, &with_mapping());
    assert!(codes(&report).contains(&"mcap.file.broken") && drive.unwrap().times.len() >= 5);

    // One bit in the middle of the only chunk: its checksum, or its compression's, tells.
    let mut bytes = fs::read(fixture("foxglove_zstd.mcap")).unwrap();
    bytes[900] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let (drive, report) = mcap::read(&path, &Options::default());
    assert!(
        drive.is_none() && codes(&report) == ["mcap.file.broken", "mcap.ego.missing"],
        "{:?}",
        report.diagnostics
    );
}

/// A file may say any size of a record or a chunk: what it does not have is not allocated.
#[test]
fn sizes_that_lie_are_refused_before_memory_is_taken() {
    let bytes = fs::read(fixture("foxglove_zstd.mcap")).unwrap();
    // The MCAP specification: after 8 bytes of magic each record is an opcode, a length of 8 bytes and its body. A
    // chunk's body has two times of 8 bytes, then the size that it unpacks to.
    let mut at = 8;
    let length = |at: usize| u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    while bytes[at] != 0x06 {
        at += 9 + length(at);
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lies.mcap");
    for place in [at + 1, at + 9 + 16] {
        for size in [u64::MAX, 1 << 62, 1 << 45, 1 << 33] {
            let mut lie = bytes.clone();
            lie[place..place + 8].copy_from_slice(&size.to_le_bytes());
            fs::write(&path, lie).unwrap();
            let (drive, report) = mcap::read(&path, &Options::default());
            assert!(drive.is_none() && codes(&report)[0] == "mcap.file.broken", "{place} {size}");
        }
    }
    // And a message of the year 1970 makes no frames of all the time since.
    let text = fs::read(fixture("fleet.mcap")).unwrap();
    let first = 1_700_000_000_000_000_000_u64.to_le_bytes();
    let found = text.windows(8).position(|w| w == first).unwrap();
    let mut old = text.clone();
    old[found..found + 8].copy_from_slice(&1_u64.to_le_bytes());
    fs::write(&path, old).unwrap();
    let (drive, report) = mcap::read(&path, &with_mapping());
    assert!(drive.is_none_or(|d| d.times.len() <= 21) || codes(&report).contains(&"ingest.time.span"));
}

#[test]
fn recordings_are_recognised_and_come_in_once() {
    let (sources, problems) = find_sources(None, &[fixture("")]);
    assert!(
        crate::only_skipped(&problems) && sources.len() == 3 && sources.iter().all(|s| s.format() == "mcap"),
        "{sources:?}"
    );
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path()).unwrap();
    let outcome = || whyroad_ingest::ingest(&sources[2], &Options::default(), &lake).outcome;
    assert_eq!((outcome(), outcome()), (Some(WriteOutcome::Written), Some(WriteOutcome::Unchanged)));
}
