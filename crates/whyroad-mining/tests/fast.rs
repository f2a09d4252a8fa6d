//! Every bundled rule by both evaluators, on the bundled drives and, where there are any, on recorded ones: the same
//! episodes with the same scores, the same rules not observable for lack of the same signals.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::path::{Path, PathBuf};
use whyroad_framework::Framework;
use whyroad_ingest::{Options, find_sources, read};
use whyroad_mining::{DriveEpisodes, Episode, RuleSet, fast, mine_drive};
use whyroad_model::{Column, FrameRange, SignalTable, Tri};
use whyroad_signals::Catalogue;

fn rules() -> RuleSet {
    RuleSet::of_framework(Framework::bundled(), Catalogue::bundled()).0
}

/// Signal tables of all drives in a folder.
fn tables(folder: &Path) -> Vec<SignalTable> {
    let (sources, _) = find_sources(None, &[folder.to_owned()]);
    let drives = sources.iter().filter_map(|s| read(s, &Options::default()).0);
    drives.map(|d| whyroad_signals::derive(&d)).collect()
}

fn assert_same(fast: &DriveEpisodes, reference: &DriveEpisodes) {
    assert_eq!(fast.missing, reference.missing, "{}", reference.drive_id);
    assert_eq!(fast.episodes.len(), reference.episodes.len(), "{}", reference.drive_id);
    for (a, b) in fast.episodes.iter().zip(&reference.episodes) {
        assert!((a.score - b.score).abs() <= 1e-9, "{} against {}", a.score, b.score);
        assert_eq!(a, &Episode { score: a.score, ..b.clone() });
    }
}

/// The drive without some of its frames: every second one is gone for a while.
fn with_gaps(table: &SignalTable) -> SignalTable {
    let keep: Vec<usize> = (0..table.times.len()).filter(|i| i % 50 < 40 || i % 2 == 0).collect();
    let mut out = SignalTable { times: keep.iter().map(|&i| table.times[i]).collect(), ..table.clone() };
    for column in out.frame_columns.values_mut() {
        *column = taken(column, keep.iter().copied());
    }
    let mut rows = Vec::new();
    out.targets.clear();
    for span in &table.targets {
        let kept: Vec<usize> = (0..keep.len()).filter(|&k| span.frames.contains(keep[k])).collect();
        if let (Some(first), Some(last)) = (kept.first(), kept.last()) {
            let frames = FrameRange::new(*first, last + 1);
            out.targets.push(whyroad_model::signal::TargetSpan {
                first_row: rows.len(),
                frames,
                ..span.clone()
            });
            rows.extend(kept.iter().map(|&k| span.first_row + keep[k] - span.frames.start));
        }
    }
    for column in out.target_columns.values_mut() {
        *column = taken(column, rows.iter().copied());
    }
    out
}

fn taken(column: &Column, rows: impl Iterator<Item = usize>) -> Column {
    match column {
        Column::Number(v) => Column::Number(rows.map(|r| v[r]).collect()),
        Column::Flag(v) => Column::Flag(rows.map(|r| v[r]).collect()),
        Column::Category { codes, names } => {
            Column::Category { codes: rows.map(|r| codes[r]).collect(), names: names.clone() }
        }
    }
}

/// The drive with every third signal lost, and some flags unknown here and there.
fn with_less(table: &SignalTable) -> SignalTable {
    let mut out = table.clone();
    for columns in [&mut out.frame_columns, &mut out.target_columns] {
        let names: Vec<String> = columns.keys().cloned().collect();
        names.iter().step_by(3).for_each(|n| drop(columns.remove(n)));
        for column in columns.values_mut() {
            match column {
                Column::Flag(v) => v.iter_mut().step_by(17).for_each(|t| *t = Tri::Unknown),
                Column::Number(v) => v.iter_mut().step_by(23).for_each(|x| *x = f64::NAN),
                Column::Category { .. } => {}
            }
        }
    }
    out
}

fn both(folder: &Path) -> (usize, usize) {
    let rules = rules();
    let (mut drives, mut episodes) = (0, 0);
    for table in tables(folder) {
        for table in [with_gaps(&table), with_less(&table), table] {
            let reference = mine_drive(&rules, &table);
            assert_same(&fast::mine_drive(&rules, &table), &reference);
            drives += 1;
            episodes += reference.episodes.len();
        }
    }
    println!("{} rules, {drives} tables, {episodes} episodes", rules.rules.len());
    (drives, episodes)
}

#[test]
fn on_the_bundled_drives() {
    let (drives, episodes) = both(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives"));
    assert_eq!(drives, 9, "three drives: whole, with gaps, with signals lost");
    assert!(episodes >= 10, "{episodes} episodes are too few to compare anything");
}

#[test]
fn on_recorded_drives() {
    let base = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    if !base.join("av2").is_dir() {
        println!("skipped: no recorded data");
        return;
    }
    let (drives, _) = both(&base.join("av2"));
    assert!(drives >= 9, "{drives}");
}
