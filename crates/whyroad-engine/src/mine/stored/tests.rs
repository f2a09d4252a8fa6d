//! Stored signals against signals in memory: decisions from the statistics of a file change no result.

#[path = "../../../../whyroad-mining/src/fast/tests/random.rs"]
mod random;

use super::find_stored;
use proptest::prelude::*;
use random::{rule, table};
use whyroad_mining::episode::{Episode, Found, find};
use whyroad_mining::fast::Plan;
use whyroad_model::{FrameRange, SignalTable};

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

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, ..ProptestConfig::default() })]

    #[test]
    fn stored_signals_and_their_statistics_change_no_answer(
        table in table(),
        rules in prop::collection::vec(rule(), 1..6),
    ) {
        // Signals of pairs are derived when a rule uses them, and never stored.
        let table = SignalTable { pairs: None, ..table };
        let dir = tempfile::tempdir().expect("a folder");
        whyroad_lake::signals::write_signals(dir.path(), "v", &[("h".to_owned(), &table)]).expect("written");
        let file = whyroad_lake::SignalFile::open(dir.path()).expect("readable").expect("there");
        let plan = Plan::of_rules(&rules);
        let all: Vec<usize> = (0..rules.len()).collect();
        let stored = find_stored(&plan, &file, 0, &all).expect("read");
        let reference: Vec<Found> = rules.iter().map(|r| find(r, &table)).collect();
        same(&stored, &reference);
    }
}

/// A rule that cannot hold, by the statistics of one signal; whether that is *known* depends on the object's class.
#[test]
fn what_cannot_hold_is_still_not_observable_where_nothing_is_known() {
    use crate::language::program::{Op, Program, Subject, ValueKind};
    use crate::language::syntax::CompareOp;
    use whyroad_model::signal::TargetSpan;
    use whyroad_model::units::Dimension;
    use whyroad_model::{Column, Nanos, ObjectClass};
    const N: f64 = f64::NAN;
    let rule = |subject| {
        let mut program = Program::default();
        let number = ValueKind::Number(Dimension::Length);
        let bound = program.add(Op::Constant(-5.0), number.clone());
        let less = |name: &str, program: &mut Program| {
            let left = program.add(Op::Signal(name.into()), number.clone());
            program.add(
                Op::Compare { op: CompareOp::Less, left, right: bound, scale: 1.0 },
                ValueKind::Condition,
            )
        };
        let all = vec![less("target.gap", &mut program), less("target.ttc", &mut program)];
        let when = program.add(Op::And(all), ValueKind::Condition);
        let mut rule = random::plain_rule(program, when);
        rule.subject = Some(subject);
        rule
    };
    // A pedestrian whose gap is known, a car whose gap is not; no time to collision is known for any object.
    let span = |i: usize, class| TargetSpan {
        id: format!("t{i}").as_str().into(),
        class,
        first_row: 2 * i,
        frames: FrameRange::new(0, 2),
    };
    let table = SignalTable {
        drive_id: "d".into(),
        times: vec![Nanos(0), Nanos(100_000_000)],
        targets: vec![span(0, ObjectClass::Pedestrian), span(1, ObjectClass::Car)],
        target_columns: [
            ("target.gap".to_owned(), Column::Number(vec![1.0, 2.0, N, N])),
            ("target.ttc".to_owned(), Column::Number(vec![N; 4])),
        ]
        .into(),
        ..SignalTable::default()
    };
    let dir = tempfile::tempdir().expect("a folder");
    whyroad_lake::signals::write_signals(dir.path(), "v", &[("h".to_owned(), &table)]).expect("written");
    let file = whyroad_lake::SignalFile::open(dir.path()).expect("readable").expect("there");
    let rules = [rule(Subject::Vehicle), rule(Subject::Vru), rule(Subject::Any)];
    let plan = Plan::of_rules(&rules);
    let missing: Vec<Vec<String>> = find_stored(&plan, &file, 0, &[0, 1, 2])
        .expect("read")
        .into_iter()
        .map(|f| f.missing.into_iter().collect())
        .collect();
    // docs/reference/rules.md: for the vehicle no row could be decided, because its signal is never known; for the
    // pedestrian it is known that its gap is not below -5 m.
    assert_eq!(missing, [vec!["target.ttc".to_owned()], vec![], vec![]]);
}
