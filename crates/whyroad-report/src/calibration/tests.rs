//! Expected values by hand, from the definitions that the module names.

use super::*;
use proptest::prelude::*;

fn judged(class: &str, drive: usize, margin_score: f64, right: bool) -> JudgedEpisode {
    let (scenario_id, drive_id) = (class.parse().unwrap(), format!("d{drive:03}").as_str().into());
    JudgedEpisode { scenario_id, drive_id, margin_score, right }
}

/// `right` of `all` episodes of a class at a score, one per drive.
fn some(class: &str, margin_score: f64, right: usize, all: usize) -> Vec<JudgedEpisode> {
    (0..all).map(|i| judged(class, i, margin_score, i < right)).collect()
}

#[test]
fn shares_are_drawn_towards_their_class_and_never_fall() {
    let episodes = [some("a.b.c", 0.6, 5, 10), some("a.b.c", 0.9, 9, 10)].concat();
    let table = fit(&episodes, None, vec![]);
    let c = &table.classes[0];
    // All: (14 + 1) / (20 + 2). Class: (14 + 4 * 0.6818) / 24 = 0.6970. Steps: (5 + 4 * 0.6970) / 14 = 0.5563 and
    // (9 + 4 * 0.6970) / 14 = 0.8420.
    let steps: Vec<(f64, f64, usize)> = c.steps.iter().map(|s| (s.from, s.share, s.judged)).collect();
    assert_eq!(steps, [(0.5, 0.5563, 10), (0.9, 0.842, 10)]);
    // Reversed, they are one step, with the share of the class.
    let falling = [some("a.b.c", 0.6, 9, 10), some("a.b.c", 0.9, 5, 10)].concat();
    let table = fit(&falling, None, vec![]);
    assert_eq!(table.classes[0].steps.len(), 1);
    assert_eq!(table.classes[0].steps[0].share, 0.697);
}

#[test]
fn a_rule_with_one_score_has_one_share() {
    // A rule that compares no numbers: every score is 0.5, the share is the fraction that is right.
    let table = fit(&some("a.b.c", 0.5, 36, 60), None, vec![]);
    let share = table.share(&"a.b.c".parse().unwrap(), 0.5).unwrap();
    assert_eq!(table.classes[0].steps.len(), 1);
    assert!((share - 0.6).abs() < 0.01, "{share}");
}

#[test]
fn few_examples_are_counted_and_not_used() {
    let table = fit(&some("a.b.c", 0.7, 4, 4), None, vec![]);
    assert_eq!((table.classes[0].judged, table.share(&"a.b.c".parse().unwrap(), 0.7)), (4, None));
}

#[test]
fn an_earlier_table_counts_as_ten_episodes() {
    let before = fit(&some("a.b.c", 0.7, 1000, 1000), None, vec![]);
    let was = before.classes[0].steps[0].share;
    assert!(was > 0.99);
    // People find 10 of 30 right: (10 + 10 * 0.999..) / 40.
    let after = fit(&some("a.b.c", 0.7, 10, 30), Some(&before), vec![]);
    let share = after.share(&"a.b.c".parse().unwrap(), 0.7).unwrap();
    assert!((share - (10.0 + 10.0 * was) / 40.0).abs() < 1e-4, "{share}");
    // A class with few or no new episodes is not changed.
    let little = fit(&some("a.b.c", 0.7, 0, 4), Some(&before), vec![]);
    assert_eq!(little.classes, before.classes);
    assert_eq!(fit(&some("a.b.d", 0.7, 5, 5), Some(&before), vec![]).classes.len(), 2);
}

#[test]
fn the_error_is_that_of_its_definition() {
    // Tenth 0.9: predicted 1.8 of 2, right 1: off by 0.8. Tenth 0.2: predicted 0.4 of 2, right 1: off by 0.6.
    let e = measure(&[(0.9, true), (0.9, false), (0.2, true), (0.2, false)]).unwrap();
    assert!((e.expected - 1.4 / 4.0).abs() < 1e-12, "{e:?}");
    // (0.01 + 0.81 + 0.64 + 0.04) / 4.
    assert!((e.brier - 0.375).abs() < 1e-12);
    assert_eq!(measure(&[]), None);
}

#[test]
fn shares_are_better_than_margins_on_held_out_drives() {
    // A class that is right three times of five at every score, in each fifth of the drives.
    let episodes: Vec<JudgedEpisode> = (0..200).map(|i| judged("a.b.c", i, 0.98, i / 5 % 5 < 3)).collect();
    let (shares, margins) = held_out(&episodes, None).unwrap();
    assert_eq!(shares.episodes, 200);
    assert!(shares.expected < 0.05 && margins.expected > 0.35, "{shares:?} {margins:?}");
    assert_eq!(held_out(&[], None), None);
}

#[test]
fn the_interval_is_wilsons() {
    // 8 of 10: 0.490 to 0.943 (Newcombe 1998, table of examples for p = 0.8, n = 10).
    let [low, high] = wilson(8, 10);
    assert!((low - 0.490).abs() < 1e-3 && (high - 0.943).abs() < 1e-3, "{low} {high}");
    assert_eq!(wilson(0, 5)[0], 0.0);
}

proptest! {
    #[test]
    fn every_table_is_valid_and_does_not_depend_on_the_order(
        episodes in prop::collection::vec((0..3usize, 0..20usize, 5000..9820u32, any::<bool>()), 0..200),
    ) {
        let class = |i: usize| ["a.b.c", "a.b.d", "a.c"][i];
        let mut all: Vec<JudgedEpisode> = episodes
            .into_iter()
            .map(|(c, d, score, right)| judged(class(c), d, f64::from(score) / 1e4, right))
            .collect();
        let table = fit(&all, None, vec![]);
        let (read, found) = Calibration::parse("f", &table.to_yaml().unwrap());
        prop_assert_eq!((&read, found.len()), (&table, 0));
        all.reverse();
        prop_assert_eq!(fit(&all, None, vec![]), table);
    }
}
