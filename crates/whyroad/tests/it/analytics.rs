//! `report`, `compare` and `taxonomy migrate` as their users run them, on the bundled drives with a store of tasks; the
//! documented DuckDB queries run on the tables that come out.
#![allow(clippy::unwrap_used)]

use crate::duckdb;
use crate::postgres::Server;
use crate::session::{Run, root, whyroad_in};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use whyroad_server::store::Store;
use whyroad_server::values;

fn fine(dir: &Path, args: &[&str]) -> Run {
    let run = whyroad_in(dir, args);
    assert_eq!(run.code, 0, "{args:?}\n{}{}", run.out, run.err);
    run
}

/// The bundled drives: `lake`, `mined`, and `labels` with a task for each primary episode, of which the first two are
/// accepted. Made once, and only read; tests that write copy the store.
fn project() -> &'static Path {
    static MADE: OnceLock<tempfile::TempDir> = OnceLock::new();
    let dir = MADE.get_or_init(|| {
        let dir = tempfile::tempdir().unwrap();
        for name in ["back_street", "multilane", "signal_junction"] {
            let source = root().join("examples/drives").join(name);
            fine(dir.path(), &["ingest", "sumo", source.to_str().unwrap(), "--lake", "lake"]);
        }
        fine(dir.path(), &["mine", "--lake", "lake", "--out", "mined"]);
        let create = [
            "tasks",
            "create",
            "--from",
            "mined",
            "--project",
            "first",
            "--lake",
            "lake",
            "--data",
            "labels",
        ];
        fine(dir.path(), &create);
        accept_two(&dir.path().join("labels/labels.db"));
        dir
    });
    dir.path()
}

/// Marks two tasks as accepted, with what their histories would say.
fn accept_two(store: &Path) {
    let store = Store::open(store).unwrap();
    store
        .write(|tx| {
            let rows = tx.rows("SELECT id FROM tasks ORDER BY clip_id, keyframe_ns, scenario_id LIMIT 2", &[])?;
            for row in rows {
                let id = row.text("id")?;
                tx.run("UPDATE tasks SET state = 'accepted', author = 'ada', seq = 9 WHERE id = $1", values![&id])?;
                for (seq, at, action) in [(5, 0, "take"), (6, 60_000, "submit"), (8, 120_000, "accept")] {
                    tx.run(
                        "INSERT INTO history (task_id, seq, at, actor, action, version) VALUES ($1, $2, $3, 'ada', $4, 1)",
                        values![&id, seq, 1_790_000_000_000_i64 + at, action],
                    )?;
                }
            }
            Ok(())
        })
        .unwrap();
}

/// The fields of each class.
fn stages(csv: &str) -> BTreeMap<String, Vec<String>> {
    let fields = |line: &str| -> Vec<String> {
        // Commas between quotes belong to a name.
        let parts = line.split('"').enumerate();
        let marked: String =
            parts.map(|(i, p)| if i % 2 == 1 { p.replace(',', ";") } else { p.to_owned() }).collect();
        marked.split(',').map(str::to_owned).collect()
    };
    csv.lines().skip(1).map(fields).map(|f| (f[0].clone(), f)).collect()
}

