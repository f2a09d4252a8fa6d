//! Queries with clauses beyond DATA_FORMAT.md 5.1: they mean what the same words mean in the rule language, and what
//! is wrong with them is shown. Expected frames are read off the speeds by hand.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use serde_json::{Value, json};
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::{Episode, RuleSet, mine_drive};
use whyroad_model::{Column, Diagnostic, Lang, Nanos, SignalTable, diagnostic};
use whyroad_signals::Catalog;

/// 10 Hz; m/s.
const SPEEDS: [f64; 12] = [0.0, 0.0, 9.0, 9.0, 9.0, 0.0, 4.0, 4.0, 0.0, 9.0, 0.0, 0.0];

fn matched(conditions: Value) -> Result<Vec<(usize, usize)>, Vec<Diagnostic>> {
    let tenths: Vec<i64> = (0..SPEEDS.len() as i64).map(|i| 100 * i).collect();
    Ok(mined(conditions, &tenths, &SPEEDS)?.iter().map(|e| (e.matched.start, e.matched.end)).collect())
}

/// Episodes of a drive with frames at `times_ms`.
fn mined(conditions: Value, times_ms: &[i64], speeds: &[f64]) -> Result<Vec<Episode>, Vec<Diagnostic>> {
    let query =
        json!({ "mining_query": { "scenario_id": "reactive_agent.cutin", "conditions": conditions } });
    let text = format!("{query:#}");
    let query = parse_query(&text, "query.json", Framework::bundled())?;
    let rule = compile_query(&query, Catalog::bundled(), &text, "query.json")?.unwrap();
    let table = SignalTable {
        times: times_ms.iter().map(|t| Nanos(t * 1_000_000)).collect(),
        frame_columns: BTreeMap::from([("ego.speed".to_owned(), Column::Number(speeds.to_vec()))]),
        ..SignalTable::default()
    };
    let rules = RuleSet { rules: vec![rule], ..RuleSet::default() };
    Ok(mine_drive(&rules, &table).episodes)
}

fn faster_than(speed: f64) -> Value {
    json!({ "field": "ego.speed", "operator": ">", "value": speed, "unit": "m/s" })
}

#[test]
fn clauses_mean_what_the_rule_language_means() {
    let (fast, moving) = (faster_than(8.0), faster_than(1.0));
    let cases = [
        (json!([fast]), vec![(2, 5), (9, 10)]),
        (json!([{ "all": [moving, { "not": fast }] }]), vec![(6, 8)]),
        (json!([{ "any": [fast, { "all": [moving, { "not": fast }] }] }]), vec![(2, 5), (6, 8), (9, 10)]),
        (json!([{ "temporal": "for", "seconds": 0.3, "condition": fast }]), vec![(2, 5)]),
        (json!([{ "temporal": "within", "seconds": 0.1, "condition": fast }]), vec![(1, 5), (8, 10)]),
        (json!([{ "temporal": "previously", "seconds": 0.1, "condition": fast }, moving]), vec![(3, 5)]),
        (json!([{ "temporal": "rises", "condition": fast }]), vec![(2, 3), (9, 10)]),
        (json!([{ "temporal": "falls", "condition": fast }]), vec![(5, 6), (10, 11)]),
        (
            json!([{ "temporal": "then", "seconds": 0.2, "first": fast, "second": { "not": moving } }]),
            vec![(5, 6), (10, 12)],
        ),
        (
            json!([{ "temporal": "until", "seconds": 0.2, "first": moving, "second": { "not": moving } }, moving]),
            vec![(3, 5), (6, 8), (9, 10)],
        ),
        (
            json!([{ "temporal": "since", "first": { "not": fast }, "second": { "rule": "falls(ego.speed > 8 m/s)" } }]),
            vec![(5, 9), (10, 12)],
        ),
        (json!([{ "rule": "ego.speed > 8 m/s for 0.3 s" }, moving]), vec![(2, 5)]),
    ];
    for (conditions, expected) in cases {
        assert_eq!(matched(conditions.clone()).unwrap(), expected, "{conditions}");
    }
}

/// The time range of an episode holds its match. The frame at 0.4 s lasts until 0.5 s; the next one, behind the
/// gap, is farther from that than it is itself.
#[test]
fn a_range_that_ends_with_the_last_frame_before_a_gap_holds_that_frame() {
    let times = [0, 100, 200, 300, 400, 605, 705];
    let speeds = [0.0, 0.0, 0.0, 9.0, 9.0, 0.0, 0.0];
    let found = mined(json!([faster_than(8.0)]), &times, &speeds).unwrap();
    let [episode] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!((episode.keyframe, episode.range.start, episode.range.end), (3, 3, 5));
    assert!(episode.context.end >= 5);
}

#[test]
fn faults_in_clauses_are_shown() {
    let fast = faster_than(8.0);
    let cases = [
        json!([fast, { "any": [fast, { "field": "ego.sped", "operator": ">", "value": 1 }] }]),
        json!([{ "not": { "rule": "ego.speed > 8 s" } }]),
        json!([{ "temporal": "for", "condition": fast }]),
        json!([{ "temporal": "then", "seconds": 1, "condition": fast }]),
        json!([{ "temporal": "sometimes", "condition": fast }]),
        json!([{ "any": [fast], "not": fast }]),
        json!([{ "any": [] }]),
        json!([{ "field": "ego.speed", "operator": ">" }]),
    ];
    let text: Vec<String> = cases
        .into_iter()
        .flat_map(|c| match matched(c) {
            Ok(found) => panic!("{found:?}"),
            Err(found) => found,
        })
        .map(|d| diagnostic::render_text(&d, Lang::En))
        .collect();
    insta::assert_snapshot!(text.join("\n"));
}
