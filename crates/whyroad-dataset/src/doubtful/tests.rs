//! The cases of `tests/data/cleanlab.json` were written by `tests/data/cleanlab_cases.py`, which runs cleanlab 2.9.

use super::confident::find_label_issues;
use super::*;
use crate::score::predictions::Prediction;
use serde::Deserialize;

#[derive(Deserialize)]
struct Fixture {
    cleanlab: String,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    labels: Vec<usize>,
    probabilities: Vec<Vec<f64>>,
    joint: Vec<Vec<usize>>,
    ranked: Vec<usize>,
}

fn fixture() -> Fixture {
    serde_json::from_str(include_str!("../../tests/data/cleanlab.json")).unwrap()
}

#[test]
fn the_same_labels_as_cleanlab_on_the_same_numbers() {
    let fixture = fixture();
    assert!(fixture.cleanlab.starts_with("2.9"), "{}", fixture.cleanlab);
    assert!(fixture.cases.len() >= 6);
    for case in &fixture.cases {
        let found = find_label_issues(&case.labels, &case.probabilities);
        assert_eq!(found.joint, case.joint, "joint of {}", case.name);
        assert_eq!(found.ranked, case.ranked, "labels of {}", case.name);
        let flagged = found.mask.iter().filter(|m| **m).count();
        assert_eq!(flagged, case.ranked.len(), "{}", case.name);
    }
    let all: usize = fixture.cases.iter().map(|c| c.ranked.len()).sum();
    assert!(all > 20, "the cases have too few doubtful labels to tell anything: {all}");
}

#[test]
fn a_changed_probability_changes_the_result() {
    // The comparison above can fail: with the first doubtful label's probability raised to 1, it is doubtful no longer.
    let case = &fixture().cases[0];
    let mut probabilities = case.probabilities.clone();
    let first = case.ranked[0];
    probabilities[first] =
        (0..probabilities[first].len()).map(|k| f64::from(u8::from(k == case.labels[first]))).collect();
    assert!(!find_label_issues(&case.labels, &probabilities).mask[first]);
}

#[test]
fn no_samples_give_no_result() {
    let found = find_label_issues(&[], &[]);
    assert!(found.mask.is_empty() && found.joint.is_empty());
}

#[test]
fn samples_get_names_and_those_without_probabilities_are_reported() {
    let truth: Vec<Truth> = (0..7)
        .map(|i| Truth {
            sample_id: format!("s{i}"),
            drive: "d".into(),
            // The sixth label is wrong.
            longitudinal: Some(if i < 3 || i == 5 { "resume" } else { "yield_to_agent" }.into()),
            ..Truth::default()
        })
        .collect();
    let probable = |i: usize, resume: f64| Prediction {
        sample_id: format!("s{i}"),
        probabilities: BTreeMap::from([(
            Target::Longitudinal,
            BTreeMap::from([("resume".to_owned(), resume), ("yield_to_agent".to_owned(), 1.0 - resume)]),
        )]),
        ..Prediction::default()
    };
    let rows = [0.95, 0.9, 0.97, 0.05, 0.08, 0.03];
    let predictions = Predictions::new(rows.iter().enumerate().map(|(i, p)| probable(i, *p)));
    let (found, lost) = find(&truth, &predictions, Target::Longitudinal);
    assert_eq!(lost.iter().map(|d| d.code).collect::<Vec<_>>(), ["doubtful.probability.missing"]);
    assert_eq!(found.samples, 6);
    assert_eq!(found.labels.len(), 1, "{found:?}");
    let one = &found.labels[0];
    assert_eq!(
        (one.sample_id.as_str(), one.given.as_str(), one.suggested.as_str()),
        ("s5", "resume", "yield_to_agent")
    );
    assert!((one.given_probability - 0.03).abs() < 1e-12);
}