#[test]
fn a_report_counts_every_stage_and_its_queries_can_be_mined() {
    let dir = project();
    let out = tempfile::tempdir().unwrap();
    let path = |name: &str| out.path().join(name).display().to_string();
    let (page, tables) = (path("report.html"), path("tables"));
    let report = [
        "report", "--lake", "lake", "--mined", "mined", "--labels", "labels", "--target", "3", "--rate",
        "60", "--out", &page, "--tables", &tables, "--format", "json",
    ];
    let json: Value = serde_json::from_str(&fine(dir, &report).out).unwrap();
    let analytics = &json["analytics"];
    let csv = fs::read_to_string(format!("{tables}/stages.csv")).unwrap();
    let stages = stages(&csv);
    assert!(csv.starts_with(
        "scenario_id,level,name_zh,name_en,state,mined,secondary,tasked,labelled,accepted,released,"
    ));
    // What mining says of itself, counted independently of the report.
    let episodes = fs::read_to_string(dir.join("mined/episodes.jsonl")).unwrap();
    let primary: Vec<Value> = episodes
        .lines()
        .map(|l| serde_json::from_str::<Value>(l).unwrap())
        .filter(|e| e["is_primary"] == true)
        .collect();
    let class = primary[0]["scenario_id"].as_str().unwrap();
    let of_class = primary.iter().filter(|e| e["scenario_id"] == class).count();
    assert_eq!(stages[class][5], of_class.to_string());
    let accepted: u64 = stages.values().filter(|f| f[1] == "l1").map(|f| f[9].parse::<u64>().unwrap()).sum();
    assert_eq!(accepted, 2);
    // Not observable is neither zero nor left out; releases were not given.
    let blind = stages.values().find(|f| f[4] == "not_observable").unwrap();
    assert_eq!((blind[5].as_str(), blind[10].as_str()), ("", ""));
    // Two tasks of 120 s minus the pause after submitting: 60 s each.
    let cost = analytics["progress"]["cost"]["per_label"].as_f64().unwrap();
    assert!((cost - 1.0).abs() < 1e-9, "{cost}");
    assert_eq!(analytics["given"]["releases"], false);
    // The outlook has the drives and hours that were searched, as mining says it; red_stop only that with lights.
    let coverage: Value =
        serde_json::from_str(&fs::read_to_string(dir.join("mined/coverage.json")).unwrap()).unwrap();
    let outlook = fs::read_to_string(format!("{tables}/outlook.csv")).unwrap();
    assert!(outlook.starts_with("scenario_id,episodes,drives,hours,"), "{outlook}");
    let clips = fs::read_to_string(dir.join("mined/clip_metadata.jsonl")).unwrap();
    let clips: Vec<Value> = clips.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let hours = |lacking: &BTreeSet<&str>| -> f64 {
        let of = clips.iter().map(|c| &c["clip_metadata"]);
        let of = of.filter(|c| !lacking.contains(c["drive_id"].as_str().unwrap()));
        of.map(|c| c["duration_sec"].as_f64().unwrap() / 3600.0).sum()
    };
    for leaf in coverage["leaves"].as_array().unwrap() {
        let (class, searched) =
            (leaf["scenario_id"].as_str().unwrap(), leaf["drives_searched"].as_u64().unwrap());
        let Some(line) = outlook.lines().find(|l| l.starts_with(&format!("{class},"))) else {
            assert_eq!((searched, &leaf["episodes"]), (0, &Value::from(0)), "{class}");
            continue;
        };
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[2].parse::<u64>().unwrap(), searched, "{line}");
        let gaps = leaf["gaps"].as_array().into_iter().flatten();
        let lacking = gaps.flat_map(|g| g["drives"].as_array().unwrap()).map(|d| d.as_str().unwrap());
        assert!((fields[3].parse::<f64>().unwrap() - hours(&lacking.collect())).abs() < 1e-6, "{line}");
        if class.ends_with("traffic_light.red_stop") {
            assert_eq!(searched, 1, "{line}");
        }
    }
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("<section class=\"analytics\"") && html.contains("尚未见到的场景"));

    let query = fs::read_dir(format!("{tables}/queries")).unwrap().flatten().next().unwrap().path();
    let mined = path("again");
    let run =
        whyroad_in(dir, &["mine", "--lake", "lake", "--query", query.to_str().unwrap(), "--out", &mined]);
    assert_eq!(run.code, 0, "{}", run.err);

    // The same inputs give the same page and tables.
    let again = [
        "report",
        "--lake",
        "lake",
        "--mined",
        "mined",
        "--labels",
        "labels",
        "--target",
        "3",
        "--rate",
        "60",
        "--out",
        &path("report-2.html"),
        "--tables",
        &path("tables-2"),
    ];
    fine(dir, &again);
    assert_eq!(html, fs::read_to_string(path("report-2.html")).unwrap());
    for file in ["stages.parquet", "shortfalls.parquet", "summary.csv"] {
        let read = |folder: &str| fs::read(Path::new(folder).join(file)).unwrap();
        assert_eq!(read(&tables), read(&path("tables-2")), "{file}");
    }
}

