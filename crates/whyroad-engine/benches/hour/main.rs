//! What an hour of driving costs, from the log to its episodes: CPU time and peak memory of each stage on one core,
//! beside bare decoding of the same logs. `cargo bench -p whyroad-engine --bench hour [-- OBJECTS... drives=N]`
//!
//! The logs are made by the bench: a town with a map, in the form of Argoverse 2 (`city`, `traffic`, `log`), drives of
//! 60 s at 10 Hz with 25, 75 and 200 objects per frame on average. With fewer drives than 60 the figures are scaled to
//! an hour. Peak memory is that of the whole process while a stage runs, with what it holds for the next one.
#![allow(clippy::print_stdout, clippy::expect_used)] // printing is what a bench is for

mod city;
#[path = "../mine/cpu.rs"]
mod cpu;
mod log;
mod traffic;

use cpu::cpu_seconds;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use whyroad_framework::Framework;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_mining::drive::arbitrated;
use whyroad_mining::fast::{Plan, Search, Signals};
use whyroad_model::{Column, Drive, SignalTable, Tri};
use whyroad_signals::{Catalog, Wanted, derive_wanted};

/// Signals of a rule about the ego, and of one about who is ahead.
const FEW: [(&str, &[&str]); 2] = [
    ("(derive two of the ego alone)", &["ego.accel", "ego.speed"]),
    ("(derive two of targets alone)", &["target.ttc", "target.in_ego_lane"]),
];

/// Deriving what all rules ask for, as `mine --once` does, which stores no signals.
const ASKED: &str = "(derive what rules ask alone)";
const DERIVE: &str = "estimate and derive signals";
const STORE_SIGNALS: &str = "store signals";

/// Frames per drive: a minute.
const FRAMES: usize = 600;
const DRIVES_PER_HOUR: usize = 60;

fn main() {
    // `cargo test --benches` runs this too; then a little is enough to see that it works.
    let quick = std::env::args().any(|a| a == "--test");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let drives = arguments.iter().find_map(|a| a.strip_prefix("drives=")?.parse().ok());
    let drives: usize = drives.unwrap_or(if quick { 1 } else { DRIVES_PER_HOUR });
    if let [what, folder, objects, ..] = &arguments[..]
        && let Ok(objects) = objects.parse()
    {
        match what.as_str() {
            "generate" => return generate(Path::new(folder), objects, drives),
            "measure" => return measure(Path::new(folder), objects),
            _ => {}
        }
    }
    let asked: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let sizes = match (&asked[..], quick) {
        ([], true) => vec![25],
        ([], false) => vec![25, 75, 200],
        (sizes, _) => sizes.to_vec(),
    };
    for objects in sizes {
        let dir = tempfile::tempdir().expect("a temporary folder");
        // Processes of their own: memory is measured per process.
        for what in ["generate", "measure"] {
            let own = std::env::current_exe().expect("a path");
            let folder = dir.path().display().to_string();
            let arguments = [what, &folder, &objects.to_string(), &format!("drives={drives}")];
            assert!(Command::new(own).args(arguments).status().expect("started").success(), "{what}");
        }
    }
}

fn generate(folder: &Path, objects: usize, drives: usize) {
    let lanes = city::lanes();
    for k in 0..drives {
        let seed = (objects * 1000 + k) as u64;
        let recording = traffic::record(&lanes, objects, FRAMES, seed);
        log::write(&folder.join(format!("logs/drive{k:03}")), &lanes, &recording, seed);
    }
}

/// CPU seconds and peak memory of a stage over all drives.
struct Stage {
    name: &'static str,
    cpu: f64,
    peak_mb: f64,
}

struct Stages(Vec<Stage>);

impl Stages {
    fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        // Peak memory starts again from here (proc(5)).
        let _ = fs::write("/proc/self/clear_refs", "5");
        let before = cpu_seconds();
        let out = black_box(work());
        let (cpu, peak_mb) = (cpu_seconds() - before, peak_mb());
        match self.0.iter_mut().find(|s| s.name == name) {
            Some(stage) => {
                stage.cpu += cpu;
                stage.peak_mb = stage.peak_mb.max(peak_mb);
            }
            None => self.0.push(Stage { name, cpu, peak_mb }),
        }
        out
    }
}

/// Greatest resident memory since the last reset, MB; NaN where the system does not tell.
fn peak_mb() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kb = line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kb.map_or(f64::NAN, |kb| kb / 1e3)
}

