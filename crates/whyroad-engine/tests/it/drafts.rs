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
use whyroad_signals::{Catalogue, derive};

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

fn compare(folders: &[PathBuf]) -> usize {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path(), folders);
    let framework = Framework::bundled();
    let rules = RuleSet::of_framework(framework, Catalogue::bundled()).0;
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
            let (all, places) = (recordings.signals(&cut), recordings.places(&cut));
            assert!(are_of(&places, &all) > 20);
            for lang in [Lang::Zh, Lang::En] {
                let of = |signals| draft(framework, &drive, signals, episode, lang).label;
                assert_eq!(of(&stored), of(&derived));
                let short = components(framework, &cut, || places.clone(), episode, lang);
                let long = draft(framework, &cut, &all, episode, lang).label.critical_components;
                assert_eq!(short, long, "{}", episode.episode_id);
                with_components += usize::from(!short.is_empty());
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
