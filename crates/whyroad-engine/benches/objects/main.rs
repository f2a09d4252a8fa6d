//! Questions about any object: from scene tables to episodes, per object and frame, against two plain implementations
//! that are run now: loops over all pairs in Rust (`plain`), and NumPy in the way of RefAV (`peer.py`: a loop over
//! pairs and time stamps; without reading files). Prints ratios. `cargo bench -p whyroad-engine --bench objects`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "a bench prints, and may panic")]

mod plain;

use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::io::Write as _;
use std::process::Command;
use std::time::{Duration, Instant};
use whyroad_engine::objects::signals_for;
use whyroad_mining::fast::{Plan, Signals, find_all};
use whyroad_mining::language::Subject;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::scene::{Drive, Ego, Motion, Track};
use whyroad_model::{Nanos, ObjectClass, ScenarioId};
use whyroad_signals::Catalog;

const FRAMES: usize = 200;
const OBJECTS: usize = 75;

/// Name, kind of target, rule.
const QUESTIONS: [(&str, &str, &str); 3] = [
    ("bicycle to the right", "vehicle", "exists(pair.sector == right, bicycle)"),
    ("two vehicles within 10 m", "any", "count(pair.distance <= 10 m, vehicle) >= 2"),
    (
        "facing a pedestrian",
        "vehicle",
        "exists(abs(pair.bearing) <= 22.5 deg and pair.distance <= 50 m, pedestrian)",
    ),
];

fn crowd() -> Drive {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut motion = |speed: f64| {
        let (x, y, h) = (200.0 * random() - 100.0, 80.0 * random() - 40.0, TAU * random() - PI);
        let mut m = Motion::default();
        for i in 0..FRAMES {
            let t = i as f64 * 0.1;
            m.x.push(x + speed * t * h.cos());
            m.y.push(y + speed * t * h.sin());
            m.z.push(0.0);
            m.heading.push(h);
            m.vx.push(speed * h.cos());
            m.vy.push(speed * h.sin());
            m.accel.push(0.0);
            m.yaw_rate.push(0.0);
        }
        m
    };
    let mut drive = Drive {
        times: (0..FRAMES as i64).map(|i| Nanos(i * 100_000_000)).collect(),
        ego: Some(Ego { length_m: 4.8, width_m: 2.0, height_m: 1.5, motion: motion(5.0), ..Ego::default() }),
        ..Drive::default()
    };
    for i in 0..OBJECTS {
        let (class, length, width, speed) = [
            (ObjectClass::Car, 4.5, 1.9, 6.0),
            (ObjectClass::Pedestrian, 0.6, 0.6, 1.2),
            (ObjectClass::Bicycle, 1.8, 0.6, 4.0),
            (ObjectClass::Car, 4.3, 1.8, 0.0),
        ][i % 4];
        drive.tracks.push(Track {
            id: format!("{i:03}").as_str().into(),
            class,
            frames: (0..FRAMES as u32).collect(),
            motion: motion(speed),
            length_m: vec![length; FRAMES],
            width_m: vec![width; FRAMES],
            height_m: vec![1.5; FRAMES],
            ..Track::default()
        });
    }
    drive
}

/// The best of several runs.
fn timed(runs: usize, mut work: impl FnMut()) -> Duration {
    let once = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    (0..runs).map(|_| once(&mut work)).min().unwrap()
}

fn main() {
    let drive = crowd();
    let rows = ((OBJECTS + 1) * FRAMES) as f64;
    let mut csv = tempfile::NamedTempFile::new().unwrap();
    plain::write_csv(&drive, csv.as_file_mut()).unwrap();
    csv.flush().unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/objects/peer.py");
    println!(
        "{} objects, {FRAMES} frames; ns per object and frame, derivation of signals included",
        OBJECTS + 1
    );
    println!(
        "{:<26} {:>8} {:>12} {:>12} {:>8} {:>8}",
        "question", "whyroad", "plain Rust", "NumPy", "ratio", "ratio"
    );
    for (k, (name, target, text)) in QUESTIONS.iter().enumerate() {
        let class = ScenarioId::custom("bench");
        let rule =
            compile_text(text, Subject::from_word(target), &class, Catalog::bundled(), "bench").unwrap();
        let ours = timed(5, || {
            let table =
                signals_for(&rule, || Ok(drive.clone()), || unreachable!("no other signals")).unwrap();
            let plan = Plan::of_rules([&rule]);
            black_box(find_all(&plan, &Signals::of_table(&table)));
        });
        let plain = timed(3, || drop(black_box(plain::answer(&drive, k))));
        let per_row = |d: Duration| d.as_secs_f64() * 1e9 / rows;
        let peer = Command::new("python3").args([script, &k.to_string()]).arg(csv.path()).output();
        let seconds = peer
            .ok()
            .filter(|o| o.status.success())
            .and_then(|o| String::from_utf8(o.stdout).ok()?.trim().parse::<f64>().ok());
        let (a, b) = (per_row(ours), per_row(plain));
        let of_peer = seconds.map(|s| s * 1e9 / rows);
        let shown = |x: Option<f64>| x.map_or("no NumPy".to_owned(), |x| format!("{x:.0}"));
        println!(
            "{name:<26} {a:>8.0} {b:>12.0} {:>12} {:>7.1}x {:>8}",
            shown(of_peer),
            b / a,
            of_peer.map_or("-".to_owned(), |p| format!("{:.0}x", p / a)),
        );
    }
}
