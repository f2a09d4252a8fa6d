//! Who may import whom (ARCHITECTURE.md "Code map"), and under which licenses our dependencies come.
//! Compared with `cargo metadata`, so that the picture in the document cannot drift from the code.

use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// Crate and the workspace crates it may import, in the order in which data flows.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("whyroad-model", &[]),
    ("whyroad-framework", &["whyroad-model"]),
    ("whyroad-label", &["whyroad-model", "whyroad-framework"]),
    ("whyroad-lake", &["whyroad-model"]),
    ("whyroad-ingest", &["whyroad-model", "whyroad-lake"]),
    ("whyroad-signals", &["whyroad-model"]),
    ("whyroad-mining", &["whyroad-model", "whyroad-framework", "whyroad-signals"]),
    (
        "whyroad-engine",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-lake",
            "whyroad-ingest",
            "whyroad-signals",
            "whyroad-mining",
            "whyroad-label",
        ],
    ),
    ("whyroad-render", &["whyroad-model"]),
    (
        "whyroad-report",
        &["whyroad-model", "whyroad-framework", "whyroad-label", "whyroad-lake", "whyroad-render"],
    ),
    (
        "whyroad-dataset",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-label",
            "whyroad-lake",
            "whyroad-engine",
            "whyroad-render",
        ],
    ),
    ("whyroad-server", &["whyroad-model", "whyroad-framework", "whyroad-label"]),
    (
        "whyroad-chat",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-label",
            "whyroad-signals",
            "whyroad-mining",
            "whyroad-render",
        ],
    ),
    (
        "whyroad-fuzz",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-label",
            "whyroad-lake",
            "whyroad-ingest",
            "whyroad-signals",
            "whyroad-mining",
        ],
    ),
    (
        "whyroad-py",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-label",
            "whyroad-lake",
            "whyroad-signals",
            "whyroad-mining",
            "whyroad-engine",
            "whyroad-dataset",
        ],
    ),
    (
        "whyroad",
        &[
            "whyroad-model",
            "whyroad-framework",
            "whyroad-label",
            "whyroad-lake",
            "whyroad-ingest",
            "whyroad-signals",
            "whyroad-mining",
            "whyroad-engine",
            "whyroad-render",
            "whyroad-report",
            "whyroad-dataset",
            "whyroad-server",
            "whyroad-chat",
        ],
    ),
];

/// Crates that only one of ours may depend on: each isolates something heavy or something that must not leak.
const ONLY_IN: &[(&str, &[&str])] = &[
    // The lake's tables, mining's results, and ingest for other people's Parquet files (AV2 motion, `table`).
    (
        "parquet",
        &[
            "whyroad-fuzz",
            "whyroad-lake",
            "whyroad-engine",
            "whyroad-ingest",
            "whyroad-dataset",
            "whyroad-py",
        ],
    ),
    ("arrow-ipc", &["whyroad-ingest", "whyroad-fuzz"]),
    ("quick-xml", &["whyroad-ingest"]),
    ("zip", &["whyroad-ingest", "whyroad-dataset"]),
    ("pyo3", &["whyroad-py"]),
    ("axum", &["whyroad-server"]),
    ("rusqlite", &["whyroad-server"]),
    ("postgres", &["whyroad-server"]),
    ("object_store", &["whyroad-lake"]),
    ("ureq", &["whyroad-lake", "whyroad-server", "whyroad-chat"]),
    ("rustls", &["whyroad-lake", "whyroad-server", "whyroad-chat"]),
    ("ring", &["whyroad-server"]),
    ("clap", &["whyroad"]),
    ("anyhow", &["whyroad"]),
    ("indicatif", &["whyroad"]),
];

/// Query engines stay out of the build (DESIGN.md "Why not a query engine inside").
const NEVER: &[&str] = &["datafusion", "ballista", "duckdb", "polars", "polars-core", "spark-connect-rs"];

fn metadata(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked"])
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .expect("cargo metadata runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON")
}

fn normal_dependencies(package: &Value) -> BTreeSet<&str> {
    package["dependencies"]
        .as_array()
        .into_iter()
        .flatten()
        .filter(|d| d["kind"].is_null())
        .filter_map(|d| d["name"].as_str())
        .collect()
}

#[test]
fn crates_import_only_what_the_table_allows() {
    let metadata = metadata(&["--no-deps"]);
    let packages = metadata["packages"].as_array().unwrap();
    assert_eq!(
        packages.len(),
        MAY_IMPORT.len(),
        "a crate is missing from the table, or the table names one too many"
    );
    for package in packages {
        let name = package["name"].as_str().unwrap();
        let (_, allowed) = MAY_IMPORT.iter().find(|(n, _)| *n == name).expect(name);
        for dependency in normal_dependencies(package) {
            if dependency.starts_with("whyroad") {
                assert!(allowed.contains(&dependency), "{name} may not import {dependency}");
            }
            if let Some((_, homes)) = ONLY_IN.iter().find(|(d, _)| *d == dependency) {
                assert!(homes.contains(&name), "{dependency} belongs only in {homes:?}, not in {name}");
            }
        }
    }
}

/// The machine's own target: dependencies of other platforms are neither downloaded nor shipped.
fn host_triple() -> String {
    let output = Command::new("rustc").arg("-vV").output().expect("rustc runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().find_map(|l| l.strip_prefix("host: ")).expect("rustc names its host").to_owned()
}

#[test]
fn no_query_engine_and_only_allowed_licences_in_the_build() {
    let metadata = metadata(&["--filter-platform", &host_triple()]);
    // One list for this test and for cargo-deny.
    let deny = include_str!("../../../../deny.toml");
    let list = deny
        .split_once("allow = [")
        .and_then(|(_, rest)| rest.split_once(']'))
        .expect("deny.toml lists licences")
        .0;
    let allowed: BTreeSet<&str> = list.split('"').skip(1).step_by(2).collect();
    assert!(allowed.contains("Apache-2.0"));
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50, "the whole dependency graph is here");
    for package in packages {
        let name = package["name"].as_str().unwrap();
        assert!(!NEVER.contains(&name), "{name} is a query engine");
        // What deny.toml clarifies, where a manifest names only a file.
        let clarified = deny.split("[[licenses.clarify]]").skip(1).find_map(|entry| {
            entry.contains(&format!("crate = \"{name}\"")).then(|| entry.split('"').nth(3)).flatten()
        });
        let licence = package["license"].as_str().or(clarified).unwrap_or("");
        // `A OR B` needs one allowed; `A AND B` needs both; `/` is an old form of OR.
        let satisfied = licence.replace('/', " OR ").split(" OR ").any(|alternative| {
            alternative.split(" AND ").all(|id| allowed.contains(id.trim_matches(['(', ')', ' '])))
        });
        assert!(satisfied, "{name} comes under '{licence}', which deny.toml does not allow");
    }
}
