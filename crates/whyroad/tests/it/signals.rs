//! `whyroad signals` as its user sees it. Expected values: `schema/signals.yaml` as it is read by people, and the
//! alias that DATA_FORMAT.md 5.1 uses.

use std::process::{Command, Output};

fn whyroad(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whyroad")).arg("signals").args(arguments).output().expect("whyroad runs")
}

#[test]
fn the_list_names_every_signal_of_the_catalog() {
    let output = whyroad(&["list", "--format", "json"]);
    assert!(output.status.success());
    let listed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let catalog = include_str!("../../../../schema/signals.yaml");
    let entries = catalog.lines().filter(|l| l.starts_with("  - name: ")).count();
    assert_eq!(listed.as_array().unwrap().len(), entries);
    assert!(listed.as_array().unwrap().iter().all(|s| s["meaning"]["zh"] != "" && s["source"] != ""));
}

#[test]
fn an_alias_shows_its_signal_and_a_misspelt_name_what_was_meant() {
    let output = whyroad(&["show", "target_vehicle.lateral_offset"]);
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("target.lateral_offset\n"));
    let output = whyroad(&["show", "target.gpa"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("target.gap"));
}
