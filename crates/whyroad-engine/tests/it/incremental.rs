//! A lake mined again: what was stored and kept changes no answer; only new drives and changed rules are run; an
//! interrupted run goes on; a damaged store is made again; an unwritable lake is mined all the same.

use std::path::{Path, PathBuf};
use whyroad_engine::mine::{Evaluator, MineOptions, MinedLake, derive_signals, mine_lake_with};
use whyroad_framework::Framework;
use whyroad_ingest::{Options as Ingest, find_sources, read};
use whyroad_lake::Lake;
use whyroad_mining::RuleSet;
use whyroad_model::Nanos;
use whyroad_signals::Catalog;

fn rules() -> RuleSet {
    RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0
}

/// A lake of some of the bundled drives.
fn lake(dir: &Path, names: &[&str]) -> Lake {
    let lake = Lake::create_or_open(dir.join("lake")).unwrap();
    for name in names {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drives").join(name);
        for source in find_sources(None, &[folder]).0 {
            lake.write_drive(&read(&source, &Ingest::default()).0.unwrap()).unwrap();
        }
    }
    lake
}

fn mine(lake: &Lake, rules: &RuleSet, options: MineOptions) -> MinedLake {
    let mined = mine_lake_with(lake, rules, &options, |_| ());
    assert!(mined.diagnostics.is_empty(), "{:?}", mined.diagnostics);
    mined
}

fn assert_same(a: &MinedLake, b: &MinedLake) {
    assert_eq!(a.drives.len(), b.drives.len());
    for (a, b) in a.drives.iter().zip(&b.drives) {
        assert_eq!((&a.drive_id, &a.clips, &a.missing), (&b.drive_id, &b.clips, &b.missing));
        assert_eq!(a.episodes, b.episodes);
    }
}

fn file(lake: &Lake, drive: usize, name: &str) -> PathBuf {
    lake.dir().join("drives").join(lake.drive_ids()[drive].as_str()).join(name)
}

#[test]
fn mined_again_it_says_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path(), &["multilane", "back_street"]);
    let rules = rules();
    let reference =
        mine(&lake, &rules, MineOptions { evaluator: Evaluator::Reference, ..MineOptions::default() });
    assert!(!file(&lake, 0, "signals").exists(), "the reference keeps nothing");
    assert!(reference.drives.iter().any(|d| !d.episodes.is_empty()));
    let first = mine(&lake, &rules, MineOptions { jobs: Some(1), ..MineOptions::default() });
    assert_same(&first, &reference);
    // Kept.
    assert_same(&mine(&lake, &rules, MineOptions::default()), &reference);
    // Nothing is read but what was kept: the stored signals may be gone.
    std::fs::remove_dir_all(file(&lake, 0, "signals")).unwrap();
    assert_same(&mine(&lake, &rules, MineOptions::default()), &reference);
    assert!(!file(&lake, 0, "signals").exists(), "no rule was run, so no signal was wanted");
    // From stored signals.
    for drive in 0..2 {
        std::fs::remove_file(file(&lake, drive, "found.json")).unwrap();
    }
    assert_eq!(derive_signals(&lake, None, |_| ()).0, 1, "one was gone");
    assert_eq!(derive_signals(&lake, Some(1), |_| ()).0, 0, "all are there");
    assert_same(&mine(&lake, &rules, MineOptions::default()), &reference);
}

#[test]
fn signals_that_cannot_be_stored_are_one_error_of_the_file_system() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path(), &["multilane", "back_street"]);
    for drive in 0..2 {
        // Where the folder of signals would be.
        std::fs::write(file(&lake, drive, "signals"), "").unwrap();
    }
    let (derived, errors) = derive_signals(&lake, None, |_| ());
    let codes: Vec<&str> = errors.iter().map(|d| d.code).collect();
    assert_eq!((derived, codes), (0, vec!["lake.io"]));
    let text = &errors[0].message.en;
    assert!(text.contains("Not a directory") && !text.contains("cannot be read"), "{text}");
}

#[test]
fn rules_asked_once_get_their_signals_alone() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake(dir.path(), &["multilane"]);
    let all = rules();
    let reference = MineOptions { evaluator: Evaluator::Reference, ..MineOptions::default() };
    let (mut episodes, mut runs) = (0, 0);
    for rule in all.rules.iter().step_by(11) {
        let one = RuleSet { rules: vec![rule.clone()], ..all.clone() };
        let mined = mine(&lake, &one, MineOptions { once: true, ..MineOptions::default() });
        assert_same(&mined, &mine(&lake, &one, reference));
        episodes += mined.drives[0].episodes.len();
        runs += 1;
    }
    assert!(runs >= 10 && episodes > 0, "{runs} rules found {episodes} episodes");
    assert!(!file(&lake, 0, "signals").exists(), "a store has all signals");
    // Otherwise it is stored, and what was kept of single rules is not run again.
    assert_same(&mine(&lake, &all, MineOptions::default()), &mine(&lake, &all, reference));
    assert!(file(&lake, 0, "signals").exists());
}

#[test]
fn only_what_is_new_is_run() {
    let dir = tempfile::tempdir().unwrap();
    let a = lake(dir.path(), &["multilane"]);
    let mut rules = rules();
    mine(&a, &rules, MineOptions::default());
    let found = || std::fs::read(file(&a, 0, "found.json")).unwrap();
    let before = found();
    mine(&a, &rules, MineOptions::default());
    assert_eq!(found(), before);
    // A changed rule is run again and gives what it now means.
    rules.rules[0].min_duration = Nanos(3_600_000_000_000);
    let changed = rules.rules[0].scenario.clone();
    let mined = mine(&a, &rules, MineOptions::default());
    assert_ne!(found(), before);
    assert!(mined.drives[0].episodes.iter().all(|e| e.record.scenario_id != changed));
    assert_same(
        &mined,
        &mine(&a, &rules, MineOptions { evaluator: Evaluator::Reference, ..MineOptions::default() }),
    );
    // A new drive is added to what is known.
    let b = lake(dir.path(), &["back_street"]);
    assert_eq!(mine(&b, &rules, MineOptions::default()).drives.len(), 2);
    // What was interrupted (a drive done, another not) or damaged is made good.
    let whole = mine(&b, &rules, MineOptions::default());
    std::fs::remove_file(file(&b, 0, "found.json")).unwrap();
    std::fs::write(file(&b, 1, "found.json"), b"{ half").unwrap();
    let stored = file(&b, 1, "signals/targets.parquet");
    let half = std::fs::read(&stored).unwrap();
    std::fs::write(&stored, &half[..half.len() / 2]).unwrap();
    assert_same(&mine(&b, &rules, MineOptions::default()), &whole);
}