fn measure(folder: &Path, objects: usize) {
    whyroad_engine::memory::keep_freed();
    let rules = RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0;
    let plan = Plan::of(&rules);
    let all: Vec<usize> = (0..rules.rules.len()).collect();
    let asked = Wanted::only(plan.rules.iter().flat_map(|rule| rule.names()));
    let lake = Lake::create_or_open(folder.join("lake")).expect("a lake");
    let (sources, _) = find_sources(None, &[folder.join("logs")]);
    let mut stages = Stages(Vec::new());
    let (mut frames, mut rows, mut episodes, mut all_found) = (0, 0, 0, String::new());
    let (mut signals, mut results) = (blake3::Hasher::new(), blake3::Hasher::new());
    for source in &sources {
        stages.run("decode the log, nothing else", || decode(&source.path));
        let drive = stages
            .run("ingest: log to scene tables", || read(source, &Options::default()).0.expect("a drive"));
        stages.run("store scene tables", || lake.write_drive(&drive).expect("written"));
        let id = drive.meta.drive_id.clone();
        drop(drive);
        let drive: Drive = stages.run("read scene tables", || lake.read_drive(&id).expect("readable"));
        frames += drive.times.len();
        rows += drive.tracks.iter().map(|t| t.frames.len()).sum::<usize>();
        // `derive` begins with this; it is measured once more by itself.
        stages.run("(estimate alone)", || drop(black_box(whyroad_signals::estimate::estimated(&drive))));
        // And what rules cost that ask for few signals (`mine --once`).
        for (name, signals) in FEW {
            stages
                .run(name, || drop(black_box(derive_wanted(&drive, &Wanted::only(signals.iter().copied())))));
        }
        let some = stages.run(ASKED, || derive_wanted(&drive, &asked));
        let table = stages.run(DERIVE, || whyroad_signals::derive(&drive));
        drop(drive);
        digest(&table, &mut signals);
        stages.run(STORE_SIGNALS, || {
            lake.write_signals(&id, whyroad_signals::VERSION, &table).expect("written");
        });
        let mined = |table: &SignalTable| {
            let found = Search::new(&plan, &Signals::of_table(table), all.iter().copied()).found();
            let found = arbitrated(&rules, &id, &table.times, found).episodes;
            (found.len(), format!("{found:?}\n"))
        };
        let (count, text) = stages.run("mine: all rules to episodes", || mined(&table));
        assert!(mined(&some).1 == text, "{id}: other episodes from what rules ask for");
        results.update(text.as_bytes());
        all_found += &text;
        episodes += count;
    }
    let hours = sources.len() as f64 / DRIVES_PER_HOUR as f64;
    let bytes = |name: &str| size(&folder.join(name), &|p| p.ends_with("signals") || name == "logs");
    println!(
        "hour/{objects}: {} drives, {:.1} objects per frame, {:.2} million rows per hour, {episodes} episodes, {} rules",
        sources.len(),
        rows as f64 / frames as f64,
        rows as f64 / hours / 1e6,
        rules.rules.len(),
    );
    let [signals, results] = [signals, results].map(|h| h.finalize().to_hex()[..16].to_string());
    println!("hash of signals {signals}, of episodes {results}");
    // Where hashes differ, this says by what.
    fs::write(folder.join("episodes.txt"), all_found).expect("written");
    println!("{:<32} {:>16} {:>10} {:>10}", "stage", "core-s per hour", "us per row", "peak MB");
    for stage in &stages.0 {
        println!(
            "{:<32} {:>16.2} {:>10.2} {:>10.0}",
            stage.name,
            stage.cpu / hours,
            stage.cpu * 1e6 / rows as f64,
            stage.peak_mb
        );
    }
    let sum = |counts: &dyn Fn(&str) -> bool| -> f64 {
        stages.0.iter().filter(|stage| counts(stage.name)).map(|stage| stage.cpu).sum()
    };
    let beside = |name: &str| name.contains("alone") || name.contains("nothing else");
    let stored = sum(&|name| !beside(name));
    let once = sum(&|name| name == ASKED || (!beside(name) && ![DERIVE, STORE_SIGNALS].contains(&name)));
    for (name, total) in [("log to episodes", stored), ("the same with `mine --once`", once)] {
        println!("{name:<32} {:>16.2} {:>10.2}", total / hours, total * 1e6 / rows as f64);
    }
    println!(
        "per hour: log {:.0} MB, scene tables {:.0} MB, signals {:.0} MB\n",
        bytes("logs") / hours / 1e6,
        (size(&folder.join("lake"), &|_| true) - bytes("lake")) / hours / 1e6,
        bytes("lake") / hours / 1e6,
    );
}

/// All values of a table, by their bits: equal before and after a change that makes nothing but the time different.
fn digest(table: &SignalTable, into: &mut blake3::Hasher) {
    let mut bytes = Vec::new();
    for (name, column) in table.frame_columns.iter().chain(&table.target_columns) {
        into.update(name.as_bytes());
        bytes.clear();
        match column {
            Column::Number(v) => bytes.extend(v.iter().flat_map(|x| x.to_bits().to_le_bytes())),
            Column::Flag(v) => bytes.extend(v.iter().map(|f| match f {
                Tri::False => 0,
                Tri::True => 1,
                Tri::Unknown => 2,
            })),
            Column::Category { codes, .. } => bytes.extend(codes.iter().flat_map(|c| c.to_le_bytes())),
        }
        into.update(&bytes);
    }
    into.update(format!("{:?}", table.unavailable).as_bytes());
}

/// Bytes of the files below a folder that are in a folder that counts.
fn size(path: &Path, counts: &dyn Fn(&Path) -> bool) -> f64 {
    fn add(path: &Path, within: bool, counts: &dyn Fn(&Path) -> bool) -> f64 {
        let within = within || counts(path);
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        entries
            .map(|e| match e.metadata() {
                Ok(m) if m.is_dir() => add(&e.path(), within, counts),
                Ok(m) if within => m.len() as f64,
                _ => 0.0,
            })
            .sum()
    }
    add(path, false, counts)
}

/// Unpacks and parses the files of a log, and drops what was read: the floor of ingest. `measure` may be pointed at
/// logs of other formats, to compare the hashes of two builds; they have no floor here.
fn decode(log: &Path) {
    let map: PathBuf = log.join("map/log_map_archive_bench____GRID_city_1.json");
    let Ok(text) = fs::read(map) else { return };
    for name in ["annotations.feather", "city_SE3_egovehicle.feather"] {
        let bytes = fs::read(log.join(name)).expect("there");
        let reader =
            arrow_ipc::reader::FileReader::try_new(std::io::Cursor::new(bytes), None).expect("Arrow");
        black_box(reader.map(|b| black_box(b.expect("readable")).num_rows()).sum::<usize>());
    }
    black_box(serde_json::from_slice::<serde_json::Value>(&text).expect("JSON"));
}