#[test]
fn the_documented_columns_are_those_of_the_tables() {
    let dir = project();
    let out = tempfile::tempdir().unwrap();
    let tables = out.path().join("tables");
    let page = out.path().join("r.html");
    let (t, p) = (tables.display().to_string(), page.display().to_string());
    fine(
        dir,
        &["report", "--lake", "lake", "--mined", "mined", "--labels", "labels", "--out", &p, "--tables", &t],
    );
    for name in ["analytics.md", "analytics.zh.md"] {
        let text = fs::read_to_string(root().join("docs/reference").join(name)).unwrap();
        let documented: BTreeMap<&str, String> = text
            .lines()
            .filter_map(|l| l.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | "))
            .filter(|(table, _)| tables.join(format!("{table}.csv")).is_file())
            .map(|(table, columns)| (table, columns.replace(", ", ",")))
            .collect();
        let written: BTreeSet<String> = fs::read_dir(&tables)
            .unwrap()
            .flatten()
            .filter_map(|f| f.file_name().to_str()?.strip_suffix(".csv").map(str::to_owned))
            .collect();
        assert!(written.len() > 8);
        assert_eq!(documented.keys().map(|k| (*k).to_owned()).collect::<BTreeSet<_>>(), written, "{name}");
        for (table, columns) in documented {
            let csv = fs::read_to_string(tables.join(format!("{table}.csv"))).unwrap();
            assert_eq!(csv.lines().next().unwrap(), columns, "{name}: {table}");
        }
    }
}

#[test]
fn the_documented_queries_run_on_the_tables_of_a_report() {
    if !duckdb::is_installed() {
        crate::require::skipped("python", "no duckdb");
        return;
    }
    let dir = project();
    let page = tempfile::tempdir().unwrap();
    let page = page.path().join("r.html").display().to_string();
    let report = [
        "report", "--lake", "lake", "--mined", "mined", "--labels", "labels", "--target", "3", "--out",
        &page, "--tables", "tables",
    ];
    fine(dir, &report);
    for name in ["analytics.md", "analytics.zh.md"] {
        let rows = duckdb::run_queries(&root().join("docs/how-to").join(name), dir);
        assert!(rows.len() >= 6 && rows.iter().all(|n| *n > 0), "{name}: {rows:?}");
    }
}

#[test]
fn a_changed_rule_is_compared_and_judged_by_accepted_labels() {
    let dir = project();
    let out = tempfile::tempdir().unwrap();
    // A framework without one rule: what it found is lost, or found by a class that came second before.
    let framework = out.path().join("framework");
    for folder in ["schema", "scenarios"] {
        copy(&root().join(folder), &framework.join(folder));
    }
    let episodes = fs::read_to_string(dir.join("mined/episodes.jsonl")).unwrap();
    let labels = fs::read_to_string({
        let file = out.path().join("accepted.jsonl");
        let export = fine(dir, &["tasks", "export", "--project", "first", "--data", "labels"]);
        fs::write(&file, &export.out).unwrap();
        file
    })
    .unwrap();
    let accepted: Value = serde_json::from_str(labels.lines().next().unwrap()).unwrap();
    let of = &accepted["scenario"];
    let l2 = format!("{}.{}", of["l1"].as_str().unwrap(), of["l2"].as_str().unwrap());
    let spec = framework.join(format!(
        "scenarios/{}/{}.yaml",
        of["l1"].as_str().unwrap(),
        of["l2"].as_str().unwrap()
    ));
    let text = fs::read_to_string(&spec).unwrap();
    // The rules of the L2 and its leaves are no longer rules.
    let changed = text.replace("mining:", "no_mining:");
    assert_ne!(changed, text);
    fs::write(&spec, changed).unwrap();
    let page = out.path().join("compare.html").display().to_string();
    let after = framework.display().to_string();
    let run = whyroad_in(
        dir,
        &[
            "compare", "bundled", &after, "--lake", "lake", "--labels", "labels", "--out", &page, "--format",
            "json",
        ],
    );
    assert!(run.code == 0 || run.code == 3, "{}", run.err);
    let json: Value = serde_json::from_str(&run.out).unwrap();
    let lost: u64 = json["classes"]
        .as_object()
        .unwrap()
        .iter()
        .filter(|(id, _)| id.starts_with(&l2))
        .map(|(_, c)| {
            c["changes"]["lost"].as_u64().unwrap_or(0) + c["changes"]["reclassified"].as_u64().unwrap_or(0)
        })
        .sum();
    let before = episodes.lines().filter(|l| l.contains(&format!("\"scenario_id\":\"{l2}"))).count() as u64;
    assert_eq!(lost, before, "every episode of the class is gone");
    let text = whyroad_in(dir, &["compare", "bundled", &after, "--lake", "lake", "--labels", "labels"]).out;
    assert!(text.contains("against accepted labels: gains "), "{text}");
    assert!(!text.contains("loses 0 "), "{text}");
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains("Changes by class") && html.contains("各场景的变化"));

    // Against itself nothing changes; a release and a mined folder have nothing to compare.
    let same = fine(dir, &["compare", "mined", "mined"]).out;
    assert!(same.contains(", gained 0, lost 0, reclassified 0"), "{same}");
    assert_eq!(whyroad_in(dir, &["compare", "bundled", "bundled"]).code, 1, "--lake is missing");
}

