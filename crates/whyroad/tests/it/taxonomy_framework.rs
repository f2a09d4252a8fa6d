//! `whyroad taxonomy` on framework folders: what lint says of rules, specs, signals and precedence, and what diff says
//! of two folders.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::session::{root, whyroad_in};
use serde_json::Value;
use std::path::Path;
use whyroad_framework::Framework;

/// A folder with `mine/schema` and `mine/scenarios`: ours with `changes` (file, text, its replacement).
fn framework(changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for top in ["schema", "scenarios"] {
        copy(&root().join(top), &folder.path().join("mine").join(top));
    }
    for (file, from, to) in changes {
        let path = folder.path().join("mine").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    }
    folder
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

const CUTIN: &str = "scenarios/reactive_agent/cutin.yaml";

#[test]
fn lint_checks_what_is_written_in_the_rule_language() {
    // File, text, its replacement, the code, a word of the hint.
    for (file, from, to, code, hint) in [
        (
            CUTIN,
            "[\"target.ttc < urgent_ttc\"]",
            "[\"target.tcc < urgent_ttc\"]",
            "rule.signal.unknown",
            "target.ttc",
        ),
        // An expression of an L1, which has no rule; an expression of a leaf that has none.
        ("scenarios/safety.yaml", "keyframe + 3 s", "keyframe + 3 sec", "rule.unit.unknown", ""),
        ("scenarios/safety/aeb.yaml", "rises(ego.aeb)", "rises(ego.aebb)", "rule.signal.unknown", "ego.aeb"),
        ("schema/precedence.yaml", "- safety.aeb\n", "- safety.abe\n", "rule.precedence", ""),
        (
            "schema/signals.yaml",
            "scope: frame\n    type: number\n    unit: m/s3",
            "scope: target\n    type: number\n    unit: m/s3",
            "signals.changed",
            "",
        ),
    ] {
        let folder = framework(&[(file, from, to)]);
        let run = whyroad_in(folder.path(), &["--framework", "mine", "taxonomy", "lint", "--format", "json"]);
        assert_eq!(run.code, 1, "{to}: {}", run.err);
        let found: Value = serde_json::from_str(&run.out).unwrap();
        let found: Vec<&Value> =
            found["diagnostics"].as_array().unwrap().iter().filter(|d| d["code"] == code).collect();
        assert!(!found.is_empty(), "{to}: {}", run.out);
        let text = std::fs::read_to_string(folder.path().join("mine").join(file)).unwrap();
        let first = to.lines().next().unwrap();
        let line = text.lines().position(|l| l.contains(first)).unwrap() + 1;
        let place = &found[0]["place"];
        assert_eq!(place["file"].as_str().unwrap().replace('\\', "/"), format!("mine/{file}"));
        assert_eq!(place["line"], line, "{to}: {}", run.out);
        assert!(found[0]["hint"].as_str().unwrap_or_default().contains(hint), "{}", found[0]);
    }
}

#[test]
fn a_broken_rule_is_reported_once_and_its_cases_are_skipped() {
    let folder = framework(&[(CUTIN, "target.wheel_over_line and", "target.weel_over_line and")]);
    let run = whyroad_in(folder.path(), &["--framework", "mine", "taxonomy", "lint", "--format", "json"]);
    let found: Value = serde_json::from_str(&run.out).unwrap();
    let codes: Vec<&str> =
        found["diagnostics"].as_array().unwrap().iter().map(|d| d["code"].as_str().unwrap()).collect();
    assert_eq!(run.code, 1);
    assert!(codes.contains(&"rule.signal.unknown"), "{codes:?}");
    assert_eq!(codes.iter().filter(|c| **c == "rule.case.skipped").count(), 1, "{codes:?}");
    assert!(!codes.contains(&"rule.case"), "{codes:?}");
}

#[test]
fn every_command_reports_faults_of_the_signal_catalog() {
    let (from, to) =
        ("scope: frame\n    type: number\n    unit: m/s3", "scope: target\n    type: number\n    unit: m/s3");
    let folder = framework(&[("schema/signals.yaml", from, to)]);
    let lake = folder.path().join("lake");
    let drive = root().join("examples/drives/multilane");
    let (lake, drive) = (lake.to_str().unwrap(), drive.to_str().unwrap());
    let run = whyroad_in(folder.path(), &["ingest", "sumo", drive, "--lake", lake]);
    assert_eq!(run.code, 0, "{}", run.err);
    let run = whyroad_in(folder.path(), &["mine", "--lake", lake, "--scenario", "aeb", "--out", "mined"]);
    assert_eq!(run.code, 0, "{}", run.err);
    for args in [
        &["explain", "cutin.urgent", "--lake", lake, "--clip", "multilane-ego_000"][..],
        &["report", "--lake", lake, "--mined", "mined"],
        &["rules", "check", "mine/scenarios/safety/aeb.yaml"],
        &["taxonomy", "list"],
    ] {
        let run = whyroad_in(folder.path(), &[&["--framework", "mine"], args].concat());
        let said = format!("{}{}", run.out, run.err);
        assert_eq!(said.matches("error[signals.changed]").count(), 1, "{args:?}: {said}");
        assert!(said.replace('\\', "/").contains("mine/schema/signals.yaml:"), "{args:?}: {said}");
    }
}

/// docs/how-to/edit-the-framework.md: `validate` exits with 1, other commands with 3 where they would have exited with
/// 0.
#[test]
fn an_error_in_a_rule_changes_the_exit_code_of_every_command() {
    let folder = framework(&[(CUTIN, "[\"target.ttc < urgent_ttc\"]", "[\"target.tcc < urgent_ttc\"]")]);
    let label = root().join("examples/cutin_urgent_example.json");
    let label = label.to_str().unwrap();
    for (args, code) in [
        (&["validate", label][..], 1),
        (&["taxonomy", "list"], 3),
        (&["taxonomy", "show", "cutin.urgent"], 3),
    ] {
        let run = whyroad_in(folder.path(), &[&["--framework", "mine"], args].concat());
        assert_eq!(run.code, code, "{args:?}: {}", run.err);
        assert_eq!(whyroad_in(folder.path(), args).code, 0, "{args:?} with the built-in framework");
    }
    let show = whyroad_in(folder.path(), &["--framework", "mine", "taxonomy", "show", "cutin.urgent"]);
    assert!(show.out.contains("it has an error and is not used"), "{}", show.out);
    assert!(show.err.contains("1 error in the rules of the framework"), "{}", show.err);
}

/// The same page: exit code 1 of `mine` is for faulty rules.
#[test]
fn warnings_of_a_framework_change_no_exit_code() {
    let texts = "schema/draft_texts.yaml";
    let folder = framework(&[(texts, "\n  reactive_agent.cutin:", "\n  reactive_agent.cut_in:")]);
    let drive = root().join("examples/drives/multilane");
    let run = whyroad_in(folder.path(), &["ingest", "sumo", drive.to_str().unwrap(), "--lake", "lake"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let mine = ["--framework", "mine", "mine", "--lake", "lake", "--scenario", "cutin", "--out", "mined"];
    let run = whyroad_in(folder.path(), &mine);
    assert!(run.err.contains("warning[lexicon.class]"), "{}", run.err);
    assert_eq!(run.code, 0, "{}", run.err);
}

#[test]
fn migrate_takes_json_lines_and_names_classes_that_do_not_exist() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    assert_eq!(whyroad_in(at, &["taxonomy", "migrate", "mapping.yaml", "--init"]).code, 0);
    let migrate = |file: &str| {
        whyroad_in(at, &["taxonomy", "migrate", "mapping.yaml", "--labels", file, "--out", "migrated"])
    };
    // One document over many lines: one message, and nothing is written.
    let pretty = std::fs::read_to_string(root().join("examples/lane_change_example.json")).unwrap();
    std::fs::write(at.join("pretty.json"), &pretty).unwrap();
    let run = migrate("pretty.json");
    assert_eq!((run.code, run.err.matches("JSON Lines").count()), (1, 1), "{}", run.err);
    assert!(!at.join("migrated/pretty.json").exists());
    // A class that no taxonomy has any more, and that the mapping does not name.
    let label: Value = serde_json::from_str(&pretty).unwrap();
    let gone = label.to_string().replace("\"lane_change\"", "\"lane_changing\"");
    std::fs::write(at.join("labels.jsonl"), format!("{label}\n{gone}\n")).unwrap();
    let run = migrate("labels.jsonl");
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.out.contains("labels.jsonl:2") && !run.out.contains("labels.jsonl:1"), "{}", run.out);
}

#[test]
fn lint_shows_a_rule_as_a_person_reads_it() {
    let folder = framework(&[(CUTIN, "[\"target.ttc < urgent_ttc\"]", "[\"target.tcc < urgent_ttc\"]")]);
    for lang in ["en", "zh"] {
        let run = whyroad_in(folder.path(), &["--framework", "mine", "--lang", lang, "taxonomy", "lint"]);
        assert_eq!(run.code, 1);
        // Lines move when rules are edited; the rest is what a person reads.
        let text: String = run.out.lines().map(|l| without_line_numbers(l) + "\n").collect();
        insta::assert_snapshot!(format!("lint_rule_{lang}"), text);
    }
}

/// Digits before ` |` and the line in `file:line:column` as `N`.
fn without_line_numbers(line: &str) -> String {
    if let Some((number, rest)) = line.split_once('|')
        && number.trim().chars().all(|c| c.is_ascii_digit())
    {
        return format!("{}|{rest}", if number.trim().is_empty() { "  " } else { "N " });
    }
    match line.split_once(".yaml:") {
        Some((file, rest)) => {
            let (_, rest) = rest.split_once(':').unwrap_or_default();
            format!("{file}.yaml:N:{rest}")
        }
        None => line.to_owned(),
    }
}

/// Labeling of the leaf `urgent` with another start and a record, a parameter of its rule, and an L1's default.
const CHANGES: &[(&str, &str, &str)] = &[
    (
        CUTIN,
        "  urgent:\n    labeling:\n",
        "  urgent:\n    labeling:\n      records: [{ id: gap_taken, name: { zh: 所占间距, en: gap taken }, unit: m }]\n",
    ),
    (CUTIN, "urgent_ttc: { value: 3 s", "urgent_ttc: { value: 4 s"),
    ("scenarios/safety.yaml", "    after_s: 3\n", "    after_s: 2\n"),
    (
        "scenarios/records.yaml",
        "\nrecords:\n",
        "\nrecords:\n  gap_taken: { type: number, min: 0, max: 100 }\n",
    ),
];

#[test]
fn diff_compares_labelling_specs_and_mining_rules_of_two_folders() {
    let folder = framework(CHANGES);
    for lang in ["en", "zh"] {
        let run = whyroad_in(folder.path(), &["--lang", lang, "taxonomy", "diff", "bundled", "mine"]);
        assert_eq!((run.code, run.err.as_str()), (1, ""));
        insta::assert_snapshot!(format!("diff_specs_{lang}"), run.out);
    }
    let version = "version: \"2.0.0\"";
    let mut raised = CHANGES.to_vec();
    raised.push((CUTIN, version, "version: \"3.0.0\""));
    raised.push(("scenarios/safety.yaml", version, "version: \"2.1.0\""));
    let folder = framework(&raised);
    let run = whyroad_in(folder.path(), &["taxonomy", "diff", "bundled", "mine", "--format", "json"]);
    let found: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((run.code, found["version_check"].as_str()), (0, Some("consistent")), "{}", run.out);
}

#[test]
fn diff_says_when_it_compares_classes_only() {
    let folder = framework(CHANGES);
    let run =
        whyroad_in(folder.path(), &["taxonomy", "diff", "bundled", "mine/schema/scenario_taxonomy.yaml"]);
    assert_eq!(run.code, 0);
    assert!(run.err.contains("holds classes only"), "{}", run.err);
}

#[test]
fn lint_names_classes_that_are_calibrated_and_do_not_exist() {
    let folder = framework(&[(
        "schema/calibration.yaml",
        "reactive_agent.following.steady",
        "reactive_agent.following.steadz",
    )]);
    let run = whyroad_in(folder.path(), &["--framework", "mine", "taxonomy", "lint"]);
    assert_eq!(run.code, 1);
    assert!(run.out.contains("warning[calibration.class]"), "{}", run.out);
    assert!(
        run.out.contains("no class 'reactive_agent.following.steadz'")
            && run.err.contains("0 errors, 1 warning")
    );
}

#[test]
fn docs_brings_the_generated_parts_of_a_spec_page_up_to_date() {
    let folder = framework(&[]);
    let docs = folder.path().join("mine/docs/reference");
    let args = |last: &'static [&'static str]| [&["--framework", "mine", "taxonomy", "docs"], last].concat();
    // Without a SPEC.md only the taxonomy's page is written.
    assert_eq!(whyroad_in(folder.path(), &args(&[])).code, 0);
    assert!(docs.join("TAXONOMY.md").is_file() && !docs.join("SPEC.md").exists());
    assert!(docs.join("signals.md").is_file() && !docs.join("diagnostics.md").exists());
    let ours = std::fs::read_to_string(root().join("docs/reference/SPEC.md")).unwrap();
    std::fs::write(docs.join("SPEC.md"), ours.replacen("`stop_for_regulation`", "`stop_for_rule`", 2))
        .unwrap();
    let stale = whyroad_in(folder.path(), &args(&["--check"]));
    assert_eq!(stale.code, 1);
    assert!(stale.err.contains("SPEC.md is not up to date"), "{}", stale.err);
    assert_eq!(whyroad_in(folder.path(), &args(&[])).code, 0);
    assert_eq!(whyroad_in(folder.path(), &args(&["--check"])).code, 0);
    std::fs::write(docs.join("SPEC.md"), "# no markers\n").unwrap();
    let run = whyroad_in(folder.path(), &args(&[]));
    assert_eq!(run.code, 1);
    assert!(run.err.contains("has no line `<!-- generated: longitudinal decisions -->`"), "{}", run.err);
}

