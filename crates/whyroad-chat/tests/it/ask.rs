//! Questions in words: a rule at once, a rule after corrections, and none.

use crate::scripted::{Reply, Scripted};
use serde_json::json;
use whyroad_chat::ask::ask;
use whyroad_chat::{ChatError, Client, Settings};
use whyroad_framework::Framework;
use whyroad_model::{Lang, ScenarioId};
use whyroad_signals::Catalog;

fn rule(text: &str, target: &str) -> Reply {
    Reply::Says(json!({ "rule": text, "target": target, "explanation": "close vehicles" }).to_string())
}

fn asked(endpoint: &Scripted, corrections: u32) -> Result<whyroad_chat::ask::Asked, ChatError> {
    let client = Client::new(Settings::new(&endpoint.url, "m")).unwrap();
    let all = (Framework::bundled(), Catalog::bundled());
    ask(&client, all, "Who comes close?", &ScenarioId::custom("close"), Lang::En, corrections)
}

#[test]
fn type_errors_go_back_until_the_rule_compiles() {
    let endpoint = Scripted::new(|n, _| match n {
        0 => rule("target.ttc < 2 m", "vehicle"),
        1 => rule("target.time_to_collision < 2 s", "vehicle"),
        _ => rule("target.ttc < 2 s for 0.5 s", "vehicle"),
    });
    let done = asked(&endpoint, 3).unwrap();
    assert!(done.rule.is_some());
    let codes: Vec<Vec<&str>> =
        done.attempts.iter().map(|a| a.faults.iter().map(|d| d.code).collect()).collect();
    assert_eq!(codes, [vec!["rule.unit.mismatch"], vec!["rule.signal.unknown"], vec![]]);
    let seen = endpoint.seen();
    assert!(seen[0].text().contains("target.ttc: number s: "), "the signals are listed");
    assert!(seen[0].text().contains("Who comes close?"));
    let told = seen[1].body["messages"][3]["content"].as_str().unwrap();
    assert!(told.contains("rule.unit.mismatch"), "{told}");
}

#[test]
fn corrections_end() {
    let endpoint = Scripted::new(|_, _| rule("speed is low", "none"));
    let done = asked(&endpoint, 2).unwrap();
    assert!(done.rule.is_none());
    assert_eq!((done.attempts.len(), endpoint.seen().len()), (3, 3));
    assert_eq!(done.attempts[2].faults[0].code, "rule.syntax");
    let odd = Scripted::new(|_, _| rule("ego.speed < 1 m/s", "spaceship"));
    assert!(matches!(asked(&odd, 2), Err(ChatError::Answer(_))));
}
