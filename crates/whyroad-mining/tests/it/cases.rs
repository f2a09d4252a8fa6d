//! The cases beside the rules, all of them; and the proof that the harness can fail.

use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::cases::{CaseKind, CaseRunner};
use whyroad_model::{Lang, Severity, diagnostic};
use whyroad_signals::Catalog;

fn case_files() -> BTreeMap<String, String> {
    Framework::bundled_files().into_iter().filter(|(path, _)| path.ends_with(".cases.yaml")).collect()
}

fn rules() -> RuleSet {
    RuleSet::of_framework(Framework::bundled(), Catalog::bundled()).0
}

#[test]
fn every_rule_keeps_its_cases() {
    let rules = rules();
    let mut cases = BTreeMap::new();
    let files = case_files();
    let mut failures = String::new();
    let runner = CaseRunner { rules: &rules, catalog: Catalog::bundled(), faulty: &BTreeSet::new() };
    for (file, text) in &files {
        let tally = runner.run(file, text);
        for d in tally.failures {
            failures += &diagnostic::render_text(&d, Lang::En);
        }
        for (key, n) in tally.cases {
            *cases.entry(key).or_insert(0) += n;
        }
    }
    assert!(failures.is_empty(), "{failures}");
    // A rule without one kind of case has not been thought through.
    for rule in &rules.rules {
        for kind in [CaseKind::Positive, CaseKind::Negative, CaseKind::Boundary, CaseKind::Unknown] {
            assert!(
                cases.contains_key(&(rule.scenario.clone(), kind)),
                "{} has no {kind:?} case",
                rule.scenario
            );
        }
    }
    let total: usize = cases.values().sum();
    let l2s: BTreeSet<_> = rules.rules.iter().map(|r| r.scenario.l2.clone()).collect();
    assert_eq!(files.len(), l2s.len(), "one file of cases for each L2 with rules");
    println!("{total} cases in {} files", files.len());
    assert!(total >= 4 * rules.rules.len());
}

#[test]
fn a_wrong_case_fails() {
    let wrong = r#"
version: "2.0.0"
l1: proactive
l2: lane_change
cases:
  - name: wrong on purpose, nothing happens here
    kind: positive
    duration: 10 s
    signals: { ego.lane_change: "none" }
    expect: [{ keyframe: 4 s }]
  - name: wrong on purpose, it happens at another time
    kind: positive
    duration: 10 s
    signals: { ego.lane_change: "none for 4 s, left for 3 s, none" }
    expect: [{ keyframe: 4.5 s }]
  - name: wrong on purpose, it happens
    kind: negative
    duration: 10 s
    signals: { ego.lane_change: "none for 4 s, left for 3 s, none" }
    expect: []
  - name: wrong on purpose, it is observable
    kind: unknown
    duration: 10 s
    signals: { ego.lane_change: "none" }
    expect: []
    not_observable: [ego.lane_change]
"#;
    let runner = CaseRunner { rules: &rules(), catalog: Catalog::bundled(), faulty: &BTreeSet::new() };
    let tally = runner.run("wrong.cases.yaml", wrong);
    let places: Vec<_> = tally.failures.iter().map(|d| (d.code, d.location.line)).collect();
    assert_eq!(places, [6, 11, 16, 21].map(|line| ("rule.case", Some(line))));
}

