//! A recording as a log of Argoverse 2: boxes in the ego's frame with a sensor's noise, poses at 170 Hz, the map.

use super::city::{Lane, map_json};
use super::traffic::{Random, Recording};
use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_ipc::CompressionType;
use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

/// From the rear axle, where Argoverse 2 has its pose, to the middle of the box, m.
const AXLE_M: f64 = 1.339;
/// Standard deviation of a position, m, and of a heading, rad; what a frame keeps of the error of the one before.
const NOISE: (f64, f64, f64) = (0.05, 0.01, 0.8);
/// Share of boxes that the detector missed.
const MISSED: f64 = 0.01;
/// Poses per frame.
const POSES: usize = 17;
const START_NS: i64 = 315_966_000_000_000_000;

/// Writes one log folder.
pub fn write(dir: &Path, lanes: &[Lane], recording: &Recording, seed: u64) {
    fs::create_dir_all(dir.join("map")).expect("a folder");
    let text = serde_json::to_string(&map_json(lanes)).expect("JSON");
    fs::write(dir.join("map/log_map_archive_bench____GRID_city_1.json"), text).expect("written");
    annotations(&dir.join("annotations.feather"), recording, seed);
    poses(&dir.join("city_SE3_egovehicle.feather"), recording);
}

fn feather(path: &Path, columns: Vec<(&str, ArrayRef)>) {
    let batch = RecordBatch::try_from_iter(columns).expect("equal lengths");
    let options = IpcWriteOptions::default().try_with_compression(Some(CompressionType::LZ4_FRAME));
    let file = File::create(path).expect("a file");
    let mut writer =
        FileWriter::try_new_with_options(file, &batch.schema(), options.expect("lz4")).expect("a writer");
    writer.write(&batch).and_then(|()| writer.finish()).expect("written");
}

fn numbers(values: Vec<f64>) -> ArrayRef {
    Arc::new(Float64Array::from(values))
}

/// About normal: the sum of a few uniform numbers.
fn normal(random: &mut Random) -> f64 {
    (0..4).map(|_| random.next() - 0.5).sum::<f64>() * 3.0_f64.sqrt()
}

fn annotations(path: &Path, recording: &Recording, seed: u64) {
    let mut random = Random::new(seed ^ 0x5eed);
    let mut rows: Vec<(i64, usize, [f64; 8])> = Vec::with_capacity(recording.seen.len());
    let (mut of, mut error) = (usize::MAX, [0.0; 3]);
    for seen in &recording.seen {
        let agent = &recording.agents[seen.agent];
        if of != seen.agent {
            (of, error) = (seen.agent, [0.0; 3].map(|_: f64| normal(&mut random)));
        }
        for e in &mut error {
            *e = NOISE.2 * *e + (1.0 - NOISE.2 * NOISE.2).sqrt() * normal(&mut random);
        }
        if random.next() < MISSED {
            continue;
        }
        let (own, heading) = recording.ego[seen.frame];
        let (c, s) = (heading.cos(), heading.sin());
        let (dx, dy) = (
            seen.at.0 + NOISE.0 * error[0] - own.0 + AXLE_M * c,
            seen.at.1 + NOISE.0 * error[1] - own.1 + AXLE_M * s,
        );
        let (x, y) = (dx * c + dy * s, dy * c - dx * s);
        let half = (seen.heading + NOISE.1 * error[2] - heading) / 2.0;
        let points = (4000.0 / (1.0 + x * x + y * y) * agent.size[0]).max(3.0).floor();
        let [l, w, h] = agent.size;
        let values = [l, w, h, half.cos(), half.sin(), x, y, points];
        rows.push((START_NS + seen.frame as i64 * 100_000_000, seen.agent, values));
    }
    rows.sort_by_key(|r| (r.0, r.1));
    let column = |k: usize| numbers(rows.iter().map(|r| r.2[k]).collect());
    let constant = |v: f64| numbers(vec![v; rows.len()]);
    let uuid = |agent: usize| format!("{agent:08x}-0000-4000-8000-{:012x}", agent * 7919);
    feather(
        path,
        vec![
            ("timestamp_ns", Arc::new(Int64Array::from_iter_values(rows.iter().map(|r| r.0)))),
            ("track_uuid", Arc::new(StringArray::from_iter_values(rows.iter().map(|r| uuid(r.1))))),
            (
                "category",
                Arc::new(StringArray::from_iter_values(rows.iter().map(|r| recording.agents[r.1].category))),
            ),
            ("length_m", column(0)),
            ("width_m", column(1)),
            ("height_m", column(2)),
            ("qw", column(3)),
            ("qx", constant(0.0)),
            ("qy", constant(0.0)),
            ("qz", column(4)),
            ("tx_m", column(5)),
            ("ty_m", column(6)),
            ("tz_m", constant(0.4)),
            ("num_interior_pts", Arc::new(Int64Array::from_iter_values(rows.iter().map(|r| r.2[7] as i64)))),
        ],
    );
}

fn poses(path: &Path, recording: &Recording) {
    let mut rows: Vec<(i64, [f64; 4])> = Vec::new();
    for (i, &((x, y), heading)) in recording.ego.iter().enumerate() {
        let next = recording.ego.get(i + 1).copied().unwrap_or(((x, y), heading));
        let turn = (next.1 - heading + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        for k in 0..POSES {
            let t = k as f64 / POSES as f64;
            let h = heading + t * turn;
            let (px, py) = (x + t * (next.0.0 - x), y + t * (next.0.1 - y));
            let time = START_NS + i as i64 * 100_000_000 + (t * 1e8) as i64;
            let place = [(h / 2.0).cos(), (h / 2.0).sin(), px - AXLE_M * h.cos(), py - AXLE_M * h.sin()];
            rows.push((time, place));
        }
    }
    let column = |k: usize| numbers(rows.iter().map(|r| r.1[k]).collect());
    let constant = || numbers(vec![0.0; rows.len()]);
    feather(
        path,
        vec![
            ("timestamp_ns", Arc::new(Int64Array::from_iter_values(rows.iter().map(|r| r.0)))),
            ("qw", column(0)),
            ("qx", constant()),
            ("qy", constant()),
            ("qz", column(1)),
            ("tx_m", column(2)),
            ("ty_m", column(3)),
            ("tz_m", constant()),
        ],
    );
}
