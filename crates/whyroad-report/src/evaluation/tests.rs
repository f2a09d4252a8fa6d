//! Expected figures are counted by hand from the definition in issue 4 "Truth".
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use super::*;
use crate::fixture;
use proptest::prelude::*;
use truth::TruthSet;
use whyroad_model::Nanos;

const URGENT: &str = "reactive_agent.cutin.urgent";
const SLOW: &str = "reactive_agent.cutin.slow";

fn episode(class: &str, target: Option<&str>, [start, keyframe, end]: [f64; 3]) -> EpisodeRecord {
    let mut e = fixture::episode(&fixture::drive("d"));
    e.episode_id = format!("{class}@{keyframe}");
    e.scenario_id = class.parse().unwrap();
    e.target_id = target.map(Into::into);
    e.time_range.start_timestamp = Nanos::from_secs_f64(start);
    e.time_range.end_timestamp = Nanos::from_secs_f64(end);
    e.keyframe.timestamp = Nanos::from_secs_f64(keyframe);
    e.is_primary = true;
    e
}

fn line(class: &str, target: Option<&str>, at: [f64; 3]) -> String {
    let [start, keyframe, end] = at.map(|s| Nanos::from_secs_f64(s).0);
    let target = target.map_or(String::new(), |t| format!(r#","target_id":"{t}""#));
    format!(
        r#"{{"scenario_id":"{class}","drive_id":"d","start_ns":{start},"keyframe_ns":{keyframe},"end_ns":{end}{target}}}"#
    )
}

fn truth(complete: &[&str], lines: &[String]) -> TruthSet {
    let mut set = TruthSet::default();
    let classes = complete.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>().join(",");
    let text = format!("{{\"complete\":[{classes}],\"drives\":[\"d\"]}}\n{}", lines.join("\n"));
    let problems = set.read(&text, "truth.jsonl", &|_| true);
    assert!(problems.is_empty(), "{problems:?}");
    set
}

#[test]
fn an_optional_entry_counts_neither_way() {
    let optional = |at| line(URGENT, Some("a"), at).replace('}', r#","optional":true}"#);
    let t = truth(
        &[URGENT],
        &[
            optional([4.0, 5.0, 6.0]),
            optional([24.0, 25.0, 26.0]),
            line(URGENT, Some("a"), [14.0, 15.0, 16.0]),
        ],
    );
    // One at the first optional entry, none at the second, one at the plain entry, one where nothing is.
    let found = [5.0, 15.0, 35.0].map(|k| episode(URGENT, Some("a"), [k - 1.0, k, k + 1.0]));
    let e = evaluate(&t, &found);
    let c = &e.classes[&URGENT.parse().unwrap()];
    assert_eq!((c.truth, c.matched, c.missed, c.spurious, c.unjudged), (1, 1, 0, 1, 1));
    // A plain entry is paired before an optional one takes its episode.
    let both = truth(&[URGENT], &[optional([14.0, 15.0, 16.0]), line(URGENT, None, [14.0, 15.4, 16.0])]);
    let c = evaluate(&both, &found[1..2]).classes[&URGENT.parse().unwrap()].clone();
    assert_eq!((c.truth, c.matched, c.spurious), (1, 1, 0));
}

#[test]
fn each_is_used_once_and_the_rest_is_missed_or_false() {
    let t = truth(
        &[URGENT],
        &[line(URGENT, Some("a"), [4.0, 5.0, 6.0]), line(URGENT, Some("b"), [14.0, 15.0, 16.0])],
    );
    // Two episodes at one truth: one is false. `b` is another target: the truth stays missed.
    let found = [
        episode(URGENT, Some("a"), [4.0, 5.4, 6.0]),
        episode(URGENT, Some("a"), [4.0, 5.1, 6.0]),
        episode(URGENT, Some("c"), [14.0, 15.0, 16.0]),
    ];
    let e = evaluate(&t, &found);
    let c = &e.classes[&URGENT.parse().unwrap()];
    assert_eq!((c.truth, c.matched, c.missed, c.spurious), (2, 1, 1, 2));
    assert_eq!((c.precision, c.recall), (Some(1.0 / 3.0), Some(0.5)));
    assert!((c.f1.unwrap() - 0.4).abs() < 1e-12);
    // The nearer keyframe is the one that is paired.
    assert!((c.keyframe_error_median_s.unwrap() - 0.1).abs() < 1e-9);
    assert_eq!(e.spurious.iter().map(|s| s.keyframe).collect::<Vec<_>>().len(), 2);
}

#[test]
fn a_second_apart_or_three_tenths_of_overlap_is_the_limit() {
    let at = |keyframe: f64, start: f64, end: f64| {
        let t = truth(&[URGENT], &[line(URGENT, None, [0.0, 5.0, 10.0])]);
        evaluate(&t, &[episode(URGENT, Some("a"), [start, keyframe, end])]).total.matched
    };
    assert_eq!(at(6.0, 5.9, 6.1), 1, "1 s is still the same moment");
    assert_eq!(at(6.01, 6.0, 6.1), 0, "1.01 s and an overlap of 0.01");
    // [0, 10) and [x, 13): 10 - x over 13; x = 6.1 gives 3.9 / 13 = 0.3.
    assert_eq!(at(12.0, 6.1, 13.0), 1, "intersection over union 0.3");
    assert_eq!(at(12.0, 6.2, 13.0), 0, "3.8 / 13 = 0.292");
}

#[test]
fn pairing_takes_as_many_as_can_be() {
    // The first truth could take either episode, the second only the one that is nearest to the first.
    let t = truth(&[URGENT], &[line(URGENT, None, [4.9, 5.0, 5.1]), line(URGENT, None, [5.8, 5.9, 6.0])]);
    let found = [episode(URGENT, None, [4.9, 5.0, 5.1]), episode(URGENT, None, [4.0, 4.1, 4.2])];
    assert_eq!(evaluate(&t, &found).total.matched, 2);
}

#[test]
fn what_is_not_declared_complete_is_not_judged() {
    let t = truth(&[SLOW], &[line(URGENT, None, [4.0, 5.0, 6.0])]);
    let found = [episode(URGENT, None, [4.0, 5.0, 6.0]), episode(URGENT, None, [14.0, 15.0, 16.0])];
    let e = evaluate(&t, &found);
    let c = &e.classes[&URGENT.parse().unwrap()];
    assert_eq!((c.matched, c.spurious, c.unjudged, c.recall), (1, 0, 1, Some(1.0)));
    assert_eq!((c.precision, c.f1, e.macro_f1), (None, None, None), "unknown, not 1 and not 0");
}

#[test]
fn nothing_found_of_a_complete_class_counts_as_zero() {
    let t = truth(&[URGENT], &[line(URGENT, None, [4.0, 5.0, 6.0])]);
    let e = evaluate(&t, &[episode(SLOW, None, [4.0, 5.0, 6.0])]);
    assert_eq!(e.macro_f1, Some(0.0));
    let confusion = &e.confusions[0];
    assert_eq!(
        (confusion.truth.to_string().as_str(), confusion.found.to_string().as_str(), confusion.count),
        (URGENT, SLOW, 1)
    );
}

#[test]
fn a_class_without_its_variant_is_matched_by_any_variant() {
    let t = truth(&["reactive_agent.cutin"], &[line("reactive_agent.cutin", None, [4.0, 5.0, 6.0])]);
    let e = evaluate(&t, &[episode(SLOW, None, [4.0, 5.0, 6.0])]);
    assert_eq!((e.total.matched, e.total.spurious, e.total.f1), (1, 0, Some(1.0)));
}

#[test]
fn drives_that_the_truth_does_not_speak_of_are_left_alone() {
    let mut other = episode(URGENT, None, [4.0, 5.0, 6.0]);
    other.drive_id = "elsewhere".into();
    let e = evaluate(&truth(&[URGENT], &[]), &[other]);
    assert!(e.classes.is_empty());
}

#[test]
fn a_bad_line_is_named_and_the_rest_is_read() {
    let good = line(URGENT, None, [4.0, 5.0, 6.0]);
    let late = line(URGENT, None, [4.0, 7.0, 6.0]);
    let text = format!(
        "{{\"complete\":[\"no.such\"],\"drives\":[\"d\"]}}\n{good}\n{{\"scenario_id\":1}}\n{late}\n{}",
        line("not.a.class", None, [0.0, 0.0, 0.0])
    );
    let mut set = TruthSet::default();
    let problems = set.read(&text, "t.jsonl", &|c| c.l1 == "reactive_agent");
    assert_eq!(problems.iter().map(|p| p.location.line.unwrap()).collect::<Vec<_>>(), [1, 3, 4, 5]);
    assert!(
        problems
            .iter()
            .all(|p| p.code == "evaluate.truth.line" && p.location.file.as_deref() == Some("t.jsonl"))
    );
    assert_eq!(set.entries.len(), 1);
}

/// Largest number of pairs by trying all subsets: what the pairing must reach.
fn most_pairs(left: usize, right: usize, fits: &dyn Fn(usize, usize) -> bool) -> usize {
    fn go(l: usize, left: usize, used: u32, right: usize, fits: &dyn Fn(usize, usize) -> bool) -> usize {
        if l == left {
            return 0;
        }
        let skip = go(l + 1, left, used, right, fits);
        (0..right)
            .filter(|&r| used & (1 << r) == 0 && fits(l, r))
            .map(|r| 1 + go(l + 1, left, used | (1 << r), right, fits))
            .fold(skip, usize::max)
    }
    go(0, left, 0, right, fits)
}

proptest! {
    #[test]
    fn no_pairing_has_more(edges in proptest::collection::vec(proptest::option::of(0.0..1.0f64), 30)) {
        let fits = |l: usize, r: usize| edges[l * 6 + r];
        let made = pairs(5, 6, fits);
        prop_assert!(made.iter().all(|&(l, r)| fits(l, r).is_some()));
        let distinct = |of: &dyn Fn(&(usize, usize)) -> usize| made.iter().map(of).collect::<std::collections::BTreeSet<_>>().len();
        prop_assert_eq!(distinct(&|p| p.0), made.len());
        prop_assert_eq!(distinct(&|p| p.1), made.len());
        prop_assert_eq!(made.len(), most_pairs(5, 6, &|l, r| fits(l, r).is_some()));
    }
}
