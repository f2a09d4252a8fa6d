//! Counts over objects, pairs of objects and values of an episode, by tables worked out by hand.

use super::*;
use crate::language::check::RoleNames;

/// Seven frames; `a` is seen in frames 0 to 3, `b` in 2 to 5, no object in the last one. A gap under 10 m is
///
/// ```text
/// a  1 1 ? 0
/// b      1 ? 1 1
/// ```
fn two_cars() -> SignalTable {
    let mut t = table(&tenths(7), &[9.0; 7]);
    let span = |id: &str, first_row, frames| TargetSpan {
        id: id.into(),
        class: ObjectClass::Car,
        first_row,
        frames,
    };
    t.targets = vec![span("a", 0, FrameRange::new(0, 4)), span("b", 4, FrameRange::new(2, 6))];
    let gaps = vec![3.0, 3.0, N, 30.0, 3.0, N, 3.0, 3.0];
    t.target_columns.insert("target.gap".to_owned(), Column::Number(gaps));
    t
}

#[test]
fn a_count_is_unknown_only_where_an_unknown_object_decides() {
    let t = two_cars();
    let of = |text: &str| truths(text, &t, None);
    assert_eq!(of("exists(target.gap < 10 m)"), "111?110");
    assert_eq!(of("count(target.gap < 10 m) >= 2"), "00?0000");
    assert_eq!(of("2 <= count(target.gap < 10 m)"), "00?0000");
    assert_eq!(of("count(target.gap < 10 m) > 0"), "111?110");
    assert_eq!(of("count(target.gap < 10 m) == 1"), "11??110");
    assert_eq!(of("count(target.gap < 10 m) != 1"), "00??001");
    assert_eq!(of("count(target.gap < 10 m) <= 1"), "11?1111");
    assert_eq!(of("count(target.gap < 10 m) < 1"), "000?001");
    // A condition over no object is vacuously true; `exists` guards against it.
    assert_eq!(of("forall(target.gap < 10 m)"), "11?0111");
    assert_eq!(of("forall(target.gap < 10 m) == (not exists(not target.gap < 10 m))"), "11?1111");
}

#[test]
fn only_objects_of_the_kind_are_counted() {
    let t = two_cars();
    let of = |text: &str| truths(text, &t, None);
    assert_eq!(of("exists(target_vru.gap < 10 m)"), "0000000");
    assert_eq!(of("exists(target.gap < 10 m, vru)"), "0000000");
    assert_eq!(of("exists(target.gap < 10 m, vehicle)"), "111?110");
}

#[test]
fn each_object_has_its_own_time() {
    // `for` inside: b was near at the frame 4 and 5, and perhaps from 2 on.
    let t = two_cars();
    assert_eq!(truths("exists(target.gap < 10 m for 0.2 s)", &t, None), "11??110");
    // `for` outside: some object was near all the time.
    assert_eq!(truths("exists(target.gap < 10 m) for 0.3 s", &t, None), "111???0");
    // On a target's rows, a count still includes all objects.
    assert_eq!(truths("exists(target.gap < 10 m) and target.gap < 20 m", &t, Some(0)), "11?0");
}

#[test]
fn nothing_is_counted_where_nothing_was_recorded() {
    let mut t = two_cars();
    t.times = [0.0, 0.1, 0.2, 0.5, 0.6, 0.7, 0.8].map(at).to_vec();
    assert_eq!(truths("exists(target.gap < 10 m)", &t, None), "111??110", "the fourth row is the gap");
    t.target_columns.clear();
    assert_eq!(truths("forall(target.gap < 10 m)", &t, None), "????????", "a signal that the log lacks");
}

/// Truth over the rows of the pair (a, b), which are frames 2 and 3.
fn of_pair(text: &str) -> String {
    let t = two_cars();
    let mut checker = Checker::new(Catalog::bundled());
    checker.roles = RoleNames { first: Some("lead".to_owned()), second: Some("obstacle".to_owned()) };
    let id = checker.condition(&parse::parse(text).unwrap()).unwrap();
    let mut evaluator = Evaluator::new(&checker.program, &t);
    let roles = Roles { target: Some(&t.targets[0]), second: Some(&t.targets[1]) };
    let mut pass = evaluator.pass_of(roles);
    let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref().clone() else { panic!("{text}") };
    text_of(text, &t)
}

#[test]
fn a_pair_is_judged_while_both_are_seen() {
    assert_eq!(of_pair("lead.gap < 10 m and obstacle.gap < 10 m"), "?0");
    assert_eq!(
        of_pair("target.gap < 10 m and obstacle.gap < 10 m"),
        "?0",
        "`target` names the first role too"
    );
    assert_eq!(of_pair("lead.gap > obstacle.gap"), "??");
    // A condition on one of them is evaluated over the whole time in which that one is observed.
    assert_eq!(of_pair("previously(lead.gap < 10 m, 0.2 s) and obstacle.gap > 1 m"), "1?");
    assert_eq!(of_pair("rises(obstacle.gap < 10 m) or lead.gap > 10 m"), "?1");
    // A condition on both is known only while both are observed: the frame before is unknown.
    assert_eq!(of_pair("falls(lead.gap < 10 m or obstacle.gap > 10 m)"), "??");
    assert_eq!(of_pair("ego.speed > 5 m/s for 0.5 s"), "11");
}

#[test]
fn an_episode_is_looked_at_as_a_whole() {
    let t = two_cars();
    let of = |text: &str, keyframe: usize, matched: (usize, usize)| {
        let mut checker = Checker::new(Catalog::bundled());
        let id = checker.condition(&parse::parse(text).unwrap()).unwrap();
        let mut evaluator = Evaluator::new(&checker.program, &t);
        let pass = evaluator.pass(Some(&t.targets[0]));
        let matched = FrameRange::new(matched.0, matched.1);
        let mut pass = evaluator.at_episode(&pass, Moments { keyframe, matched });
        let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref().clone() else { panic!("{text}") };
        text_of(text, &t)
    };
    assert_eq!(of("least(target.gap) < 5 m", 0, (0, 2)), "1111");
    assert_eq!(of("least(target.gap) > 5 m", 0, (0, 2)), "0000");
    assert_eq!(of("5 m > least(target.gap)", 0, (0, 3)), "1111", "what is unknown cannot undo it");
    assert_eq!(of("least(target.gap) > 2 m", 0, (0, 3)), "????", "what is unknown may be less");
    assert_eq!(of("greatest(target.gap) < 5 m", 0, (0, 3)), "????");
    assert_eq!(of("greatest(target.gap) < 5 m", 0, (0, 4)), "0000");
    assert_eq!(of("greatest(target.gap) > target.gap at keyframe", 1, (0, 4)), "1111");
    assert_eq!(of("least(target.gap) < target.gap at keyframe", 1, (0, 2)), "0000");
    assert_eq!(of("target.gap at keyframe > 10 m", 3, (0, 4)), "1111");
    assert_eq!(
        truths("least(target.gap) < 5 m", &t, Some(0)),
        "????",
        "without an episode there is no answer"
    );
}