/// One value that no case can have: the others are run. Lines, columns and numbers of cases are counted in the text.
#[test]
fn a_wrong_value_costs_its_case_only() {
    let file = "scenarios/reactive_agent/cutin.cases.yaml";
    let text = &case_files()[file];
    let all = text.matches("  - name: ").count();
    let runner = CaseRunner { rules: &rules(), catalog: Catalog::bundled(), faulty: &BTreeSet::new() };
    for (from, to, zh, hint) in [
        ("    target: car\n", "    target: cra\n", "没有取值 `cra`，可用：", Some("did you mean 'car'?")),
        (
            "    kind: positive\n",
            "    kinds: positive\n",
            "没有字段 `kinds`，可用：",
            Some("did you mean 'kind'?"),
        ),
        ("    kind: positive\n", "", "缺少字段 `kind`", None),
    ] {
        let at = text.find(from).unwrap_or_else(|| panic!("{from}"));
        let tally = runner.run(file, &text.replacen(from, to, 1));
        assert_eq!(tally.cases.values().sum::<usize>(), all - 1, "{to}");
        let [fault] = &tally.failures[..] else { panic!("{to}: {:?}", tally.failures) };
        assert!(fault.message.zh.contains(zh) && fault.message.en.contains("cannot be read: "), "{fault:?}");
        assert!(
            fault.message.zh.starts_with("用例 '") && fault.message.en.starts_with("case '"),
            "{fault:?}"
        );
        assert_eq!(fault.hint.as_ref().map(|h| h.en.as_str()), hint);
        let (line, column) = (fault.location.line.unwrap(), fault.location.column.unwrap());
        if to.is_empty() {
            // The case as a whole: its name, on the line before or earlier.
            assert!(line <= text[..at].matches('\n').count(), "{fault:?}");
        } else {
            let column_of = |value: &str| to.find(value).unwrap() + 1;
            let value = if to.contains("cra") { column_of("cra") } else { column_of("kinds") };
            assert_eq!((line, column), (text[..at].matches('\n').count() + 1, value), "{fault:?}");
        }
    }
    let misspelled = text.replacen("    leaf: urgent\n", "    leaf: urgnt\n", 1);
    let fault = &runner.run(file, &misspelled).failures[0];
    assert_eq!(fault.hint.as_ref().unwrap().en, "did you mean 'reactive_agent.cutin.urgent'?");
}

/// Without its file, each rule lacks all kinds of cases; without one case, at most its own.
#[test]
fn a_rule_without_a_kind_of_case_is_reported() {
    let (rules, mut files) = (rules(), case_files());
    let runner = CaseRunner { rules: &rules, catalog: Catalog::bundled(), faulty: &BTreeSet::new() };
    let missing =
        |files: &BTreeMap<String, String>| runner.run_all(files).missing(&rules, Framework::bundled());
    assert_eq!(missing(&files), []);
    let cutin = "scenarios/reactive_agent/cutin.cases.yaml";
    let unreadable = files[cutin].replacen("cases:", "cases", 1);
    let broken: BTreeMap<_, _> = files.clone().into_iter().chain([(cutin.to_owned(), unreadable)]).collect();
    assert_eq!(missing(&broken), [], "an unreadable file is reported as that");
    files.remove(cutin);
    let found = missing(&files);
    let cutins = rules.rules.iter().filter(|r| r.scenario.l2.as_deref() == Some("cutin"));
    assert_eq!(found.len(), cutins.count());
    for d in found {
        assert_eq!((d.code, d.severity), ("rule.case.missing", Severity::Warning));
        assert!(d.message.en.ends_with(": positive, negative, boundary, unknown"), "{d:?}");
        assert_eq!(d.location.file.as_deref(), Some("scenarios/reactive_agent/cutin.yaml"));
        assert!(d.location.line.is_some());
    }
}

#[test]
fn cases_of_a_faulty_rule_are_skipped_with_one_note() {
    let (cutin, rules) = ("scenarios/reactive_agent/cutin", RuleSet::default());
    let files = case_files();
    let text = &files[&format!("{cutin}.cases.yaml")];
    let run = |faulty: &[String]| {
        let faulty = faulty.iter().cloned().collect();
        let runner = CaseRunner { rules: &rules, catalog: Catalog::bundled(), faulty: &faulty };
        runner.run(&format!("{cutin}.cases.yaml"), text)
    };
    // Counted by hand in the file: one `- name:` per case.
    let cases = text.matches("  - name: ").count();
    let skipped = run(&[format!("{cutin}.yaml")]);
    let [note] = &skipped.failures[..] else { panic!("{:?}", skipped.failures) };
    assert_eq!((note.code, note.severity), ("rule.case.skipped", Severity::Note));
    assert!(note.message.en.starts_with(&format!("{cases} cases were not run")), "{}", note.message.en);
    // Without a fault that explains it, a missing rule is an error, once per class.
    let missing = run(&["scenarios/reactive_agent/animal.yaml".to_owned()]);
    let classes: BTreeSet<&str> = missing.failures.iter().map(|d| d.message.en.as_str()).collect();
    assert_eq!(classes.len(), missing.failures.len(), "{classes:?}");
    assert!(missing.failures.iter().all(|d| d.code == "rule.case" && d.severity == Severity::Error));
    assert!(!missing.failures.is_empty() && missing.cases.is_empty());
}

