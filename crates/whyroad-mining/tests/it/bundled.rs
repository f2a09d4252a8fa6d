//! The rules that are built in: every one is a program, none has a fault.

use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_model::{Lang, diagnostic};
use whyroad_signals::Catalog;

#[test]
fn every_bundled_rule_is_a_program() {
    let (set, found) = RuleSet::of_framework(Framework::bundled(), Catalog::bundled());
    let text: String = found.iter().map(|d| diagnostic::render_text(d, Lang::En)).collect();
    assert!(found.is_empty(), "{text}");
    let ids: Vec<String> = set.rules.iter().map(|r| r.scenario.to_string()).collect();
    // Issue 2, section 5: at least these.
    for wanted in [
        "reactive_agent.following.steady",
        "reactive_agent.following.follow_start",
        "reactive_agent.following.follow_stop",
        "reactive_agent.cutin.urgent",
        "reactive_agent.cutin.slow",
        "reactive_agent.cutin.large_vehicle",
        "reactive_agent.vru_crossing.horizontal",
        "reactive_agent.vru_crossing.diagonal",
        "reactive_agent.vru_crossing.crosswalk",
        "proactive.turn.straight",
        "proactive.turn.left_normal",
        "proactive.turn.right_normal",
        "proactive.lane_change",
        "reactive_road.geometry_adaptation.high_curvature",
        "safety.near_miss.general",
    ] {
        assert!(ids.iter().any(|id| id == wanted), "no rule for {wanted}");
    }
}
