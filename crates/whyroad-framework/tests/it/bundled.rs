//! The built-in framework: whole, free of findings, and the classes that the specification lists.

use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_model::decision::{Lateral, Longitudinal};
use whyroad_model::{Lang, ScenarioId, diagnostic};

/// `l1.l2: leaf, leaf` per line: the tree at the end of TAXONOMY.md, typed off the specification; and after `=` the
/// numbers of L2 and L3, of all and of each L1, as LABELING.md 8 counts them.
const TREE: &str = include_str!("../data/taxonomy_tree.txt");

fn expected_ids() -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for line in TREE.lines().filter(|l| !l.starts_with(['#', '=']) && !l.is_empty()) {
        let (l2, leaves) = line.split_once(": ").unwrap();
        let l1 = l2.split_once('.').unwrap().0;
        if !out.iter().any(|id| id == l1) {
            out.push(l1.to_owned());
        }
        out.push(l2.to_owned());
        out.extend(leaves.split(", ").map(|leaf| format!("{l2}.{leaf}")));
    }
    out
}

#[test]
fn it_has_no_findings() {
    let (framework, found) = Framework::from_files(&Framework::bundled_files());
    let text: String = found.iter().map(|d| diagnostic::render_text(d, Lang::En)).collect();
    assert!(found.is_empty(), "{text}");
    assert!(framework.is_some());
}

#[test]
fn its_counts_are_those_that_the_specification_lists() {
    let t = &Framework::bundled().taxonomy;
    let count = |text: &str| -> (usize, usize) {
        let (l2, l3) = text.split_once('/').unwrap();
        (l2.parse().unwrap(), l3.parse().unwrap())
    };
    let mut stated = TREE.lines().filter_map(|l| l.strip_prefix("= "));
    let (l2, l3) = count(stated.next().unwrap());
    assert_eq!(t.counts(), (t.l1.len(), l2, l3));
    let per_l1: Vec<_> =
        t.l1.iter()
            .map(|a| (a.id.as_str(), (a.l2.len(), a.l2.iter().map(|b| b.l3.len()).sum::<usize>())))
            .collect();
    let expected: Vec<_> =
        stated.filter_map(|l| l.split_once(' ')).map(|(id, counts)| (id, count(counts))).collect();
    assert_eq!(per_l1.len(), 5);
    assert_eq!(per_l1, expected);
}

#[test]
fn its_ids_are_those_of_the_tree_in_order() {
    let ours: Vec<String> = Framework::bundled().taxonomy.ids().iter().map(ToString::to_string).collect();
    assert_eq!(ours, expected_ids());
}

#[test]
fn every_class_is_described_and_every_l2_has_typical_decisions() {
    for (l1, l2, l3) in Framework::bundled().taxonomy.leaves() {
        let id = ScenarioId::leaf(&l1.id, &l2.id, &l3.id);
        for text in [&l1.definition, &l2.definition, &l3.definition, &l3.condition] {
            assert!(!text.zh.is_empty() && !text.en.is_empty() && text.zh != text.en, "{id}: {text:?}");
        }
        assert!(
            !l3.typical_decisions.longitudinal.is_empty() || !l3.typical_decisions.lateral.is_empty(),
            "{id}"
        );
        assert!(!l2.mining_conditions.is_empty(), "{id}");
    }
}

#[test]
fn typical_decisions_fit_the_leaf() {
    // By the meanings of the decisions in LABELING.md 2: `resume` is a start from standstill, so it is typical only of
    // leaves about starting; `stop_for_regulation` alone answers a light that stops the ego; `turn` needs a maneuver
    // onto another road.
    let f = Framework::bundled();
    let mut resuming = Vec::new();
    for (a, b, c) in f.taxonomy.leaves() {
        let leaf = ScenarioId::leaf(&a.id, &b.id, &c.id);
        let d = &c.typical_decisions;
        if d.longitudinal.contains(&Longitudinal::Resume) {
            resuming.push(leaf.to_string());
        }
        if let Some(mandated) = f.specs[&leaf].lateral {
            assert_eq!(d.lateral, [mandated], "{leaf}: the prescribed decision is the typical one");
        }
    }
    assert_eq!(
        resuming,
        [
            "reactive_agent.following.stop_and_go",
            "reactive_agent.following.follow_start",
            "reactive_rule.traffic_light.resume_first",
            "reactive_rule.traffic_light.resume_follow",
            "reactive_rule.traffic_light.wait_area_entry",
            "reactive_rule.special_facility.gate",
            "proactive.lane_change.escape",
        ]
    );
    let of = |id: &str| f.taxonomy.leaf(&id.parse().unwrap()).unwrap().2.typical_decisions.clone();
    for stop in ["reactive_rule.traffic_light.red_stop", "reactive_rule.traffic_light.yellow_stop"] {
        assert_eq!(of(stop).longitudinal, [Longitudinal::StopForRegulation], "{stop}");
    }
    assert_eq!(of("proactive.turn.straight").lateral, [Lateral::LaneKeeping]);
    assert_eq!(of("proactive.lane_change.abort").lateral, [Lateral::ManeuverAbort]);
    assert!(!of("proactive.pull_over.normal").longitudinal.contains(&Longitudinal::StopForRegulation));
}

