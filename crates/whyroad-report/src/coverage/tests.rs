use super::*;
use whyroad_model::messages::LeafCoverage;

fn taxonomy() -> Taxonomy {
    let text = include_str!("../../../../schema/scenario_taxonomy.yaml");
    let (taxonomy, problems) = whyroad_framework::taxonomy::read_taxonomy("scenario_taxonomy.yaml", text);
    assert!(problems.is_empty(), "{problems:?}");
    taxonomy.unwrap()
}

fn leaf(id: &str, state: CoverageState) -> LeafCoverage {
    LeafCoverage {
        scenario_id: id.parse().unwrap(),
        state,
        episodes: u64::from(state == CoverageState::Found),
        primary_episodes: 0,
        drives_searched: 1,
        gaps: Vec::new(),
    }
}

#[test]
fn every_leaf_has_a_row_and_what_mining_does_not_mention_has_no_rule() {
    let taxonomy = taxonomy();
    let coverage = Coverage {
        leaves: vec![
            leaf("reactive_agent.cutin.urgent", CoverageState::Found),
            leaf("reactive_agent.cutin.slow", CoverageState::NotFound),
            leaf("reactive_rule.traffic_light.red_stop", CoverageState::NotObservable),
        ],
        ..Coverage::default()
    };
    let rows = rows(&taxonomy, &coverage);
    // Their number is compared with LABELING.md 8 in the tests of the framework.
    let all = taxonomy.leaves().count();
    assert_eq!(rows.len(), all);
    let expected = StateCounts { found: 1, not_found: 1, not_observable: 1, no_rule: all - 3 };
    assert_eq!(counts(&rows), expected);
    assert_eq!(expected.total(), all);
    assert_eq!(rows[0].id.to_string(), "reactive_agent.cutin.urgent");
    assert_eq!(rows[0].episodes, 1);
}

#[test]
fn a_leaf_of_another_taxonomy_is_named() {
    let coverage = Coverage {
        leaves: vec![leaf("reactive_agent.cutin.gone", CoverageState::Found)],
        ..Coverage::default()
    };
    let taxonomy = taxonomy();
    let unknown: Vec<String> = unknown_leaves(&taxonomy, &coverage).iter().map(ToString::to_string).collect();
    assert_eq!(unknown, ["reactive_agent.cutin.gone"]);
}

#[test]
fn missing_signals_of_several_drives_are_named_once() {
    let gap = |drive: &str, signals: &[&str]| DriveGap {
        drives: vec![drive.into()].into(),
        missing_signals: signals.iter().map(|s| (*s).to_owned()).collect(),
    };
    let mut found = leaf("reactive_rule.traffic_light.red_stop", CoverageState::NotObservable);
    found.gaps = vec![gap("a", &["light.state", "ego.speed"]), gap("b", &["light.state"])];
    let coverage = Coverage { leaves: vec![found], ..Coverage::default() };
    let taxonomy = taxonomy();
    let rows = rows(&taxonomy, &coverage);
    let row = rows.iter().find(|r| r.state == CoverageState::NotObservable).unwrap();
    assert_eq!(row.missing_signals(), ["ego.speed", "light.state"]);
}
