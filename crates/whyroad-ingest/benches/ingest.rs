//! How fast each format becomes a drive, as a ratio to a bare decode of the same files in the same run:
//! `cargo bench -p whyroad-ingest --bench ingest`. The floor unpacks and parses what the adapter must (Arrow IPC,
//! Parquet, XML events, CSV records, npy bytes) and does nothing with it. No harness: fastest of interleaved rounds.
//! Recorded logs are measured where they are.
#![allow(clippy::print_stdout)] // printing is what a bench is for

use std::fs::{self, File};
use std::hint::black_box;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;
use whyroad_ingest::{Options, find_sources, read};

fn milliseconds(f: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    f();
    start.elapsed().as_secs_f64() * 1e3
}

/// All files at or below `path`.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let mut found: Vec<PathBuf> =
        fs::read_dir(path).into_iter().flatten().flatten().flat_map(|e| files(&e.path())).collect();
    found.sort();
    found
}

/// Files that an adapter reads; the rest of a folder (what a simulator says of itself, networks' sources) is no work of
/// its.
fn is_read(path: &Path) -> bool {
    let text = path.to_string_lossy();
    !["ssm.xml", "lanechange.xml", "/source/", "truth.jsonl", "road.csv", ".npz", ".hevc", "calibration"]
        .iter()
        .any(|other| text.contains(other))
}

/// Decodes one file and drops it; returns the decoded size, bytes.
fn decode(path: &Path) -> Option<usize> {
    let name = path.file_name()?.to_str()?;
    if name.ends_with(".feather") {
        let reader = arrow_ipc::reader::FileReader::try_new(File::open(path).ok()?, None).ok()?;
        return Some(reader.flatten().map(|b| black_box(b).get_array_memory_size()).sum());
    }
    if name.ends_with(".parquet") {
        let builder =
            parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(File::open(path).ok()?);
        return Some(
            builder.ok()?.build().ok()?.flatten().map(|b| black_box(b).get_array_memory_size()).sum(),
        );
    }
    let mut bytes = fs::read(path).ok()?;
    if name.ends_with(".gz") {
        let mut unpacked = Vec::new();
        flate2::read::GzDecoder::new(&bytes[..]).read_to_end(&mut unpacked).ok()?;
        bytes = unpacked;
    }
    if name.contains(".xml") {
        let mut reader = quick_xml::Reader::from_reader(BufReader::new(&bytes[..]));
        let mut buffer = Vec::new();
        while let Ok(event) = reader.read_event_into(&mut buffer) {
            match &event {
                quick_xml::events::Event::Eof => break,
                quick_xml::events::Event::Start(e) | quick_xml::events::Event::Empty(e) => {
                    black_box(e.attributes().flatten().count());
                }
                _ => {}
            }
            buffer.clear();
        }
    } else if name.ends_with(".csv") {
        black_box(csv::Reader::from_reader(&bytes[..]).records().flatten().count());
    } else if name.ends_with(".json") {
        black_box(serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    }
    Some(black_box(bytes).len())
}

fn main() {
    // `cargo test --benches` runs this too; then once is enough to see that it works.
    let quick = std::env::args().any(|a| a == "--test");
    let rounds = if quick { 1 } else { 7 };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data = std::env::var_os("WHYROAD_DATA").map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let mut inputs = vec![
        ("sumo", root.join("examples/drives/back_street")),
        ("sumo", root.join("examples/drives/multilane")),
        ("sumo", root.join("examples/drives/signal_junction")),
        ("table", root.join("examples/table/following")),
    ];
    for (format, folder) in
        [("av2", "av2/sensor_logs"), ("av2-motion", "av2/motion_forecasting"), ("comma2k19", "comma2k19")]
    {
        let mut found: Vec<PathBuf> =
            fs::read_dir(data.join(folder)).into_iter().flatten().flatten().map(|e| e.path()).collect();
        found.sort();
        inputs.extend(found.into_iter().filter(|_| !quick).map(|p| (format, p)));
    }
    println!(
        "{:<12} {:<26} {:>6} {:>9} {:>9} {:>9} {:>8} {:>9}",
        "ingest/", "input", "drives", "MB", "decode ms", "ingest ms", "ratio", "rows/s"
    );
    for (format, input) in inputs {
        let (sources, _) = find_sources(None, std::slice::from_ref(&input));
        let used: Vec<PathBuf> = files(&input).into_iter().filter(|p| is_read(p)).collect();
        let (mut floor, mut whole, mut rows, mut size, mut drives) = (f64::INFINITY, f64::INFINITY, 0, 0, 0);
        for _ in 0..rounds {
            size = 0;
            floor = floor.min(milliseconds(&mut || size = used.iter().filter_map(|p| decode(p)).sum()));
            (rows, drives) = (0, 0);
            whole = whole.min(milliseconds(&mut || {
                for drive in sources.iter().filter_map(|s| read(s, &Options::default()).0) {
                    drives += 1;
                    rows += drive.times.len() + drive.tracks.iter().map(|t| t.frames.len()).sum::<usize>();
                    black_box(drive);
                }
            }));
        }
        if drives == 0 {
            continue;
        }
        let name = input.file_name().and_then(|n| n.to_str()).unwrap_or("");
        println!(
            "{format:<12} {:<26} {drives:>6} {:>9.2} {floor:>9.2} {whole:>9.2} {:>8.2} {:>9.0}",
            name.get(..26).unwrap_or(name),
            size as f64 / 1e6,
            whole / floor,
            rows as f64 / (whole / 1e3),
        );
    }
}
