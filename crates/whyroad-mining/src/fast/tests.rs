//! The fast evaluator against the reference: random programs over random signal tables (unknown values, lost
//! frames, jitter, windows in which no frame lies, signals that the drive lacks, objects with holes). Bundled rules
//! on whole drives are in `tests/fast.rs`.

mod random;

use super::layout::RowSet;
use super::{Evaluation, Plan, Signals, find_all};
use crate::episode::{Episode, Found, find};
use crate::interpret::{Evaluator, Moments, Roles, Series};
use crate::language::program::{Moment, NodeId, Op, Program, ValueKind};
use crate::rule::{ResponseCondition, Rule, Timing};
use proptest::prelude::*;
use random::{plain_rule, rule, table};
use whyroad_model::messages::EgoResponse;
use whyroad_model::{Bilingual, Column, FrameRange, Nanos, SignalTable, Tri};

/// Equal but for the last bits of a score.
fn same(fast: &[Found], reference: &[Found]) {
    assert_eq!(fast.len(), reference.len());
    for (f, r) in fast.iter().zip(reference) {
        assert_eq!(f.missing, r.missing);
        assert_eq!(f.episodes.len(), r.episodes.len(), "{:#?}\nagainst\n{:#?}", f.episodes, r.episodes);
        for (a, b) in f.episodes.iter().zip(&r.episodes) {
            assert!((a.score - b.score).abs() <= 1e-9, "{} against {}", a.score, b.score);
            assert_eq!(a, &Episode { score: a.score, ..b.clone() });
        }
    }
}

