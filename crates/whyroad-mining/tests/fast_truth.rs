//! Every bundled rule by both evaluators on the simulated drives with known truth (`examples/truth/{agents,roads,traffic}`): the same
//! episodes, the same scores, the same rules not observable.
//!
//! A few drives of each part, so that the test stays quick in a debug build; all of them, also with frames and signals missing:
//! `WHYROAD_TRUTH=all cargo test --release -p whyroad-mining --test fast_truth -- --nocapture`.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod equality;

use equality::{assert_equal, part, rules, with_gaps, with_less};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;
use whyroad_ingest::sumo;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::Drive;

/// The sample: drives of each kind of road and scene, and the frames of them in which the truth names several classes.
const SOME: &[(&str, Range<usize>)] = &[
    ("agents/seen/seen_avenue_03", 4750..4950),
    ("agents/seen/seen_crossing_04", 0..200),
    ("agents/seen/seen_lane_01", 1180..1380),
    ("agents/seen/seen_motorway_00", 3700..3900),
    ("agents/seen/seen_street_05", 3300..3450),
    ("agents/unseen/unseen_crossing_17", 0..150),
    ("roads/seen/seen-approach03", 0..300),
    ("roads/seen/seen-junction01", 0..300),
    ("roads/seen/seen-lane02", 0..300),
    ("roads/seen/seen-light01", 0..300),
    ("roads/seen/seen-road05", 0..300),
    ("roads/seen/seen-yard02", 0..300),
    ("traffic/seen-motorway", 150..350),
    ("traffic/seen-ring", 200..350),
];

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/truth")
}

/// Folders of drives at or below `folder`.
fn drives_in(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries.into_iter().filter(|p| p.is_dir()) {
        if path.join("fcd.xml.gz").is_file() || path.join("drive.yaml").is_file() {
            out.push(path);
        } else {
            drives_in(&path, out);
        }
    }
}

/// Calls `with` for the first `most` drives of the folder; `egos.txt` beside a simulation names its egos where they are not `ego`.
fn each_drive(folder: &Path, most: usize, with: &mut dyn FnMut(Drive)) {
    let egos = std::fs::read_to_string(folder.join("egos.txt")).ok();
    let egos = egos.unwrap_or_default();
    let named = egos.split_whitespace().take(most);
    let options = named.fold(Options::default(), |options, ego| options.with(&sumo::EGO, ego));
    for source in &find_sources(None, &[folder.to_owned()]).0 {
        if folder.join("fcd.xml.gz").is_file() {
            sumo::read_each(&source.path, &options, &mut |drive, _| drive.into_iter().for_each(&mut *with));
        } else {
            read(source, &options).0.into_iter().for_each(&mut *with);
        }
    }
}

#[test]
fn on_drives_with_known_truth() {
    let rules = rules();
    let all = std::env::var("WHYROAD_TRUTH").is_ok_and(|v| v == "all");
    let mut sample: Vec<(PathBuf, Range<usize>)> = Vec::new();
    if all {
        let mut folders = Vec::new();
        ["agents", "roads", "traffic"].iter().for_each(|p| drives_in(&examples().join(p), &mut folders));
        sample.extend(folders.into_iter().map(|f| (f, 0..usize::MAX)));
    } else {
        sample.extend(SOME.iter().map(|(name, frames)| (examples().join(name), frames.clone())));
    }
    let (mut tables, mut episodes) = (0, 0);
    for (folder, frames) in sample {
        let began = Instant::now();
        let mut count = 0;
        each_drive(&folder, if all { usize::MAX } else { 1 }, &mut |drive| {
            count += 1;
            let table = part(&whyroad_signals::derive(&drive), frames.clone());
            episodes += assert_equal(&rules, &table);
            if all {
                episodes +=
                    assert_equal(&rules, &with_gaps(&table)) + assert_equal(&rules, &with_less(&table));
            }
            tables += if all { 3 } else { 1 };
        });
        assert!(count > 0, "{} holds no drive", folder.display());
        println!(
            "{:6.1} s  {}",
            began.elapsed().as_secs_f64(),
            folder.file_name().unwrap().to_string_lossy()
        );
    }
    println!("{} rules, {tables} tables, {episodes} episodes", rules.rules.len());
    assert!(episodes >= 15, "{episodes} episodes are too few to compare anything");
}