/// The L2's own rule is silent only where a leaf knows the variant: its cases cannot be judged while a leaf has errors.
#[test]
fn cases_of_an_l2_are_not_judged_without_its_faulty_leaf() {
    let mut rules = rules();
    rules.rules.retain(|r| r.scenario.to_string() != "reactive_agent.cutin.urgent");
    let cutin = "scenarios/reactive_agent/cutin";
    let text = &case_files()[&format!("{cutin}.cases.yaml")];
    let failures = |faulty: BTreeSet<String>| {
        let runner = CaseRunner { rules: &rules, catalog: Catalog::bundled(), faulty: &faulty };
        runner.run(&format!("{cutin}.cases.yaml"), text).failures
    };
    let found = failures([format!("{cutin}.yaml")].into());
    assert!(found.iter().all(|d| d.code == "rule.case.skipped" && d.severity == Severity::Note), "{found:?}");
    assert!(
        found.iter().any(|d| d.message.en.contains("reactive_agent.cutin cannot be judged")),
        "{found:?}"
    );
    assert!(failures(BTreeSet::new()).iter().any(|d| d.code == "rule.case"), "the proof that one fails");
}

#[test]
fn a_value_that_all_cases_share_is_reported_once_where_it_is() {
    let file = "scenarios/reactive_agent/cutin.cases.yaml";
    let text = case_files()[file].replacen("ego.mean_speed: \"12 m/s\"", "ego.mean_speed: \"12\"", 1);
    let line = text.lines().position(|l| l.contains("ego.mean_speed: \"12\"")).unwrap() + 1;
    let rules = rules();
    let runner = CaseRunner { rules: &rules, catalog: Catalog::bundled(), faulty: &BTreeSet::new() };
    let [error, note] = &runner.run(file, &text).failures[..] else { panic!("one error and one note") };
    assert_eq!((error.code, error.location.line), ("rule.case", Some(line)));
    assert!(error.message.en.contains("units do not match") && error.hint.is_some());
    assert_eq!((note.code, note.severity), ("rule.case.skipped", Severity::Note));
}

/// What uses a signal whose entry has an error is left out without another error.
#[test]
fn an_error_in_the_catalog_is_not_repeated_in_rules_and_cases() {
    let text = include_str!("../../../../schema/signals.yaml");
    let at = text.find("- name: target.ttc\n").unwrap();
    let broken = format!("{}{}", &text[..at], text[at..].replacen("unit: s", "unit: sekunden", 1));
    let (catalog, of_signals) = Catalog::parse(&broken);
    assert_eq!(of_signals.len(), 1);
    let framework = Framework::bundled();
    let (rules, found) = RuleSet::of_framework(framework, &catalog);
    assert!(found.is_empty(), "{found:?}");
    let urgent = "reactive_agent.cutin.urgent".parse().unwrap();
    assert!(rules.unusable(framework).contains(&urgent) && !rules.rules.iter().any(|r| r.scenario == urgent));
    assert!(whyroad_mining::rule::lint::lint(framework, &catalog).is_empty());
    let faulty = rules.files_left_out(framework);
    assert!(faulty.contains("scenarios/reactive_agent/cutin.yaml"));
    let runner = CaseRunner { rules: &rules, catalog: &catalog, faulty: &faulty };
    let errors: Vec<_> = runner
        .run_all(&case_files())
        .failures
        .into_iter()
        .filter(|d| d.severity == Severity::Error)
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
}