/// docs/how-to/analytics.md: `--labels` names a PostgreSQL store, `--key-file` the key that its secrets are sealed
/// with.
#[test]
fn a_report_reads_a_postgresql_store_with_the_key_file_that_is_named() {
    let Some(server) = Server::start() else { return };
    let (dir, out, url) = (project(), tempfile::tempdir().unwrap(), server.database());
    let path = |name: &str| out.path().join(name).display().to_string();
    let (key, page) = (path("key"), path("report.html"));
    let create = ["tasks", "create", "--from", "mined", "--lake", "lake", "--project", "p", "--limit", "2"];
    fine(dir, &[&create[..], &["--store", &url, "--data", &path("data"), "--key-file", &key]].concat());
    let report =
        ["report", "--lake", "lake", "--mined", "mined", "--out", &page, "--summary", "--labels", &url];
    let found = fine(dir, &[&report[..], &["--key-file", &key]].concat()).out;
    assert!(found.contains("unfinished tasks 2; remaining 2; "), "{found}");
    let without = whyroad_in(dir, &report);
    assert!(without.code == 1 && without.err.contains("--key-file"), "{}", without.err);
    let compare = ["compare", "mined", "mined", "--labels", &url, "--key-file", &key];
    fine(dir, &compare);
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() { copy(&path, &target) } else { fs::copy(&path, &target).map(|_| ()).unwrap() }
    }
}

#[test]
fn labels_and_tasks_are_carried_along_by_a_mapping() {
    let dir = project();
    let out = tempfile::tempdir().unwrap();
    copy(&dir.join("labels"), &out.path().join("labels"));
    let export = fine(out.path(), &["tasks", "export", "--project", "first", "--data", "labels"]).out;
    fs::write(out.path().join("accepted.jsonl"), &export).unwrap();
    let label: Value = serde_json::from_str(export.lines().next().unwrap()).unwrap();
    let text = |v: &Value| v.as_str().unwrap().to_owned();
    let (l1, l2) = (text(&label["scenario"]["l1"]), text(&label["scenario"]["l2"]));
    let from = match label["scenario"]["l3"].as_str() {
        Some(l3) => format!("{l1}.{l2}.{l3}"),
        None => format!("{l1}.{l2}"),
    };
    fine(out.path(), &["taxonomy", "migrate", "mapping.yaml", "--init"]);
    let template = fs::read_to_string(out.path().join("mapping.yaml")).unwrap();
    // The template is a valid mapping that changes nothing.
    let nothing = ["taxonomy", "migrate", "mapping.yaml", "--store", "labels", "--format", "json"];
    let json: Value = serde_json::from_str(&fine(out.path(), &nothing).out).unwrap();
    assert_eq!(json["store"]["moved"], serde_json::json!([]));
    assert_eq!(json["store"]["unknown"], serde_json::json!([]));
    let to = "reactive_agent.cutin.slow";
    let to = if from == to { "reactive_agent.cutin.urgent" } else { to };
    let changes = format!(
        "changes:\n  - rename: {from}\n    to: {}",
        if from.matches('.').count() == 2 { to } else { "reactive_agent.cutin" }
    );
    fs::write(out.path().join("mapping.yaml"), template.replace("changes: []", &changes)).unwrap();
    let migrate = |more: &[&str]| -> Value {
        let mut args = vec!["taxonomy", "migrate", "mapping.yaml", "--store", "labels", "--format", "json"];
        args.extend(more);
        serde_json::from_str(&fine(out.path(), &args).out).unwrap()
    };
    let dry = migrate(&["--dry-run"]);
    let done = migrate(&["--labels", "accepted.jsonl", "--out", "carried"]);
    assert_eq!(dry["store"], done["store"]);
    assert!(done["store"]["moved"].as_array().unwrap().iter().any(|m| m["from"] == from.as_str()));
    let carried = fs::read_to_string(out.path().join("carried/accepted.jsonl")).unwrap();
    assert_eq!(carried.lines().count(), export.lines().count());
    assert_ne!(carried, export);
    assert_eq!(fs::read_to_string(out.path().join("accepted.jsonl")).unwrap(), export, "the original stays");
    let again = migrate(&[]);
    assert_eq!(again["store"]["moved"], serde_json::json!([]));
    // A mistake is named where it is, and nothing is done.
    fs::write(
        out.path().join("wrong.yaml"),
        template.replace("changes: []", "changes: [{ rename: a.b.c, to: a.b.d }]"),
    )
    .unwrap();
    let wrong = whyroad_in(out.path(), &["taxonomy", "migrate", "wrong.yaml", "--store", "labels"]);
    assert_eq!(wrong.code, 1);
    assert!(wrong.err.contains("mapping.class") && wrong.err.contains("wrong.yaml:"), "{}", wrong.err);
}
