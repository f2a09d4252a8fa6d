//! One primary class a moment. The pairs are those of LABELING.md 8 and its worked cases in section 1.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use whyroad_framework::Framework;
use whyroad_framework::taxonomy::Decides;
use whyroad_mining::episode::arbitrate::arbitrate;
use whyroad_mining::rule::Precedence;
use whyroad_mining::{Episode, Rank};
use whyroad_model::messages::{EgoResponse, KeyframeType};
use whyroad_model::{Bilingual, FrameRange, Nanos, ScenarioId};

fn precedence() -> Precedence {
    let framework = Framework::bundled();
    let (precedence, found) = Precedence::parse(&framework.precedence_yaml, &framework.taxonomy);
    assert!(found.is_empty(), "{found:?}");
    precedence
}

fn episode(class: &str, target: &str, keyframe: usize, score: f64) -> Episode {
    Episode {
        scenario: class.parse().unwrap(),
        target: (!target.is_empty()).then(|| target.into()),
        roles: [].into(),
        matched: FrameRange::new(keyframe, keyframe + 20),
        kind: KeyframeType::Reactive,
        keyframe,
        second_keyframe: None,
        range: FrameRange::new(keyframe, keyframe + 20),
        context: FrameRange::new(keyframe, keyframe + 20),
        keyframe_rule: Bilingual::default(),
        response: EgoResponse::Observed,
        score,
        share: None,
        conditions: vec![],
        signals: vec![],
        rank: Rank::Primary,
    }
}

fn primaries(episodes: Vec<Episode>) -> Vec<(String, usize)> {
    let times: Vec<Nanos> = (0..500).map(|i| Nanos(i * 100_000_000)).collect();
    let arbitrated = arbitrate(episodes, &times, &precedence());
    for e in &arbitrated {
        if let Rank::SecondaryTo(p) = e.rank {
            assert_eq!(arbitrated[p].rank, Rank::Primary, "secondary to what is not primary");
        }
    }
    let primary = arbitrated.iter().filter(|e| e.rank == Rank::Primary);
    primary.map(|e| (e.scenario.to_string(), e.keyframe)).collect()
}

#[test]
fn pairs_that_overlap_are_decided_as_the_taxonomy_says() {
    let pairs = [
        // (primary, secondary)
        ("proactive.roundabout.entry", "reactive_rule.special_facility.roundabout"),
        ("reactive_agent.intersection_interaction.unprotected_left", "proactive.turn.left_unprotected"),
        ("reactive_agent.following.lead_sudden_brake", "reactive_agent.vehicle_abnormal.sudden_brake"),
        ("reactive_rule.traffic_light.resume_follow", "reactive_agent.following.follow_start"),
        ("reactive_rule.special_facility.gate", "proactive.pull_over.gate_stop"),
        ("reactive_rule.speed_limit.bump_limit", "reactive_road.surface_adaptation.speed_bump"),
        // Three kinds of construction: met by somebody in the narrowed road, changing the road, hiding what is behind
        // it.
        ("reactive_agent.passing.construction", "reactive_rule.road_change.construction"),
        ("reactive_rule.road_change.construction", "reactive_road.blind_spot_slowdown.construction"),
        ("reactive_agent.passing.construction", "reactive_road.blind_spot_slowdown.construction"),
        // The proximate cause: the stopped lead before the red light (LABELING.md 6).
        ("reactive_agent.following.follow_stop", "reactive_rule.traffic_light.red_stop"),
        // A cut-in that makes the ego abort a lane change is the cut-in (LABELING.md 1).
        ("reactive_agent.cutin.slow", "proactive.lane_change.abort"),
        ("reactive_agent.cutin.large_vehicle", "reactive_agent.cutin.urgent"),
        ("reactive_agent.cutin.urgent", "safety.near_miss.general"),
        // A junction conflict that can be named; the ego's own light; rain that falls; the lane that the route needs.
        ("reactive_agent.intersection_interaction.cross_conflict", "safety.near_miss.general"),
        ("reactive_rule.traffic_light.red_stop", "reactive_agent.vru_crossing.crosswalk"),
        ("reactive_road.weather_adaptation.rain", "reactive_road.surface_adaptation.wet"),
        ("proactive.lane_change.navigation", "reactive_rule.special_lane.turn_only_left"),
        ("safety.aeb.vru", "reactive_agent.vru_crossing.crosswalk"),
    ];
    for (first, second) in pairs {
        for order in [[first, second], [second, first]] {
            let both = order.map(|c| episode(c, "x", 100, 0.7)).to_vec();
            assert_eq!(primaries(both), [(first.to_owned(), 100)], "{first} before {second}");
        }
    }
}

/// `tests/decides.txt` reads each `decides` of the taxonomy: does its text say which class is primary where both hold?
#[test]
fn the_order_agrees_with_every_text_that_decides_between_two_classes() {
    let precedence = precedence();
    let taxonomy = &Framework::bundled().taxonomy;
    let mut stated = BTreeSet::new();
    for l1 in &taxonomy.l1 {
        for l2 in &l1.l2 {
            let class = ScenarioId { l1: l1.id.clone(), l2: Some(l2.id.clone()), l3: None };
            stated.extend(pairs(&class, &l2.decides));
        }
    }
    for (l1, l2, l3) in taxonomy.leaves() {
        stated.extend(pairs(&ScenarioId::leaf(&l1.id, &l2.id, &l3.id), &l3.decides));
    }
    let mut read = BTreeSet::new();
    let mut preferences = 0;
    for line in include_str!("decides.txt").lines().filter(|l| !l.is_empty() && !l.starts_with('#')) {
        let [first, sign, second] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let (first, second): (ScenarioId, ScenarioId) = (first.parse().unwrap(), second.parse().unwrap());
        assert!(read.insert(ordered(&first, &second)), "{line} is there twice");
        assert!(matches!(sign, ">" | "|"), "{line}");
        if sign == "|" {
            continue;
        }
        preferences += 1;
        for a in leaves_of(&first) {
            for b in leaves_of(&second).into_iter().filter(|b| *b != a) {
                assert!(precedence.rank(&a) < precedence.rank(&b), "{line}: {a} does not go before {b}");
            }
        }
    }
    // A new pair has to be read, and one that is gone has to be struck out.
    assert_eq!(read, stated);
    assert!(preferences > 100, "{preferences}");
}

