//! Tables made by hand: truth, durations and members are known from the columns.

use super::*;
use crate::rule::text::compile_text;
use whyroad_model::Column;
use whyroad_signals::Catalog;

/// 3 s at 10 Hz: the ego drives at 3 m/s, and at 7 m/s in frames 10 to 14 and 20 to 27. No target, no lights.
fn table() -> SignalTable {
    let speed = |i: usize| if (10..15).contains(&i) || (20..28).contains(&i) { 7.0 } else { 3.0 };
    let mut table =
        SignalTable { times: (0..30).map(|i| Nanos(i * 100_000_000)).collect(), ..SignalTable::default() };
    table.frame_columns.insert("ego.speed".into(), Column::Number((0..30).map(speed).collect()));
    table.frame_columns.insert("ego.accel".into(), Column::Number(vec![0.5; 30]));
    table
}

fn rule(text: &str) -> Rule {
    let rule = compile_text(text, None, &"a.b.c".parse().unwrap(), Catalog::bundled(), "t").unwrap();
    // Each stretch is a match of its own.
    Rule { merge_gap: Nanos(0), ..rule }
}

fn whole() -> FrameRange {
    FrameRange::new(0, 30)
}

#[test]
fn a_match_that_is_too_short_says_how_long_it_lasted_and_must_last() {
    let rule = Rule { min_duration: Nanos(1_000_000_000), ..rule("ego.speed > 5 m/s") };
    let found = explain(&rule, &table(), FrameRange::new(0, 16), None);
    assert_eq!(found.outcome, Outcome::WrongDuration);
    // Frames 10 to 14, each of 0.1 s.
    let (held, least) = (Nanos(500_000_000), Nanos(1_000_000_000));
    assert_eq!(found.duration, Some(Duration { held, least, most: None }));
    let rule = Rule { max_duration: Some(Nanos(600_000_000)), min_duration: Nanos(0), ..rule };
    let found = explain(&rule, &table(), FrameRange::new(16, 30), None);
    assert_eq!(found.duration.unwrap().held, Nanos(800_000_000));
    assert_eq!(explain(&rule, &table(), whole(), None).duration, None, "the first of the two matches");
}

#[test]
fn the_match_with_a_keyframe_is_explained() {
    let rule = rule("ego.speed > 5 m/s");
    // The keyframe is the first frame of a match.
    for keyframe in [10, 20] {
        let found = explain_match(&rule, &table(), whole(), keyframe);
        assert_eq!((found.outcome, found.moment), (Outcome::Matched, Some(keyframe)));
    }
    assert_ne!(explain_match(&rule, &table(), whole(), 12).outcome, Outcome::Matched);
}

/// Joins and members, as `any(a, all(b, c))`.
fn outline(of: &ConditionCourse) -> String {
    let name = match of.join {
        Join::Single => return of.words.en.clone(),
        Join::All => "all",
        Join::Any => "any",
        Join::Not => "not",
        Join::OverTime => "over time",
    };
    format!("{name}({})", of.members.iter().map(outline).collect::<Vec<_>>().join(", "))
}

#[test]
fn members_are_below_their_condition_as_they_are_written() {
    let outline = |text: &str| {
        let found = explain(&rule(text), &table(), whole(), None);
        found.parts.iter().map(|p| outline(&p.condition)).collect::<Vec<_>>()
    };
    assert_eq!(
        outline("ego.accel > 0 m/s2 and (ego.standstill or (ego.speed > 5 m/s and not ego.in_junction))"),
        [
            "Acceleration of the ego > 0 m/s²",
            "any(The ego is stationary, all(Speed of the ego > 5 m/s, Not: the ego is in a junction))",
        ]
    );
    assert_eq!(
        outline("not (ego.brake is known and ego.brake)"),
        ["not(all(The ego brakes is known, The ego brakes))"]
    );
    assert_eq!(
        outline("not (ego.speed > 5 m/s or previously(ego.standstill, 2 s)) for 1 s"),
        ["over time(not(any(Speed of the ego > 5 m/s, over time(The ego is stationary))))"]
    );
    assert_eq!(
        outline("2 m/s < ego.speed < 5 m/s"),
        ["all(Speed of the ego > 2 m/s, Speed of the ego < 5 m/s)"]
    );
}

#[test]
fn a_denied_condition_holds_above_an_unknown_one_only_with_its_test_of_knowledge() {
    let found = explain(&rule("not (ego.brake is known and ego.brake)"), &table(), whole(), None);
    let part = &found.parts[0].condition;
    let all = &part.members[0];
    assert_eq!(part.words.en, "Not (or unknown): the ego brakes");
    let truths: Vec<Tri> = all.members.iter().map(|m| m.course.truth).collect();
    assert_eq!((part.course.truth, all.course.truth), (Tri::True, Tri::False));
    assert_eq!(truths, [Tri::False, Tri::Unknown]);
}

#[test]
fn the_variant_that_mining_reports_instead_of_its_l2_is_named() {
    // Matches in frames 10 to 14 and 20 to 27; the leaf only where the ego is fast for 0.6 s.
    let of = |text: &str, class: &str| Rule { scenario: class.parse().unwrap(), ..rule(text) };
    let l2 = of("ego.speed > 5 m/s", "a.b");
    let leaf = Rule { min_duration: Nanos(600_000_000), ..of("ego.speed > 5 m/s", "a.b.c") };
    let other = of("ego.speed > 5 m/s", "a.x.c");
    let leaves = [l2.clone(), leaf, other];
    assert!(variants(&l2, &leaves, &table(), 10).is_empty());
    let found = variants(&l2, &leaves, &table(), 20);
    let found: Vec<(String, usize)> = found.iter().map(|e| (e.scenario.to_string(), e.keyframe)).collect();
    assert_eq!(found, [("a.b.c".to_owned(), 20)]);
}
