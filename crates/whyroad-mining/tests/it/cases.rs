//! The cases beside the rules, all of them; and the proof that the harness can fail.

use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_mining::cases::{CaseKind, run_cases};
use whyroad_model::{Lang, diagnostic};
use whyroad_signals::Catalogue;

fn case_files() -> BTreeMap<String, String> {
    Framework::bundled_files().into_iter().filter(|(path, _)| path.ends_with(".cases.yaml")).collect()
}

fn rules() -> RuleSet {
    RuleSet::of_framework(Framework::bundled(), Catalogue::bundled()).0
}

#[test]
fn every_rule_keeps_its_cases() {
    let rules = rules();
    let mut cases = BTreeMap::new();
    let files = case_files();
    let mut failures = String::new();
    for (file, text) in &files {
        let tally = run_cases(file, text, &rules, Catalogue::bundled());
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
    let l2s: std::collections::BTreeSet<_> = rules.rules.iter().map(|r| r.scenario.l2.clone()).collect();
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
    let tally = run_cases("wrong.cases.yaml", wrong, &rules(), Catalogue::bundled());
    let places: Vec<_> = tally.failures.iter().map(|d| (d.code, d.location.line)).collect();
    assert_eq!(places, [6, 11, 16, 21].map(|line| ("rule.case", Some(line))));
}
