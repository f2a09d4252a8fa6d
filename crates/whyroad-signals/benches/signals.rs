//! Speed of deriving signals from a drive, by number of objects: `cargo bench -p whyroad-signals --bench signals`.
//! Reports rows (an object in a frame) per second on one core, and the ratio to reading the same drive from its log in
//! the same run. It has no harness: it reports the fastest of several rounds, because on a shared machine other
//! measures include the load of other processes. Recorded AV2 logs are included if they are present.
#![allow(clippy::print_stdout)] // printing is what a bench is for

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;
use whyroad_ingest::{Options, find_sources, read, sumo};
use whyroad_model::Drive;

fn milliseconds(f: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    f();
    start.elapsed().as_secs_f64() * 1e3
}

/// `drive` with every track copied until there are `objects`, each copy some meters farther along the world's x: they
/// overlap, but each costs as much as a separate object.
fn crowded(drive: &Drive, objects: usize) -> Drive {
    let mut crowd = drive.clone();
    let own = drive.tracks.len().max(1);
    crowd.tracks.clear();
    for k in 0..objects {
        let mut track = drive.tracks[k % own].clone();
        let copy = k / own;
        track.id = format!("{}_{copy}", track.id.as_str()).as_str().into();
        track.motion.x.iter_mut().for_each(|x| *x += 3.0 * copy as f64);
        crowd.tracks.push(track);
    }
    crowd.tracks.sort_by(|a, b| a.id.cmp(&b.id));
    crowd
}

fn measure(name: &str, drive: &Drive, reading_ms: Option<f64>, rounds: usize) {
    let rows: usize = drive.tracks.iter().map(|t| t.frames.len()).sum();
    let fastest = (0..rounds)
        .map(|_| milliseconds(&mut || drop(black_box(whyroad_signals::derive(black_box(drive))))))
        .fold(f64::INFINITY, f64::min);
    let ratio = reading_ms.map_or(String::new(), |ms| format!("{:.2}", fastest / ms));
    println!(
        "{name:<28} {:>7} {:>6} {rows:>8} {fastest:>9.1} {:>9.2} {:>11.0} {ratio:>8}",
        drive.tracks.len(),
        drive.times.len(),
        fastest * 1e3 / rows.max(1) as f64,
        rows as f64 / (fastest / 1e3),
    );
}

fn recorded() -> Vec<PathBuf> {
    let base = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let folders = std::fs::read_dir(base.join("av2/sensor_logs")).into_iter().flatten().flatten();
    let mut logs: Vec<PathBuf> = folders.map(|e| e.path()).filter(|p| p.join("map").is_dir()).collect();
    logs.sort();
    logs
}

fn main() {
    // `cargo test --benches` also runs this; one round is enough for a test.
    let quick = std::env::args().any(|a| a == "--test");
    let rounds = if quick { 1 } else { 7 };
    println!(
        "{:<28} {:>7} {:>6} {:>8} {:>9} {:>9} {:>11} {:>8}",
        "drive", "objects", "frames", "rows", "ms", "us/row", "rows/s", "/ read"
    );
    let truth = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth");
    for (name, ego) in [("grid", "g18"), ("motorway", "m6")] {
        let options = Options::default().with(&sumo::EGO, ego).with(&sumo::SENSOR_RANGE, f64::INFINITY);
        let log = truth.join(name).join("fcd.xml.gz");
        let Some(drive) = sumo::read(&log, &options).0 else { continue };
        let reading = (0..rounds)
            .map(|_| milliseconds(&mut || drop(black_box(sumo::read(&log, &options)))))
            .fold(f64::INFINITY, f64::min);
        measure(&format!("{name} as it is"), &drive, Some(reading), rounds);
        for objects in if quick { vec![] } else { vec![50, 200, 800] } {
            measure(&format!("{name} signals/{objects}"), &crowded(&drive, objects), None, rounds);
        }
    }
    for log in if quick { Vec::new() } else { recorded() } {
        let (sources, _) = find_sources(None, std::slice::from_ref(&log));
        let Some(source) = sources.first() else { continue };
        let Some(drive) = read(source, &Options::default()).0 else { continue };
        let reading = (0..rounds)
            .map(|_| milliseconds(&mut || drop(black_box(read(source, &Options::default())))))
            .fold(f64::INFINITY, f64::min);
        let id = log.file_name().and_then(|n| n.to_str()).unwrap_or("").get(..8).unwrap_or("log");
        measure(&format!("av2 {id}"), &drive, Some(reading), rounds);
    }
}