#[test]
fn docs_writes_a_page_for_every_leaf_and_removes_those_of_none() {
    let folder = framework(CHANGES);
    let leaves = folder.path().join("mine/docs/reference/leaves");
    let args = |last: &'static [&'static str]| [&["--framework", "mine", "taxonomy", "docs"], last].concat();
    let none = whyroad_in(folder.path(), &args(&["--check"]));
    assert_eq!((none.code, none.err.matches("error[").count()), (1, 1), "{}", none.err);
    assert!(none.err.contains("generated files exists") && none.err.contains("run `whyroad taxonomy docs`"));
    assert_eq!(whyroad_in(folder.path(), &args(&[])).code, 0);
    assert_eq!(whyroad_in(folder.path(), &args(&["--check"])).code, 0);
    // A page in each language and a drawing for each leaf.
    let all = Framework::bundled().taxonomy.leaves().count();
    assert_eq!(std::fs::read_dir(&leaves).unwrap().count(), 3 * all);
    let page = |name: &str| std::fs::read_to_string(leaves.join(name)).unwrap();
    let urgent = page("reactive_agent.cutin.urgent.md");
    // What CHANGES says, and cutin.cases.yaml and the taxonomy say of this leaf.
    for text in [
        "**Required records**: `gap_taken`: gap taken (m)",
        "| `urgent_ttc` | 4 s | TAXONOMY.md, cutin.urgent |",
        "| 1 | positive | a car comes in close and the ego closes on it | keyframe 5 s, range 3 to 6.5 s |",
        "not observable without `target.in_ego_lane`, `target.wheel_over_line`",
        "| `target.ttc` | s | Time to collision along the path",
        "[`reactive_agent.cutin.slow`](reactive_agent.cutin.slow.md)",
        "![Cases of this leaf](reactive_agent.cutin.urgent.svg)",
    ] {
        assert!(urgent.contains(text), "{text}\n{urgent}");
    }
    assert!(page("reactive_agent.cutin.urgent.zh.md").contains("**必填记录**：`gap_taken`：所占间距 (m)"));
    assert!(page("reactive_agent.cutin.urgent.svg").contains("target.wheel_over_line"));
    let old = leaves.join("reactive_agent.cutin.gone.md");
    std::fs::write(&old, "# gone\n").unwrap();
    let stale = whyroad_in(folder.path(), &args(&["--check"]));
    assert_eq!(stale.code, 1);
    assert!(stale.err.contains("cutin.gone.md is not up to date") && old.is_file(), "{}", stale.err);
    assert_eq!(whyroad_in(folder.path(), &args(&[])).code, 0);
    assert!(!old.exists());
}

#[test]
fn init_writes_the_built_in_framework_and_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let run = whyroad_in(folder.path(), &["taxonomy", "init", "mine"]);
    assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
    // What was written is the repository's, cases and prompts included, and says the same as the built-in one.
    for file in [CUTIN, "scenarios/reactive_agent/cutin.cases.yaml", "schema/signals.yaml"] {
        let (ours, theirs) = (root().join(file), folder.path().join("mine").join(file));
        assert_eq!(std::fs::read(ours).unwrap(), std::fs::read(theirs).unwrap(), "{file}");
    }
    assert!(folder.path().join("mine/prompts").is_dir());
    let run = whyroad_in(folder.path(), &["--framework", "mine", "taxonomy", "list"]);
    assert!(run.code == 0 && run.out.contains("cutin"), "{}{}", run.out, run.err);
    std::fs::write(folder.path().join("mine").join(CUTIN), "changed").unwrap();
    let run = whyroad_in(folder.path(), &["taxonomy", "init", "mine"]);
    assert!(run.code != 0 && run.err.contains("exists"), "{}", run.err);
    assert_eq!(std::fs::read_to_string(folder.path().join("mine").join(CUTIN)).unwrap(), "changed");
}
