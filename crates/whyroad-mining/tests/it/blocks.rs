//! A `mining:` block with faults: all of them are reported, each at its position (lines and columns counted by hand),
//! and a bare rule is checked against the cases beside it.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use whyroad_mining::rule::file::{Checked, check_file};
use whyroad_mining::rule::origin::SourceFile;
use whyroad_signals::Catalog;

fn check(text: &str, cases: Option<&str>) -> Checked {
    let cases = cases.map(|text| SourceFile { name: "mine.cases.yaml", text });
    check_file(SourceFile { name: "mine.yaml", text }, cases, &BTreeMap::new(), Catalog::bundled())
}

const FAULTY: &str = r#"mining:
  target: vehicel
  parameters:
    close: { value: 12, reason: "12 m is a car and a half" }
    nope: 3 m
    x: { value: 3 km }
    far: { valeu: 3 km, reason: "ours" }
  define:
    a: "b and ego.speed > 3 m/s"
    b: "target.distance < close"
    c: [1, 2]
  when: "target.distnace < 3 m"
  mindur: 3 s
  min_duration: 3
  merge_gap: 2 m
  max_duration: { at: 3 }
  require: "far whithin 3 s"
"#;

#[test]
fn every_fault_of_a_block_is_told_where_it_stands() {
    let found = check(FAULTY, None).found;
    let mut reported: Vec<(usize, usize, &str)> = found
        .iter()
        .map(|d| (d.location.line.unwrap_or(0), d.location.column.unwrap_or(0), d.message.en.as_str()))
        .collect();
    reported.sort_unstable();
    let expected = [
        (2, 11, "'vehicel' is not a kind of target"),
        (5, 5, "a parameter has a value and a reason, as in { value: 3 m, reason: \"...\" }"),
        (6, 5, "the parameter has no reason"),
        (7, 5, "the parameter has no value"),
        (7, 12, "unknown field 'valeu'"),
        (9, 9, "'b' is defined below the definition that uses it"),
        (10, 9, "units do not match: a length (m) and a number without a unit"),
        (11, 5, "c is text, not a list"),
        (12, 10, "signal or parameter 'target.distnace' not found"),
        (13, 3, "unknown field 'mindur'"),
        (14, 17, "expected a time"),
        (15, 14, "expected a time"),
        (16, 3, "max_duration is text, not a mapping"),
        (17, 17, "the expression should end here; found 'whithin'"),
    ];
    assert_eq!(reported, expected);
    let hint = |part: &str| {
        let d = found.iter().find(|d| d.message.en.contains(part)).unwrap();
        (d.hint.as_ref().unwrap().en.clone(), d.hint.as_ref().unwrap().zh.clone())
    };
    assert_eq!(hint("'mindur'"), ("did you mean 'min_duration'?".into(), "是否想写 'min_duration'？".into()));
    assert_eq!(hint("'valeu'").0, "did you mean 'value'?");
    assert_eq!(hint("'whithin'").0, "did you mean `within`?");
    assert!(found.iter().all(|d| d.message.zh != d.message.en), "{found:#?}");
}

#[test]
fn a_block_is_a_mapping_with_a_condition() {
    for (text, said) in [
        ("mining: [1]\n", "a mining block is a mapping, not a list"),
        ("mining:\n  target: any\n", "`when`, the condition that makes a match, is missing"),
        ("mining:\n  target: any\n  when: []\n", "`when`, the condition that makes a match, is missing"),
    ] {
        let found = check(text, None).found;
        let reported: Vec<&str> = found.iter().map(|d| d.message.en.as_str()).collect();
        assert_eq!(reported, [said], "{text}");
    }
}

/// YAML makes numbers of `0.3` and `-2`; a rule may be written so.
#[test]
fn a_number_needs_no_quotes_and_one_requirement_no_list() {
    let text = "parameters: { half: { value: 0.5, reason: ours } }\nwhen: \"share(ego.standstill, 3 s) > half\"\nrequire: \"ego.speed < 1 m/s\"\n";
    assert_eq!(check(text, None).found, vec![]);
}

const RULE: &str = "target: vehicle\nwhen: \"target.is_follower and target.distance < 12 m for 2 s\"\n";

const CASES: &str = r#"
base: { target.is_follower: "true" }
cases:
  - name: close behind for four seconds
    kind: positive
    duration: 12 s
    target: car
    signals: { target.distance: "30 m for 3 s, 10 m for 4 s, 30 m" }
    expect: [{ keyframe: 3 s, start: 3 s, end: 7 s }]
  - name: wrong on purpose, too short
    kind: positive
    duration: 12 s
    target: car
    signals: { target.distance: "30 m for 3 s, 10 m for 1 s, 30 m" }
    expect: [{ keyframe: 3 s }]
  - name: wrong on purpose, a time is no distance
    kind: negative
    duration: 12 s
    target: car
    signals: { target.distance: "30 s" }
    expect: []
  - name: wrong on purpose, no such signal
    kind: negative
    duration: 12 s
    target: car
    signals: { target.distanc: "30 m" }
    expect: []
"#;

#[test]
fn a_bare_rule_is_held_to_the_cases_beside_it() {
    let checked = check(RULE, Some(CASES));
    assert_eq!((checked.rules, checked.cases), (1, 4));
    let reported: Vec<(Option<usize>, &str)> = checked
        .found
        .iter()
        .map(|d| (d.location.line, d.message.en.split(" fails: ").last().unwrap()))
        .collect();
    assert_eq!(
        reported,
        [
            (Some(10), "1 expected, found nothing"),
            (Some(16), "target.distance: units do not match: the signal has m, this has s"),
            (Some(22), "signal 'target.distanc' not found; did you mean 'target.distance'?"),
        ]
    );
    assert!(checked.found.iter().all(|d| d.message.zh.contains("不成立：")), "{:?}", checked.found);
}
