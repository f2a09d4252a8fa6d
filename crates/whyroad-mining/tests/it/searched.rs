//! Whether a drive was searched for a class depends on the signals that it has, not on what happens in it
//! (docs/reference/rules.md): both evaluators.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;
use whyroad_mining::episode::{Found, find};
use whyroad_mining::fast::{Plan, Signals, find_all};
use whyroad_mining::language::program::Subject;
use whyroad_mining::rule::text::compile_text;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, FrameRange, Nanos, ObjectClass, SignalTable, Tri};
use whyroad_signals::Catalog;

/// 10 s at 10 Hz without a bus that states AEB; the ego brakes in `brakes`.
fn drive(brakes: std::ops::Range<usize>) -> SignalTable {
    let brake = Column::Flag((0..100).map(|f| Tri::from(brakes.contains(&f))).collect());
    SignalTable {
        times: (0..100).map(|i| Nanos(i * 100_000_000)).collect(),
        frame_columns: BTreeMap::from([
            ("ego.brake".to_owned(), brake),
            ("ego.standstill".to_owned(), Column::Flag(vec![Tri::False; 100])),
        ]),
        ..SignalTable::default()
    }
}

/// The number of episodes and the missing signals, which are the same for both evaluators.
fn searched(rule: &str, table: &SignalTable) -> (usize, Vec<String>) {
    let class = "safety.aeb.vehicle".parse().unwrap();
    let rule = compile_text(rule, None, &class, Catalog::bundled(), "test").unwrap();
    let told = |found: Found| (found.episodes.len(), found.missing.into_iter().collect::<Vec<_>>());
    let fast = find_all(&Plan::of_rules([&rule]), &Signals::of_table(table)).pop().unwrap();
    let (fast, reference) = (told(fast), told(find(&rule, table)));
    assert_eq!(fast, reference);
    fast
}

#[test]
fn a_drive_in_which_nobody_brakes_was_not_searched_either() {
    let lacks = || vec!["ego.aeb".to_owned()];
    assert_eq!(searched("ego.brake and ego.aeb", &drive(0..0)), (0, lacks()));
    assert_eq!(searched("ego.brake and ego.aeb", &drive(20..40)), (0, lacks()));
    assert_eq!(searched("ego.brake", &drive(0..0)), (0, vec![]));
}

/// Which targets are large is not known of vehicles of unknown kind: none of them was searched for.
#[test]
fn a_rule_about_large_vehicles_needs_the_kinds_of_vehicles() {
    let large = |table: &SignalTable| {
        let class = "reactive_agent.cutin.large_vehicle".parse().unwrap();
        let subject = Some(Subject::LargeVehicle);
        let rule = compile_text("ego.brake", subject, &class, Catalog::bundled(), "test").unwrap();
        find(&rule, table).missing.into_iter().collect::<Vec<_>>()
    };
    assert_eq!(large(&drive(20..40)), ["target.large_vehicle"]);
}

#[test]
fn what_an_alternative_finds_does_not_make_the_drive_searched() {
    assert_eq!(searched("ego.brake or ego.aeb", &drive(20..40)), (1, vec!["ego.aeb".to_owned()]));
    // What it excludes only in standstill can be looked for without it.
    assert_eq!(searched("ego.brake and not (ego.standstill and ego.aeb)", &drive(20..40)), (1, vec![]));
    assert_eq!(searched("ego.brake and not (ego.standstill and ego.aeb)", &drive(0..0)), (0, vec![]));
    // The rule itself says what holds without it.
    let asks = "ego.brake and not (ego.aeb and ego.aeb is known)";
    assert_eq!(searched(asks, &drive(0..0)), (0, vec![]));
}

/// A test `is known` speaks for the condition that it is part of, not for others of the rule that read the signal.
#[test]
fn a_test_speaks_for_its_own_condition_only() {
    let lacks = || vec!["ego.aeb".to_owned()];
    let elsewhere = "ego.aeb and not (ego.standstill and ego.aeb is known and ego.aeb)";
    assert_eq!(searched(elsewhere, &drive(20..40)), (0, lacks()));
    // An alternative with a test is left out; so is what it is joined to.
    let alternative = "ego.brake or (ego.aeb is known and ego.aeb and ego.standstill)";
    assert_eq!(searched(alternative, &drive(20..40)), (1, vec![]));
    assert_eq!(searched("ego.brake and (ego.aeb is unknown or ego.aeb)", &drive(20..40)), (1, vec![]));
    // Nothing can match where the test itself is required.
    assert_eq!(searched("ego.brake and ego.aeb is known", &drive(20..40)), (0, lacks()));
    // The alternative that is left needs the signal all the same.
    let both = "(ego.aeb is known and ego.aeb) or (ego.brake and ego.aeb)";
    assert_eq!(searched(both, &drive(20..40)), (0, lacks()));
}

/// Two kinds of objects for 10 s, of which only the car has a size: what TTC says of the car, it does not say of the
/// dog.
#[test]
fn a_class_about_one_kind_needs_the_signals_of_that_kind() {
    let mut table = drive(0..0);
    let span = |id: &str, class, first_row| TargetSpan {
        id: id.into(),
        class,
        first_row,
        frames: FrameRange::new(0, 100),
    };
    table.targets = vec![span("car", ObjectClass::Car, 0), span("dog", ObjectClass::Animal, 100)];
    let of = |car: f64, dog: f64| Column::Number([vec![car; 100], vec![dog; 100]].concat());
    table.target_columns = BTreeMap::from([
        ("target.ttc".to_owned(), of(20.0, f64::NAN)),
        ("target.speed".to_owned(), of(5.0, 2.0)),
    ]);
    table.without_boxes = [ObjectClass::Animal].into();
    let missing = |subject, rule: &str, table: &SignalTable| {
        let class = "safety.near_miss.general".parse().unwrap();
        let rule = compile_text(rule, Some(subject), &class, Catalog::bundled(), "test").unwrap();
        let fast = find_all(&Plan::of_rules([&rule]), &Signals::of_table(table)).pop().unwrap();
        assert_eq!(fast, find(&rule, table));
        fast.missing.into_iter().collect::<Vec<_>>()
    };
    let (dog, rule) = (Subject::Class(ObjectClass::Animal), "target.ttc < 2 s and target.speed > 3 m/s");
    assert!(missing(Subject::Vehicle, rule, &table).is_empty());
    // Its speed is known, and low: the condition is known to be false, and it could never be true.
    assert_eq!(missing(dog, rule, &table), ["target.ttc"]);
    assert!(missing(dog, "target.speed > 3 m/s", &table).is_empty());
    // Nobody is there: none was missed.
    assert!(missing(Subject::Vru, rule, &table).is_empty());
}
