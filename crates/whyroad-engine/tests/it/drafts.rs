//! Drafts as the service makes them, by the short way: the whole drive's signals from the lake, and of the drive cut at
//! the keyframe only what critical components need. They are those of all signals, derived.

use crate::label_checks::lake;
use std::path::{Path, PathBuf};
use whyroad_engine::mine::{MineOptions, mine_lake_with};
use whyroad_engine::recordings::LakeRecordings;
use whyroad_framework::Framework;
use whyroad_label::draft::{components, draft};
use whyroad_mining::RuleSet;
use whyroad_model::{Column, Lang, SignalTable};
use whyroad_signals::{Catalog, derive};

/// Episodes of a drive whose drafts are compared: deriving all signals takes long, which is why there is a short way.
const EPISODES: usize = 4;

/// A value of a column: numbers to the last bit, but a NaN is a NaN (null on disk).
fn value(column: &Column, row: usize) -> String {
    match column {
        Column::Number(values) if values[row].is_nan() => "unknown".to_owned(),
        Column::Number(values) => format!("{:x}", values[row].to_bits()),
        Column::Flag(values) => format!("{:?}", values[row]),
        Column::Category { .. } => format!("{:?}", column.category(row)),
    }
}

/// Each column of `some` is that of `all`; the number of columns.
#[track_caller]
fn are_of(some: &SignalTable, all: &SignalTable) -> usize {
    assert_eq!((&some.times, &some.targets), (&all.times, &all.targets));
    let of = |t: &SignalTable| t.frame_columns.len() + t.target_columns.len();
    let columns = some.frame_columns.iter().map(|c| (c, &all.frame_columns));
    for ((name, column), there) in columns.chain(some.target_columns.iter().map(|c| (c, &all.target_columns)))
    {
        let there = &there[name];
        assert_eq!(column.len(), there.len(), "{name}");
        let other = (0..column.len()).find(|&row| value(column, row) != value(there, row));
        assert_eq!(other.map(|row| (row, value(column, row), value(there, row))), None, "{name}");
    }
    of(some)
}

/// In the last frame each column of `some` is that of `all`, of targets that are seen then; the number of columns.
#[track_caller]
fn are_last_of(some: &SignalTable, all: &SignalTable) -> usize {
    let last = all.times.len() - 1;
    assert_eq!(some.times, all.times);
    for (name, column) in &some.frame_columns {
        assert_eq!(value(column, last), value(&all.frame_columns[name], last), "{name}");
    }
    let seen = |t: &SignalTable| -> Vec<_> {
        t.targets.iter().filter_map(|span| Some((span.id.clone(), span.row(last)?))).collect()
    };
    let (ours, theirs) = (seen(some), seen(all));
    assert_eq!(ours.len(), theirs.len());
    for ((id, row), (other_id, other_row)) in ours.iter().zip(&theirs) {
        assert_eq!(id, other_id);
        for (name, column) in &some.target_columns {
            assert_eq!(value(column, *row), value(&all.target_columns[name], *other_row), "{name} of {id}");
        }
    }
    some.frame_columns.len() + some.target_columns.len()
}

fn compare(folders: &[PathBuf]) -> usize {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path(), folders);
    let framework = Framework::bundled();
    let rules = RuleSet::of_framework(framework, Catalog::bundled()).0;
    // Stores the signals.
    let mined = mine_lake_with(&lake, &rules, &MineOptions::default(), |_| ());
    let recordings = LakeRecordings::open(lake, &[], &[]).unwrap();
    let mut with_components = 0;
    for found in &mined.drives {
        let drive = recordings.drive(&found.drive_id).unwrap();
        let (stored, derived) = (recordings.whole_signals(&drive), derive(&drive));
        assert_eq!(are_of(&stored, &derived), are_of(&derived, &stored));
        let primary: Vec<_> = found.episodes.iter().map(|e| &e.record).filter(|e| e.is_primary).collect();
        for episode in primary.iter().step_by(primary.len().div_ceil(EPISODES).max(1)) {
            let cut = drive.until(episode.keyframe.timestamp);
            let (all, last) = (recordings.signals(&cut), recordings.last_frame(&cut));
            assert!(are_last_of(&last, &all) > 20);
            for lang in [Lang::Zh, Lang::En] {
                let of = |signals| draft(framework, &drive, signals, episode, lang).label;
                assert_eq!(of(&stored), of(&derived));
                let short = components(framework, &cut, &last, episode, lang);
                let long = draft(framework, &cut, &all, episode, lang);
                // Without what comes after, no wording may fit: such a skeleton has no components.
                if long.doubt.is_none() {
                    assert_eq!(short, long.label.critical_components, "{}", episode.episode_id);
                    with_components += usize::from(!short.is_empty());
                }
            }
        }
    }
    with_components
}

#[test]
fn on_simulated_drives() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives");
    let folders: Vec<PathBuf> =
        ["back_street", "multilane", "signal_junction"].map(|n| root.join(n)).to_vec();
    assert!(compare(&folders) > 10);
}

#[test]
fn on_a_recorded_drive() {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let data = std::env::var_os("WHYROAD_DATA").map_or(beside, PathBuf::from);
    let log = data.join("av2/sensor_logs/3bffdcff-c3a7-38b6-a0f2-64196d130958");
    if !log.is_dir() {
        println!("skipped: no recorded data");
        return;
    }
    assert!(compare(&[log]) > 2);
}
