//! ROS 1 bags written by the library rosbags (`tests/fixtures/rosbag/make.py`): one drive in plain, bz2 and lz4 chunks.
//! Expected values are its closed form.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, SourceReport, find_sources, mcap, rosbag};
use whyroad_model::{Drive, ObjectClass};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/rosbag").join(name)
}

fn options() -> Options {
    Options::default().with(&mcap::MAPPING, fixture("tracks.yaml"))
}

fn read(path: &Path) -> (Option<Drive>, SourceReport) {
    let (drive, report) = rosbag::read(path, &options());
    assert!(report.tables.iter().all(|t| t.adds_up()), "{:?}", report.tables);
    (drive, report)
}

fn codes(r: &SourceReport) -> Vec<&'static str> {
    r.diagnostics.iter().map(|d| d.code).collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3
}

#[test]
fn the_same_drive_in_all_three_kinds_of_chunks() {
    let mut tables = Vec::new();
    for name in ["plain.bag", "bz2.bag", "lz4.bag"] {
        let (drive, report) = read(&fixture(name));
        assert_eq!(codes(&report), ["ingest.rate.resampled"], "{name}: {:?}", report.diagnostics);
        let drive = drive.unwrap();
        assert_eq!((drive.times.len(), drive.times[0].0), (21, 1_700_000_000_000_000_000));
        assert_eq!(
            (drive.meta.format.as_str(), drive.meta.drive_id.as_str()),
            ("rosbag", name.trim_end_matches(".bag"))
        );
        let (ego, car) = (&drive.ego.as_ref().unwrap().motion, drive.track(&"1".into()).unwrap());
        assert!(car.class == ObjectClass::Car && near(car.length_m[0], 4.5) && near(car.width_m[0], 1.8));
        for i in 0..21 {
            let a = 0.02 * i as f64;
            let (x, y) = (50.0 * a.sin(), 50.0 - 50.0 * a.cos());
            assert!(near(ego.x[i], x) && near(ego.y[i], y) && near(ego.heading[i], a), "{name} {i}");
            assert!(near(ego.vx[i], 10.0 * a.cos()) && near(ego.vy[i], 10.0 * a.sin()), "{name} {i}");
            let want = (x + 20.0 * a.cos() - 3.0 * a.sin(), y + 20.0 * a.sin() + 3.0 * a.cos());
            assert!(near(car.motion.x[i], want.0) && near(car.motion.y[i], want.1), "{name} {i}");
        }
        tables.push(format!("{:?}", (&drive.ego, &drive.tracks)));
    }
    assert!(tables.iter().all(|t| *t == tables[0]));
}

#[test]
fn damage_is_reported_with_its_position_and_the_rest_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bag");
    for name in ["plain.bag", "bz2.bag", "lz4.bag"] {
        let bytes = fs::read(fixture(name)).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let (drive, report) = read(&path);
        let broken = report.diagnostics.iter().find(|d| d.code == "rosbag.file.broken").unwrap();
        assert!(broken.message.en.contains("at byte"), "{}", broken.message.en);
        assert!(drive.unwrap().times.len() >= 5, "{name}");
    }
    // A changed bit in the middle of a chunk: that chunk is named, the others are read.
    let mut bytes = fs::read(fixture("bz2.bag")).unwrap();
    let middle = bytes.windows(3).enumerate().filter(|(_, w)| *w == b"BZh").map(|(i, _)| i).nth(3).unwrap();
    bytes[middle + 200] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let (drive, report) = read(&path);
    let said = &report.diagnostics.iter().find(|d| d.code == "rosbag.file.broken").unwrap().message.en;
    assert!(said.contains("the chunk at byte"), "{said}");
    // About a ninth of the bag is lost.
    assert!(drive.is_some() && (80..101).contains(&report.tables[0].read), "{:?}", report.tables);

    fs::write(&path, b"#ROSBAG V1.2\n").unwrap();
    let (drive, report) = read(&path);
    assert!(drive.is_none() && codes(&report) == ["rosbag.file.broken", "mcap.ego.missing"]);
}

#[test]
fn a_size_that_is_a_lie_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.bag");
    let field = |name: &str, value: &[u8]| {
        let both = [name.as_bytes(), b"=", value].concat();
        [(both.len() as u32).to_le_bytes().as_slice(), &both].concat()
    };
    let header =
        [field("op", &[5]), field("compression", b"bz2"), field("size", &u32::MAX.to_le_bytes())].concat();
    let record =
        [(header.len() as u32).to_le_bytes().as_slice(), &header, &4_u32.to_le_bytes(), b"BZh9"].concat();
    fs::write(&path, [b"#ROSBAG V2.0\n".as_slice(), &record].concat()).unwrap();
    let said = &read(&path).1.diagnostics[0].message.en.clone();
    assert!(said.contains("the chunk at byte 13") && said.contains("4294967295 bytes"), "{said}");
}

#[test]
fn bags_are_found() {
    let (sources, _) = find_sources(None, &[fixture("")]);
    let formats: Vec<_> = sources.iter().map(whyroad_ingest::Source::format).collect();
    assert_eq!(formats, ["rosbag"; 3]);
}
