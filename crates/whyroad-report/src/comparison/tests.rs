//! Comparisons of episodes made by hand; expected counts follow from the definitions in the module's documentation.

use super::*;
use crate::fixture;
use whyroad_model::{Lang, Nanos};

/// An episode of a class with its keyframe at `s` seconds.
fn episode(class: &str, s: f64) -> EpisodeRecord {
    let drive = fixture::drive("d");
    let mut e = fixture::episode(&drive);
    let at = |t: f64| Nanos((t * 1e9) as i64);
    e.scenario_id = class.parse().unwrap();
    e.episode_id = format!("{class}_{s}");
    e.keyframe.timestamp = at(s);
    e.time_range.start_timestamp = at(s - 1.0);
    e.time_range.end_timestamp = at(s + 1.0);
    e
}

const URGENT: &str = "reactive_agent.cutin.urgent";
const SLOW: &str = "reactive_agent.cutin.slow";

/// A side that asked for all classes.
fn all<'a>(drives: &'a [DriveId], episodes: &'a [EpisodeRecord]) -> Searched<'a> {
    Searched { drives, classes: None, episodes, labels: None }
}

fn compared(before: &[EpisodeRecord], after: &[EpisodeRecord]) -> Comparison {
    let drives: Vec<DriveId> = vec!["d".into()];
    compare(all(&drives, before), all(&drives, after), None)
}

#[test]
fn a_folder_against_itself_has_no_change() {
    let all = [episode(URGENT, 10.0), episode(SLOW, 30.0)];
    let c = compared(&all, &all);
    assert_eq!(c.unchanged, 2);
    assert!(Change::ALL.iter().all(|ch| c.total(*ch) == 0));
}

#[test]
fn each_kind_of_change_is_counted_once() {
    let mut secondary = episode(SLOW, 70.0);
    secondary.is_primary = false;
    let before = [episode(URGENT, 10.0), episode(URGENT, 30.0), episode(SLOW, 50.0), episode(SLOW, 70.0)];
    let after = [episode(SLOW, 10.1), episode(URGENT, 30.4), secondary, episode(URGENT, 90.0)];
    let c = compared(&before, &after);
    let counts: Vec<usize> = c.changes().map(|ch| c.total(ch)).collect();
    // Gained at 90 s, lost at 50 s, reclassified at 10 s, moved at 30 s, another primary at 70 s.
    assert_eq!(counts, [1, 1, 1, 1, 1]);
    let moved = &c.classes[&URGENT.parse().unwrap()].examples;
    let shift = moved.iter().find(|e| e.change == Change::Moved).and_then(|e| e.keyframe_shift_s).unwrap();
    assert!((shift - 0.4).abs() < 1e-9);
}

