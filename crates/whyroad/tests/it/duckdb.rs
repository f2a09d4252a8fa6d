//! The SQL of the documentation, run by DuckDB (its Python package) on a lake of different logs. Where DuckDB is not
//! installed the test says so, and fails when `WHYROAD_REQUIRE` names `python`.
#![allow(clippy::unwrap_used)]

use crate::session::{root, whyroad_in};
use std::path::Path;
use std::process::Command;

const RUN: &str = "
import duckdb, sys
for query in sys.stdin.read().split('\\0'):
    print(len(duckdb.sql(query).fetchall()))
";

/// The interpreter that has the packages: `WHYROAD_PYTHON`, or the one of the machine.
pub fn python() -> String {
    std::env::var("WHYROAD_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

/// True where the interpreter has DuckDB.
pub fn is_installed() -> bool {
    let import = Command::new(python()).args(["-c", "import duckdb"]).output();
    import.is_ok_and(|o| o.status.success())
}

#[test]
fn the_documented_queries_run_on_a_lake_of_different_logs() {
    if !is_installed() {
        crate::require::skipped("python", "no duckdb");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    // With and without a map, lights, bus signals and objects' visibility.
    for source in ["examples/drives/back_street", "crates/whyroad-ingest/tests/fixtures/crossroads.fcd.xml"] {
        let source = root().join(source);
        let ingest = whyroad_in(dir.path(), &["ingest", "sumo", source.to_str().unwrap(), "--lake", "lake"]);
        assert_eq!(ingest.code, 0, "{}", ingest.err);
    }
    let lake = whyroad_lake::Lake::open(dir.path().join("lake")).unwrap();
    let ids = lake.drive_ids();
    for id in &ids {
        whyroad_engine::drives::signals_of(&lake, id).unwrap();
    }
    let rows = run_queries(&root().join("docs/reference/lake.md"), dir.path());
    assert!(rows.iter().all(|n| *n > 0), "{rows:?}");
    assert_eq!(rows.last(), Some(&ids.len()), "a row for each drive in the last query");
}

/// Runs every SQL block of a page in `folder`; the number of rows of each.
pub fn run_queries(page: &Path, folder: &Path) -> Vec<usize> {
    let page = std::fs::read_to_string(page).unwrap();
    let queries: Vec<&str> =
        page.split("```sql\n").skip(1).map(|block| block.split("```").next().unwrap()).collect();
    assert!(queries.len() >= 2, "{page}");
    let mut python = Command::new(python())
        .args(["-c", RUN])
        .current_dir(folder)
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::io::Write::write_all(&mut python.stdin.take().unwrap(), queries.join("\0").as_bytes()).unwrap();
    let run = python.wait_with_output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    String::from_utf8(run.stdout).unwrap().lines().map(|l| l.parse().unwrap()).collect()
}
