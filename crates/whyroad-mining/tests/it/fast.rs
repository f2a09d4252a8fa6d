//! Every bundled rule by both evaluators, on the bundled drives and, where there are any, on recorded ones: the same
//! episodes with the same scores, the same rules not observable for lack of the same signals.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::equality::{assert_equal, rules, with_gaps, with_less};
use std::path::{Path, PathBuf};
use whyroad_ingest::{Options, find_sources, read};
use whyroad_model::SignalTable;

/// Signal tables of all drives in a folder.
fn tables(folder: &Path) -> Vec<SignalTable> {
    let (sources, _) = find_sources(None, &[folder.to_owned()]);
    let drives = sources.iter().filter_map(|s| read(s, &Options::default()).0);
    drives.map(|d| whyroad_signals::derive(&d)).collect()
}

fn both(folder: &Path) -> (usize, usize) {
    let rules = rules();
    let (mut drives, mut episodes) = (0, 0);
    for table in tables(folder) {
        for table in [with_gaps(&table), with_less(&table), table] {
            drives += 1;
            episodes += assert_equal(&rules, &table);
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
        crate::require::skipped("recorded", "no recorded data");
        return;
    }
    let (drives, _) = both(&base.join("av2"));
    assert!(drives >= 9, "{drives}");
}
