//! `other`: decision moments that no class explains. Frames are set by hand.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use whyroad_mining::rule::other::other;
use whyroad_mining::rule::text::compile_text;
use whyroad_mining::{RuleSet, mine_drive};
use whyroad_model::{Column, Nanos, SignalTable, Tri};
use whyroad_signals::Catalog;

/// 20 s at 10 Hz; the ego responds for 0.5 s from each of these frames on, and brakes in `brakes`.
fn drive(responds: &[usize], brakes: std::ops::Range<usize>) -> SignalTable {
    let flags = |of: &dyn Fn(usize) -> bool| Column::Flag((0..200).map(|f| Tri::from(of(f))).collect());
    SignalTable {
        times: (0..200).map(|i| Nanos(i * 100_000_000)).collect(),
        frame_columns: BTreeMap::from([
            ("ego.responds".to_owned(), flags(&|f| responds.iter().any(|r| (*r..r + 5).contains(&f)))),
            ("ego.brake".to_owned(), flags(&|f| brakes.contains(&f))),
        ]),
        ..SignalTable::default()
    }
}

/// One class that explains braking, and the moments that it does not.
fn mined(table: &SignalTable) -> Vec<(String, usize, (usize, usize))> {
    let class = "reactive_agent.cutin.urgent".parse().unwrap();
    let rule = compile_text("ego.brake", None, &class, Catalog::bundled(), "test").unwrap();
    let rules = RuleSet { rules: vec![rule], ..RuleSet::default() };
    let rules = rules.with_decision_moments(Catalog::bundled());
    let found = mine_drive(&rules, table).episodes;
    found.iter().map(|e| (e.scenario.to_string(), e.keyframe, (e.range.start, e.range.end))).collect()
}

#[test]
fn a_moment_that_nothing_explains_is_other() {
    // 2 s before and 3 s after it.
    assert_eq!(mined(&drive(&[100], 0..0)), [("other".to_owned(), 100, (80, 130))]);
}

#[test]
fn a_moment_in_the_time_range_of_a_class_or_near_its_keyframe_is_explained() {
    let braking = || ("reactive_agent.cutin.urgent".to_owned(), 90, (90, 150));
    assert_eq!(mined(&drive(&[120], 90..150)), [braking()]);
    assert_eq!(mined(&drive(&[85], 90..150)), [braking()], "0.5 s before");
    let early = ("other".to_owned(), 75, (55, 105));
    assert_eq!(mined(&drive(&[75, 120], 90..150)), [early, braking()], "1.5 s before");
}

#[test]
fn moments_close_together_are_one() {
    let keyframes = |responds: &[usize]| -> Vec<usize> {
        mined(&drive(responds, 0..0)).into_iter().map(|(_, keyframe, _)| keyframe).collect()
    };
    assert_eq!(keyframes(&[50, 57]), [50]);
    assert_eq!(keyframes(&[50, 65]), [50, 65]);
}

#[test]
fn where_decisions_cannot_be_seen_other_is_not_observable() {
    let mut table = drive(&[], 0..0);
    table.frame_columns.remove("ego.responds");
    let rules = RuleSet::default().with_decision_moments(Catalog::bundled());
    let found = mine_drive(&rules, &table);
    assert!(found.episodes.is_empty());
    assert_eq!(found.missing[&other()], ["ego.responds"]);
}