/// Numbers before and after add up: the class to which a moment went has a row, too.
#[test]
fn the_class_to_which_a_moment_went_is_listed() {
    let c = compared(&[episode(URGENT, 10.0)], &[episode("reactive_agent.cutin", 10.0)]);
    let text = render(&c, Lang::En, false);
    let row = |id: &str| {
        let line = text.lines().find(|l| l.split_whitespace().next() == Some(id)).unwrap_or_default();
        line.split_whitespace().skip(1).take(2).map(|n| n.parse::<usize>().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((row(URGENT), row("reactive_agent.cutin")), (vec![1, 0], vec![0, 1]), "{text}");
}

/// The same moment and class with another decision (what `dataset diff` calls relabelled) is not unchanged.
#[test]
fn a_moment_with_another_label_is_not_unchanged() {
    let episodes = [episode(URGENT, 10.0), episode(SLOW, 30.0)];
    let drives: Vec<DriveId> = vec!["d".into()];
    let labels = |second: &str| -> BTreeMap<String, String> {
        let id = |i: usize| episodes[i].episode_id.clone();
        [(id(0), "same".to_owned()), (id(1), second.to_owned())].into()
    };
    let (a, b) = (labels("slow_down"), labels("stop"));
    let side = |labels| Searched { labels: Some(labels), ..all(&drives, &episodes) };
    let c = compare(side(&a), side(&b), None);
    assert_eq!((c.unchanged, c.total(Change::Relabelled)), (1, 1));
    assert!(render(&c, Lang::En, false).contains("relabelled 1"));
    let c = compare(side(&a), side(&a), None);
    assert_eq!((c.unchanged, c.total(Change::Relabelled)), (2, 0));
    assert!(!render(&compared(&episodes, &episodes), Lang::En, false).contains("relabelled"));
}

#[test]
fn exchanging_the_sides_exchanges_gained_and_lost() {
    let before = [episode(URGENT, 10.0), episode(SLOW, 50.0)];
    let after = [episode(URGENT, 10.0), episode(URGENT, 90.0), episode(SLOW, 120.0)];
    let (one, other) = (compared(&before, &after), compared(&after, &before));
    assert_eq!(one.total(Change::Gained), other.total(Change::Lost));
    assert_eq!(one.total(Change::Lost), other.total(Change::Gained));
    assert_eq!(one.unchanged, other.unchanged);
}

#[test]
fn drives_that_one_side_did_not_search_are_named_and_not_lost() {
    let before = [episode(URGENT, 10.0)];
    let c = compare(all(&["d".into()], &before), all(&["e".into()], &[]), None);
    assert_eq!((c.drives, c.total(Change::Lost)), (0, 0));
    assert_eq!((c.only_before, c.only_after), (vec!["d".into()], vec!["e".into()]));
}

#[test]
fn classes_that_one_side_did_not_ask_for_are_named_and_not_lost() {
    const AHEAD: &str = "reactive_agent.following.close";
    let before = [episode(URGENT, 10.0), episode(SLOW, 30.0), episode(AHEAD, 50.0)];
    let after = [episode(URGENT, 10.0)];
    let drives: Vec<DriveId> = vec!["d".into()];
    let class = |id: &str| -> ScenarioId { id.parse().unwrap() };
    let asked = [class("reactive_agent.cutin")];
    let c = compare(all(&drives, &before), Searched { classes: Some(&asked), ..all(&drives, &after) }, None);
    // SLOW is within the class that the second asked for, AHEAD is not.
    assert_eq!((c.unchanged, c.total(Change::Lost)), (1, 1));
    let of = c.classes_of_both.clone().unwrap();
    assert_eq!((of.left_out_before, of.left_out_after), (1, 0));
    assert_eq!(of.compared, asked);
    for lang in [Lang::Zh, Lang::En] {
        assert!(render(&c, lang, false).contains("reactive_agent.cutin；") || lang == Lang::En);
        assert!(render(&c, lang, false).contains("reactive_agent.cutin; ") || lang == Lang::Zh);
    }
    // The narrower of two questions; the same question on both sides needs no word.
    let leaf = [class(SLOW)];
    let side = |classes| Searched { classes: Some(classes), ..all(&drives, &before) };
    let c = compare(side(&asked), side(&leaf), None);
    assert_eq!(c.classes_of_both.map(|of| (of.compared, of.left_out_before)), Some((leaf.to_vec(), 2)));
    assert_eq!(compare(side(&asked), side(&asked), None).classes_of_both, None);
    let c = compare(side(&leaf), Searched { classes: Some(&[class(AHEAD)]), ..all(&drives, &before) }, None);
    assert_eq!((c.unchanged, c.classes_of_both.map(|of| of.compared.len())), (0, Some(0)));
}

#[test]
fn columns_are_below_their_titles_where_an_id_is_long() {
    let long = "reactive_agent.intersection_interaction.cross_conflict";
    assert!(long.len() > 50);
    let text = render(&compared(&[episode(long, 10.0)], &[]), Lang::En, false);
    let lines: Vec<&str> = text.lines().skip_while(|line| !line.is_empty()).skip(1).collect();
    assert!(lines[0].trim_start().starts_with("before"), "{text}");
    assert_eq!(
        lines[0].find("before").map(|at| at + "before".len()),
        lines[1].find(" 1 ").map(|at| at + 2),
        "{text}"
    );
}

#[test]
fn changes_are_judged_by_accepted_labels() {
    let before = [episode(URGENT, 10.0), episode(URGENT, 30.0)];
    let after = [episode(SLOW, 50.0), episode(SLOW, 70.0)];
    let accepted = |class: &str, s: f64| AcceptedMoment {
        drive: "d".into(),
        scenario: class.parse().unwrap(),
        keyframe: Nanos((s * 1e9) as i64),
    };
    let labels = [accepted(URGENT, 10.4), accepted(SLOW, 50.0), accepted(SLOW, 70.9), accepted(URGENT, 50.0)];
    let drives: Vec<DriveId> = vec!["d".into()];
    let c = compare(all(&drives, &before), all(&drives, &after), Some(&labels));
    assert_eq!(c.total_accepted(Change::Gained), Some(2));
    assert_eq!(c.total_accepted(Change::Lost), Some(1));
    let text = render(&c, Lang::En, true);
    assert!(text.contains("gains 2, loses 1 that people accepted"), "{text}");
    assert!(text.lines().all(|l| l.chars().count() <= 120), "{text}");
}