fn ordered(a: &ScenarioId, b: &ScenarioId) -> (ScenarioId, ScenarioId) {
    if a < b { (a.clone(), b.clone()) } else { (b.clone(), a.clone()) }
}

fn pairs(class: &ScenarioId, decides: &[Decides]) -> Vec<(ScenarioId, ScenarioId)> {
    decides.iter().map(|d| ordered(class, &d.against)).collect()
}

fn leaves_of(class: &ScenarioId) -> Vec<ScenarioId> {
    let leaves = Framework::bundled().taxonomy.leaves();
    leaves
        .map(|(l1, l2, l3)| ScenarioId::leaf(&l1.id, &l2.id, &l3.id))
        .filter(|id| id.is_within(class))
        .collect()
}

#[test]
fn every_class_with_a_rule_has_a_stated_place() {
    let precedence = precedence();
    for (l1, l2, l3) in Framework::bundled().taxonomy.leaves() {
        let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        assert_ne!(precedence.rank(&id), usize::MAX, "{id} is not in schema/precedence.yaml");
    }
}

#[test]
fn moments_apart_do_not_compete() {
    // The neighborhood is 1 s: ten frames.
    let at = |k| episode("proactive.turn.straight", "", k, 0.7);
    let vru = |k| episode("reactive_agent.vru_crossing.crosswalk", "p", k, 0.6);
    assert_eq!(primaries(vec![vru(100), at(109)]).len(), 1);
    assert_eq!(primaries(vec![vru(100), at(110)]).len(), 2);
    // Recorded clocks jitter: 0.9998 s is ten frames as well.
    let times: Vec<Nanos> = (0..500).map(|i| Nanos(i * 99_980_000)).collect();
    let arbitrated = arbitrate(vec![vru(100), at(110)], &times, &precedence());
    assert!(arbitrated.iter().all(|e| e.rank == Rank::Primary));
}

#[test]
fn the_order_of_candidates_changes_nothing() {
    let all = vec![
        episode("reactive_agent.vru_crossing.crosswalk", "a", 100, 0.7),
        episode("reactive_agent.vru_crossing.crosswalk", "b", 104, 0.9),
        episode("reactive_agent.following.follow_stop", "c", 95, 0.9),
        episode("proactive.turn.left_normal", "", 112, 0.98),
        episode("safety.near_miss.general", "a", 118, 0.6),
    ];
    let times: Vec<Nanos> = (0..500).map(|i| Nanos(i * 100_000_000)).collect();
    let expected = arbitrate(all.clone(), &times, &precedence());
    for shift in 1..all.len() {
        let mut turned = all.clone();
        turned.rotate_left(shift);
        assert_eq!(arbitrate(turned, &times, &precedence()), expected);
    }
}

/// One person crosses once: a second match with the same time range is the same event. Another range is another one,
/// and so is another person.
#[test]
fn an_interrupted_match_is_one_episode() {
    let crossing = |target: &str, keyframe, range: (usize, usize), response| Episode {
        range: FrameRange::new(range.0, range.1),
        response,
        ..episode("reactive_agent.vru_crossing", target, keyframe, 0.7)
    };
    let all = vec![
        crossing("p", 50, (50, 122), EgoResponse::Absent),
        crossing("p", 106, (50, 122), EgoResponse::Observed),
        crossing("q", 106, (50, 122), EgoResponse::Absent),
        crossing("p", 300, (300, 340), EgoResponse::Absent),
    ];
    let times: Vec<Nanos> = (0..500).map(|i| Nanos(i * 100_000_000)).collect();
    let found = arbitrate(all, &times, &precedence());
    let told: Vec<_> = found.iter().map(|e| (e.target.as_ref().unwrap().as_str(), e.keyframe)).collect();
    assert_eq!(told, [("p", 50), ("q", 106), ("p", 300)]);
    // The ego answered the second part of it.
    assert_eq!((found[0].response, found[0].matched), (EgoResponse::Observed, FrameRange::new(50, 126)));
}

#[test]
fn an_l2_stays_silent_where_a_leaf_knows_more() {
    let l2 = |target: &str, k| episode("reactive_agent.cutin", target, k, 0.9);
    let leaf = episode("reactive_agent.cutin.slow", "a", 100, 0.6);
    let found = primaries(vec![l2("a", 100), l2("b", 300), leaf]);
    let expected = [("reactive_agent.cutin.slow".to_owned(), 100), ("reactive_agent.cutin".to_owned(), 300)];
    assert_eq!(found, expected);
    // An L2 about the ego alone, a leaf about whom it overtakes.
    let alone = episode("proactive.lane_change", "", 100, 0.9);
    let passed = episode("proactive.lane_change.overtake", "a", 100, 0.6);
    let times: Vec<Nanos> = (0..500).map(|i| Nanos(i * 100_000_000)).collect();
    assert_eq!(arbitrate(vec![alone, passed.clone()], &times, &precedence()), [passed]);
}
