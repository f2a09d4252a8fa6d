//! Criticality measures against those who define them: commonroad-crime, per vehicle and step, and SUMO's SSM device,
//! per equipped vehicle and step. `WHYROAD_PEERS=PYTHON cargo bench -p whyroad-signals --bench peers`; that Python has
//! `commonroad-crime==0.4.5`, or `eclipse-sumo==1.28.0`, or both (several Pythons are separated by `:`). Values are
//! compared by tests (`crime`, `sumo_truth`). CPU time, least of several rounds; only ratios of one run count.
#![allow(clippy::print_stdout, reason = "a bench prints")]

use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use whyroad_ingest::{Options, sumo};
use whyroad_model::scene::{Drive, Ego, Motion, Track};
use whyroad_model::{Nanos, ObjectClass};
use whyroad_signals::{Wanted, derive, derive_wanted};

/// What the scene of examples/truth/crime asks of CriMe.
const CRIME: [&str; 6] =
    ["target.gap", "target.thw", "target.ttc_accel", "target.dst", "target.a_long_req", "target.btn"];
/// What SUMO's device measures.
const SSM: [&str; 3] = ["target.ttc", "target.drac", "target.pet"];

/// Seconds of the fastest round.
fn fastest(rounds: usize, mut work: impl FnMut()) -> f64 {
    let mut once = || {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..rounds).map(|_| once()).fold(f64::INFINITY, f64::min)
}

/// Along x, at constant acceleration.
fn along(frames: usize, (x, speed, accel): (f64, f64, f64)) -> Motion {
    let mut motion = Motion::default();
    for i in 0..frames {
        let t = i as f64 * 0.1;
        motion.x.push(x + speed * t + accel * t * t / 2.0);
        motion.y.push(0.0);
        motion.z.push(0.8);
        motion.heading.push(0.0);
        motion.vx.push(speed + accel * t);
        motion.vy.push(0.0);
        motion.accel.push(accel);
        motion.yaw_rate.push(0.0);
    }
    motion
}

/// The vehicles of examples/truth/crime/make.py.
fn crime() -> Drive {
    const FRAMES: usize = 60;
    let ego = along(FRAMES, (0.0, 15.0, 0.0));
    let mut drive = Drive {
        times: (0..FRAMES as i64).map(|i| Nanos(i * 100_000_000)).collect(),
        ego: Some(Ego { length_m: 4.6, width_m: 1.8, height_m: 1.6, motion: ego, ..Ego::default() }),
        ..Drive::default()
    };
    for (id, class, length, width, motion) in [
        ("200", ObjectClass::Truck, 12.0, 2.4, (45.0, 10.0, 0.0)),
        ("300", ObjectClass::Motorcycle, 2.2, 0.9, (30.0, 17.0, 0.0)),
        ("400", ObjectClass::Car, 4.6, 1.8, (25.0, 8.0, 1.0)),
        ("500", ObjectClass::Car, 4.6, 1.8, (75.0, 14.0, -2.0)),
    ] {
        drive.tracks.push(Track {
            id: id.into(),
            class,
            frames: (0..FRAMES as u32).collect(),
            motion: along(FRAMES, motion),
            length_m: vec![length; FRAMES],
            width_m: vec![width; FRAMES],
            height_m: vec![1.6; FRAMES],
            ..Track::default()
        });
    }
    drive
}

/// The egos of the grid for which its SSM output is committed.
fn grid() -> Vec<Drive> {
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth/grid/fcd.xml.gz");
    let read = |ego: &&str| {
        let options = Options::default().with(&sumo::EGO, *ego).with(&sumo::SENSOR_RANGE, 80.0);
        sumo::read(&log, &options).0
    };
    ["g18", "g34", "g36", "g44", "g53", "g72"].iter().filter_map(read).collect()
}

/// The numbers that a script prints, by the first Python that can run it.
fn peer(script: &str) -> Option<Vec<f64>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers").join(script);
    let pythons = std::env::var("WHYROAD_PEERS").unwrap_or_else(|_| "python3".to_owned());
    pythons.split(':').find_map(|python| {
        let output = Command::new(python).arg(&script).output().ok().filter(|o| o.status.success())?;
        let text = String::from_utf8(output.stdout).ok()?;
        text.lines().last()?.split_whitespace().map(|n| n.parse().ok()).collect()
    })
}

fn row(what: &str, unit: &str, measured: Option<f64>, ours: &[(&str, f64)]) {
    for (name, seconds) in ours {
        let theirs = measured.map_or("not there".to_owned(), |s| format!("{:.2}", s * 1e6));
        let ratio = measured.map_or("-".to_owned(), |s| format!("{:.2}x", s / seconds));
        println!("{what:<20} {unit:<26} {name:<22} {:>10.2} {theirs:>12} {ratio:>12}", seconds * 1e6);
    }
}

fn main() {
    // `cargo test --benches` also runs this.
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    println!("microseconds per unit");
    println!(
        "{:<20} {:<26} {:<22} {:>10} {:>12} {:>12}",
        "peer", "unit", "asked of Whyroad", "whyroad", "peer", "peer/whyroad"
    );
    let scene = crime();
    let rows: usize = scene.tracks.iter().map(|t| t.frames.len()).sum();
    let (six, all) = (Wanted::only(CRIME), Wanted::all());
    let of = |wanted: &Wanted| fastest(50, || drop(black_box(derive_wanted(&scene, wanted)))) / rows as f64;
    row(
        "CriMe, 6 measures",
        "vehicle and step",
        peer("crime.py").map(|n| n[0]),
        &[("the same six", of(&six)), ("all signals", of(&all))],
    );
    let drives = grid();
    let steps: usize = drives.iter().map(|d| d.times.len()).sum();
    let rows: usize = drives.iter().flat_map(|d| &d.tracks).map(|t| t.frames.len()).sum();
    let three = Wanted::only(SSM);
    let some = fastest(7, || drives.iter().for_each(|d| drop(black_box(derive_wanted(d, &three)))));
    let whole = fastest(7, || drives.iter().for_each(|d| drop(black_box(derive(d)))));
    let ssm = peer("ssm.py");
    row(
        "SUMO SSM, 3 measures",
        "equipped vehicle and step",
        ssm.as_ref().map(|n| n[0]),
        &[("the same three", some / steps as f64), ("all signals", whole / steps as f64)],
    );
    println!("Whyroad: {:.1} vehicles within 80 m of an ego in the mean", rows as f64 / steps as f64);
    if let Some(n) = ssm {
        println!("SUMO: {:.1} vehicles on the whole network in the mean", n[1]);
    }
}
