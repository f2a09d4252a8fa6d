//! `dedup/<n>`: near-duplicates among n descriptors. Prints the time to index and to answer 10,000 sampled queries,
//! the recall of all of them against a full scan, and the memory of the process; writes the descriptors so that
//! `benches/dedup_peer.py` can give the same figures for hnswlib.
//!
//! `cargo bench -p whyroad-dataset --bench dedup -- 1000 10000 [--out FOLDER]`; without sizes 1000 and 10,000.
#![allow(clippy::print_stdout)] // a bench prints

use rayon::prelude::*;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;
use whyroad_dataset::dedup::search::{Neighbors, Projection};

const DIMENSIONS: usize = 40;
const QUERIES: usize = 10_000;
/// Descriptors that a full scan compares with all queries before it goes on, so that they stay in the cache.
const BLOCK: usize = 4_096;
/// Similarity 0.9.
const RADIUS: f64 = 1.0 / 0.9 - 1.0;

/// Descriptors as data sets have them: scenes drawn around a number of situations (a twentieth of the samples), a
/// tenth of them nearly repeated.
fn descriptors(n: usize) -> Vec<Vec<f32>> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut uniform = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let situations: Vec<Vec<f32>> = (0..n.div_ceil(20))
        .map(|_| (0..DIMENSIONS).map(|k| uniform() * if k < 12 { 12.0 } else { 4.0 }).collect())
        .collect();
    let mut out: Vec<Vec<f32>> = Vec::with_capacity(n);
    for i in 0..n {
        let repeat = i > 10 && uniform() < 0.1;
        let base = if repeat {
            out[(uniform() * i as f32) as usize % i].clone()
        } else {
            situations[i % situations.len()].clone()
        };
        let spread = if repeat { 0.05 } else { 1.0 };
        out.push(base.iter().map(|x| x + spread * (uniform() - 0.5)).collect());
    }
    out
}

/// How many of the true neighbors of all queries were found, and how many there are, by comparing every query with
/// every descriptor.
fn against_full_scan(views: &[&[f32]], asked: &[usize], found: &[Vec<u32>]) -> (usize, usize) {
    let square = (RADIUS * RADIUS * DIMENSIONS as f64) as f32;
    let found: Vec<BTreeSet<u32>> = found.iter().map(|ids| ids.iter().copied().collect()).collect();
    let flat: Vec<f32> = views.iter().copied().flatten().copied().collect();
    let distance = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f32>();
    let one = |(block, rows): (usize, &[f32])| {
        let (mut hit, mut all) = (0, 0);
        for (ids, &query) in found.iter().zip(asked) {
            for (i, row) in rows.chunks_exact(DIMENSIONS).enumerate() {
                // The first 16 numbers decide most pairs.
                if distance(&row[..16], &views[query][..16]) <= square
                    && distance(row, views[query]) <= square
                {
                    all += 1;
                    hit += usize::from(ids.contains(&((block * BLOCK + i) as u32)));
                }
            }
        }
        (hit, all)
    };
    flat.par_chunks(BLOCK * DIMENSIONS).enumerate().map(one).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
}

/// Resident memory of this process, MB.
fn resident_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("VmRSS:")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|kb| kb.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let out =
        arguments.iter().position(|a| a == "--out").and_then(|i| arguments.get(i + 1)).map(PathBuf::from);
    let mut sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![1_000, 10_000];
    }
    println!(
        "{:<16}{:>10}{:>14}{:>10}{:>12}{:>10}",
        "bench", "index s", "10k queries s", "recall", "neighbours", "MB"
    );
    for n in sizes {
        let data = descriptors(n);
        let views: Vec<&[f32]> = data.iter().map(Vec::as_slice).collect();
        let started = Instant::now();
        let projection = Projection::of(&views);
        let mut index = Neighbors::new(&views, &projection, RADIUS);
        (0..n).for_each(|i| index.insert(i as u32));
        let indexed = started.elapsed().as_secs_f64();
        let asked: Vec<usize> = (0..QUERIES).map(|q| q * 7919 % n).collect();
        let started = Instant::now();
        let found: Vec<Vec<u32>> = asked.par_iter().map(|&q| index.all(views[q])).collect();
        let answered = started.elapsed().as_secs_f64();
        let (hit, all) = against_full_scan(&views, &asked, &found);
        let neighbors: usize = found.iter().map(Vec::len).sum();
        let recall = hit as f64 / all.max(1) as f64;
        println!(
            "{:<16}{indexed:>10.3}{answered:>14.3}{recall:>10.4}{neighbors:>12}{:>10.0}",
            format!("dedup/{n}"),
            resident_mb()
        );
        if let Some(dir) = &out {
            let path = dir.join(format!("dedup_{n}.f32"));
            let bytes: Vec<u8> = data.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            let written = std::fs::File::create(&path).and_then(|mut f| f.write_all(&bytes));
            println!("  {} {}", path.display(), if written.is_ok() { "written" } else { "not written" });
        }
    }
}
