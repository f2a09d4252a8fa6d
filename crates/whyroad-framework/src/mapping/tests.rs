use super::*;
use crate::Framework;

fn read(text: &str) -> Result<ClassMapping, Vec<whyroad_model::Diagnostic>> {
    let after = &Framework::bundled().taxonomy;
    let text = text.replace("$TO", &after.version);
    read_mapping("m.yaml", &text, None, after)
}

fn id(text: &str) -> ScenarioId {
    text.parse().unwrap()
}

const HEAD: &str = "from: 0.9.0\nto: $TO\nchanges:\n";

#[test]
fn renames_merges_and_splits_are_read() {
    let text = format!(
        "{HEAD}  - rename: reactive_agent.cut_in\n    to: reactive_agent.cutin\n  \
         - merge: [reactive_agent.old.a, reactive_agent.old.b]\n    to: reactive_agent.cutin.slow\n  \
         - split: reactive_agent.old.c\n    into:\n      - to: reactive_agent.cutin.urgent\n        \
         when: {{ /driving_decision/longitudinal: [yield_to_agent, null] }}\n      - to: reactive_agent.cutin.ramp\n"
    );
    let m = read(&text).unwrap();
    // A rename of an L2 also applies to its leaves.
    assert_eq!(
        m.change(&id("reactive_agent.cut_in.urgent")),
        Some(ClassChange::To(id("reactive_agent.cutin.urgent")))
    );
    assert_eq!(m.change(&id("reactive_agent.old.b")), Some(ClassChange::To(id("reactive_agent.cutin.slow"))));
    let Some(ClassChange::Split(parts)) = m.change(&id("reactive_agent.old.c")) else { panic!("{m:?}") };
    assert_eq!(parts[0].when["/driving_decision/longitudinal"], [Some("yield_to_agent".to_owned()), None]);
    assert!(parts[1].when.is_empty());
    assert_eq!(m.change(&id("reactive_agent.cutin.urgent")), None, "what is not named stays");
    assert_eq!(m.mark.len(), 16);
}

#[test]
fn mistakes_are_reported_where_they_are() {
    let at = |changes: &str| -> Vec<(&'static str, Option<usize>)> {
        let found = read(&format!("{HEAD}{changes}")).unwrap_err();
        found.iter().map(|d| (d.code, d.location.line)).collect()
    };
    assert_eq!(
        at("  - rename: reactive_agent.x\n    to: reactive_agent.cutin.nowhere\n"),
        [("mapping.class", Some(5))]
    );
    assert_eq!(
        at("  - rename: reactive_agent.x\n    to: reactive_agent.cutin.urgent\n"),
        [("mapping.level", Some(4))]
    );
    let chain = "  - rename: reactive_agent.a.b\n    to: reactive_agent.cutin.slow\n  \
                 - rename: reactive_agent.cutin.slow\n    to: reactive_agent.cutin.urgent\n";
    assert_eq!(at(chain), [("mapping.conflict", Some(4))]);
    let twice = "  - rename: reactive_agent.a.b\n    to: reactive_agent.cutin.slow\n  \
                 - rename: reactive_agent.a.b\n    to: reactive_agent.cutin.urgent\n";
    assert_eq!(at(twice), [("mapping.conflict", Some(6))]);
    let field = "  - split: reactive_agent.a.b\n    into:\n      - to: reactive_agent.cutin.slow\n        \
                 when: { /nothing: x }\n      - to: reactive_agent.cutin.urgent\n";
    assert_eq!(at(field), [("mapping.condition", Some(7))]);
    let alone = "  - split: reactive_agent.a.b\n    into:\n      - to: reactive_agent.cutin.slow\n";
    assert_eq!(at(alone), [("mapping.missing", Some(4))]);
    assert_eq!(at("  - to: reactive_agent.cutin.slow\n"), [("mapping.missing", Some(4))]);
}

#[test]
fn the_versions_must_fit_the_taxonomy_in_force() {
    let found = read("from: 0.9.0\nto: 99.0.0\nchanges: []\n").unwrap_err();
    assert_eq!(found[0].code, "mapping.version");
    let after = &Framework::bundled().taxonomy;
    let text = format!(
        "from: {v}\nto: {v}\nchanges:\n  - rename: a.b.c\n    to: reactive_agent.cutin.slow\n",
        v = after.version
    );
    let found = read_mapping("m.yaml", &text, Some(after), after).unwrap_err();
    assert_eq!((found[0].code, found[0].location.line), ("mapping.class", Some(4)));
}

#[test]
fn with_both_sides_known_no_class_is_forgotten() {
    // The classes after the change are those of the built-in framework without one leaf.
    let before = &Framework::bundled().taxonomy;
    let mut after = before.clone();
    let agents = after.l1.iter_mut().find(|a| a.id == "reactive_agent").unwrap();
    let cutin = agents.l2.iter_mut().find(|b| b.id == "cutin").unwrap();
    cutin.l3.retain(|c| c.id != "slow");
    let with = |changes: &str| {
        let text = format!("from: {v}\nto: {v}\nchanges:{changes}\n", v = before.version);
        read_mapping("m.yaml", &text, Some(before), &after)
    };
    let found = with(" []").unwrap_err();
    let said: Vec<(&str, bool)> =
        found.iter().map(|d| (d.code, d.message.en.contains("reactive_agent.cutin.slow"))).collect();
    assert_eq!(said, [("mapping.forgotten", true)]);
    assert!(with("\n  - merge: [reactive_agent.cutin.slow]\n    to: reactive_agent.cutin").is_ok());
}