/// Truths and margins of every node of a rule's program, in every row of every pass, with and without an episode.
fn same_values(rule: &Rule, table: &SignalTable) {
    let plan = Plan::of_rules([rule]);
    let signals = Signals::of_table(table);
    let fast = Evaluation::new(&plan, &signals);
    let mut reference = Evaluator::new(&rule.program, table);
    let n = table.times.len();
    let episode = Moments { keyframe: n / 2, matched: FrameRange::new(n / 3, n / 2 + 1) };
    let mut passes = vec![(RowSet::Drive, Roles::default())];
    for (i, a) in table.targets.iter().enumerate() {
        passes.push((RowSet::Object(i), Roles { target: Some(a), second: None }));
        for (k, b) in table.targets.iter().enumerate().filter(|(k, _)| *k != i) {
            let there = match &table.pairs {
                Some(pairs) => pairs.find(i, k).is_some(),
                None => !a.frames.intersect(b.frames).is_empty(),
            };
            if there {
                passes.push((RowSet::Pair(i, k), Roles { target: Some(a), second: Some(b) }));
            }
        }
    }
    for moments in [None, Some(episode)] {
        fast.set_episode(moments);
        for (row_set, roles) in &passes {
            let mut pass = reference.pass_of(*roles);
            if let Some(moments) = moments {
                pass = reference.at_episode(&pass, moments);
            }
            for i in 0..rule.program.nodes.len() {
                let local = NodeId(i);
                let of = plan.rules[0].node(local);
                let what =
                    || format!("{:?} at {row_set:?} of {:?}", rule.program.nodes[i].op, rule.program.nodes);
                match reference.series(local, &mut pass).as_ref() {
                    Series::Truths(t) => {
                        let truth = fast.truth(of, *row_set);
                        let rows = t.value.len();
                        assert_eq!(
                            (0..truth.len()).map(|k| truth.at(k)).collect::<Vec<_>>(),
                            t.value,
                            "{}",
                            what()
                        );
                        // Any part has the same value alone and in the whole.
                        for part in [0..rows, rows / 3..rows / 2, rows / 2..rows] {
                            let margins = fast.margins(of, *row_set, part.clone());
                            for (a, b) in margins.iter().zip(&t.margin[part.clone()]) {
                                let equal = (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-9;
                                assert!(equal, "{margins:?}\nagainst\n{:?}\n{}", &t.margin[part], what());
                            }
                            assert_eq!(margins.len(), part.len());
                        }
                    }
                    Series::Numbers(v) => {
                        let numbers = fast.numbers(of, *row_set);
                        for (k, x) in v.iter().enumerate() {
                            let y = numbers.at(k);
                            assert!(*x == y || (x.is_nan() && y.is_nan()), "{x} against {y}: {}", what());
                        }
                    }
                    Series::Categories(..) => {}
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, ..ProptestConfig::default() })]

    #[test]
    fn every_node_has_the_values_of_the_reference(table in table(), rule in rule()) {
        same_values(&rule, &table);
    }

    #[test]
    fn random_rules_find_what_the_reference_finds(table in table(), rules in prop::collection::vec(rule(), 1..4)) {
        let plan = Plan::of_rules(&rules);
        let signals = Signals::of_table(&table);
        let reference: Vec<Found> = rules.iter().map(|r| find(r, &table)).collect();
        same(&find_all(&plan, &signals), &reference);
    }
}

/// A rule that matches while `ego.f` holds.
fn while_flagged(timing: impl Fn(NodeId) -> Timing) -> Rule {
    let mut program = Program::default();
    let flag = program.add(Op::Signal("ego.f".into()), ValueKind::Condition);
    Rule { timing: timing(flag), ..plain_rule(program, flag) }
}

/// The flag holds in these frames of a drive with frames at these times.
fn flagged(times_ms: &[i64], frames: FrameRange) -> SignalTable {
    let flags = (0..times_ms.len()).map(|i| Tri::from(frames.contains(i))).collect();
    SignalTable {
        drive_id: "d".into(),
        times: times_ms.iter().map(|ms| Nanos(ms * 1_000_000)).collect(),
        frame_columns: [("ego.f".to_owned(), Column::Flag(flags))].into(),
        ..SignalTable::default()
    }
}

/// The only episode of the rule, which both evaluators find alike.
fn only_episode(rule: &Rule, table: &SignalTable) -> Episode {
    let found = find(rule, table);
    same(&find_all(&Plan::of_rules([rule]), &Signals::of_table(table)), std::slice::from_ref(&found));
    let [episode] = found.episodes.as_slice() else { panic!("{:#?}", found.episodes) };
    episode.clone()
}

/// docs/reference/rules.md: "The time range always contains the keyframe."
#[test]
fn the_time_range_holds_the_last_frame_before_a_gap() {
    let at_last =
        |flag| Timing { keyframe: vec![(Moment::Last(flag), Bilingual::new("", ""))], ..Timing::of_match() };
    // One frame lost, and three.
    for times in [[0, 100, 200, 400, 500], [0, 100, 200, 600, 700]] {
        let episode = only_episode(&while_flagged(at_last), &flagged(&times, FrameRange::new(1, 3)));
        assert_eq!(episode.keyframe, 2);
        assert_eq!(episode.range, FrameRange::new(1, 3), "{times:?}");
    }
}

/// docs/reference/rules.md: a response is searched from the start of the match to the end of the time range; here the
/// range ends before the match begins.
#[test]
fn an_answer_that_was_looked_for_in_no_frame_is_unknown() {
    let before_match = |_| Timing {
        keyframe: vec![(
            Moment::Offset(Box::new(Moment::MatchStart), Nanos(-300_000_000)),
            Bilingual::new("", ""),
        )],
        end: vec![Moment::Keyframe],
        ..Timing::of_match()
    };
    let mut rule = while_flagged(before_match);
    let lacking = rule.program.add(Op::Signal("ego.g".into()), ValueKind::Condition);
    let table = flagged(&[0, 100, 200, 300, 400, 500, 600], FrameRange::new(5, 6));
    for condition in [lacking, rule.when] {
        rule.response = Some(ResponseCondition { condition, of_target: false });
        let episode = only_episode(&rule, &table);
        assert_eq!(episode.range, FrameRange::new(2, 3));
        assert_eq!(episode.response, EgoResponse::Unknown);
    }
}
