//! Adds tiny synthetic drives to a lake, to see how a lake of many drives behaves:
//!
//! ```text
//! cargo run --release -p whyroad-lake --example tiny_drives -- LAKE COUNT [FIRST]
//! ```
//!
//! A drive has 3 s, an ego and two vehicles, of which one is ahead and slower; five places, a drive every minute.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)] // a failure ends the program

use std::sync::atomic::{AtomicU64, Ordering};
use whyroad_lake::Lake;
use whyroad_model::scene::{DriveMeta, Ego, EgoBus, Motion, Track};
use whyroad_model::{Drive, DriveId, Nanos, ObjectClass};

const FRAMES: usize = 30;
const PLACES: [&str; 5] = ["Aachen", "Bremen", "Celle", "Dresden", "Emden"];
/// 2026-01-01.
const START_NS: i64 = 1_767_225_600_000_000_000;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| arguments.get(i).map(|text| text.parse::<u64>().unwrap());
    let (Some(dir), Some(count)) = (arguments.first(), number(1)) else {
        eprintln!("usage: tiny_drives LAKE COUNT [FIRST]");
        return;
    };
    let first = number(2).unwrap_or(0);
    let lake = Lake::create_or_open(dir).unwrap();
    let next = AtomicU64::new(first);
    let cores = std::thread::available_parallelism().unwrap().get();
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= first + count {
                        break;
                    }
                    lake.write_drive(&drive(i)).unwrap();
                }
            });
        }
    });
    println!("{} drives", lake.drive_ids().len());
}

fn drive(i: u64) -> Drive {
    let start = START_NS + i64::try_from(i).unwrap() * 60_000_000_000;
    // Gaps from 15 to 45 m and speeds from 6 to 14 m/s: some of the drives have something to find.
    let (gap, speed) = (15.0 + (i % 31) as f64, 6.0 + (i % 9) as f64);
    Drive {
        meta: DriveMeta {
            drive_id: DriveId(format!("tiny-{i:07}")),
            format: "synthetic".into(),
            source: "tiny_drives".into(),
            place: Some(PLACES[(i % 5) as usize].into()),
            licence: Some("CC0-1.0".into()),
            content_hash: format!("{i:032x}"),
            ..DriveMeta::default()
        },
        times: (0..FRAMES as i64).map(|f| Nanos(start + f * 100_000_000)).collect(),
        ego: Some(Ego {
            length_m: 4.6,
            width_m: 1.9,
            height_m: 1.5,
            reference_to_centre_m: 0.0,
            motion: along(0.0, 0.0, speed),
            bus: EgoBus::default(),
            known_at: vec![],
        }),
        tracks: vec![track("ahead", along(gap, 0.0, speed - 4.0)), track("beside", along(5.0, 3.5, speed))],
        ..Drive::default()
    }
}

fn along(x: f64, y: f64, speed: f64) -> Motion {
    Motion {
        x: (0..FRAMES).map(|f| x + speed * f as f64 * 0.1).collect(),
        y: vec![y; FRAMES],
        z: vec![0.0; FRAMES],
        heading: vec![0.0; FRAMES],
        ..Motion::unknown(FRAMES)
    }
}

fn track(id: &str, motion: Motion) -> Track {
    let n = motion.x.len();
    Track {
        id: id.into(),
        class: ObjectClass::Car,
        frames: (0..).take(n).collect(),
        motion,
        length_m: vec![4.5; n],
        width_m: vec![1.8; n],
        height_m: vec![1.5; n],
        interior_points: vec![f64::NAN; n],
        ..Track::default()
    }
}