#[test]
fn every_pair_that_overlaps_is_decided() {
    // LABELING.md 8, last row; "three kinds of construction" are the three leaves of that name and road_change.
    let t = &Framework::bundled().taxonomy;
    let decided = |x: &str, y: &str| {
        t.leaves().any(|(a, b, c)| {
            let owner = ScenarioId::leaf(&a.id, &b.id, &c.id);
            c.decides.iter().chain(&b.decides).any(|d| {
                let (x, y): (ScenarioId, ScenarioId) = (x.parse().unwrap(), y.parse().unwrap());
                (owner.is_within(&x) && (d.against.is_within(&y) || y.is_within(&d.against)))
                    || (owner.is_within(&y) && (d.against.is_within(&x) || x.is_within(&d.against)))
            })
        })
    };
    for (x, y) in [
        ("reactive_rule.special_facility.roundabout", "proactive.roundabout"),
        ("reactive_agent.intersection_interaction.unprotected_left", "proactive.turn.left_unprotected"),
        ("reactive_agent.vehicle_abnormal.sudden_brake", "reactive_agent.following.lead_sudden_brake"),
        ("reactive_rule.traffic_light.resume_follow", "reactive_agent.following.follow_start"),
        ("reactive_road.surface_adaptation.speed_bump", "reactive_rule.speed_limit.bump_limit"),
        ("proactive.pull_over.gate_stop", "reactive_rule.special_facility.gate"),
        ("reactive_agent.passing.construction", "reactive_road.blind_spot_slowdown.construction"),
        ("reactive_agent.passing.construction", "reactive_rule.road_change.construction"),
        ("reactive_road.blind_spot_slowdown.construction", "reactive_rule.road_change.construction"),
    ] {
        assert!(decided(x, y), "no rule decides between {x} and {y}");
    }
}

#[test]
fn the_decisions_are_the_closed_sets_in_order() {
    let d = &Framework::bundled().decisions;
    assert_eq!(d.longitudinal.iter().map(|x| x.id).collect::<Vec<_>>(), Longitudinal::ALL);
    assert_eq!(d.lateral.iter().map(|x| x.id).collect::<Vec<_>>(), Lateral::ALL);
}

#[test]
fn every_leaf_has_a_spec_and_the_mandatory_parts_are_those_of_the_specification() {
    let f = Framework::bundled();
    assert_eq!(f.specs.len(), f.taxonomy.leaves().count());
    // LABELING.md 3: "mandatory for every leaf of vru_emergence and blind_spot_slowdown, and for cutout_reveal".
    for (leaf, spec) in &f.specs {
        let l2 = leaf.l2.as_deref().unwrap();
        let expected = matches!(l2, "vru_emergence" | "blind_spot_slowdown")
            || leaf.to_string() == "reactive_agent.vehicle_abnormal.cutout_reveal";
        assert_eq!(spec.uncertainty_high, expected, "{leaf}");
        assert_eq!(
            spec.second_keyframe.is_some(),
            leaf.to_string() == "reactive_agent.vehicle_abnormal.cutout_reveal",
            "{leaf}"
        );
    }
    // TAXONOMY.md, obstacle_avoidance: 横向=in_lane_nudge, 横向=out_of_lane_nudge.
    let lateral: BTreeMap<String, Lateral> =
        f.specs.iter().filter_map(|(leaf, s)| Some((leaf.to_string(), s.lateral?))).collect();
    let expected = BTreeMap::from([
        ("proactive.obstacle_avoidance.borrow_lane".to_owned(), Lateral::OutOfLaneNudge),
        ("proactive.obstacle_avoidance.in_lane".to_owned(), Lateral::InLaneNudge),
    ]);
    assert_eq!(lateral, expected);
}

#[test]
fn keyframe_types_are_those_of_the_specification() {
    use whyroad_model::messages::KeyframeType::{Proactive, Reactive};
    // LABELING.md 4: the L1 defaults, and the rows of its second table that differ from them.
    for (leaf, spec) in &Framework::bundled().specs {
        let (l1, l2, l3) = (leaf.l1.as_str(), leaf.l2.as_deref().unwrap(), leaf.l3.as_deref().unwrap());
        let expected = match (l1, l2, l3) {
            (_, "intersection_interaction", _) => Proactive,
            (_, "lane_change", "abort") | (_, "obstacle_avoidance" | "turn", _) => Reactive,
            ("reactive_road" | "proactive", _, _) => Proactive,
            _ => Reactive,
        };
        assert_eq!(spec.keyframe.kind, expected, "{leaf}");
    }
}

#[test]
fn records_are_demanded_of_exactly_the_leaves_that_the_specification_names() {
    let named: Vec<&str> = include_str!("../data/required_records.txt")
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_once(": ").unwrap().0)
        .collect();
    let f = Framework::bundled();
    let demanding: Vec<String> = f
        .taxonomy
        .leaves()
        .map(|(a, b, c)| ScenarioId::leaf(&a.id, &b.id, &c.id))
        .filter(|leaf| !f.specs[leaf].records.is_empty())
        .map(|leaf| leaf.to_string())
        .collect();
    assert_eq!(demanding, named);
}
