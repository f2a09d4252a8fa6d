//! A rule as written, for people to read: the texts of a `mining:` block after inheritance, with the reason of each
//! parameter. Nothing is checked here; [`super::set`] reports errors of a rule.

use super::source::inherit;
use whyroad_framework::Framework;
use whyroad_model::ScenarioId;
use whyroad_model::yaml::{Node, Value};

/// A parameter of a rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Name in the rule's texts.
    pub name: String,
    /// Value with unit.
    pub value: String,
    /// Where the value comes from.
    pub reason: String,
}

/// The texts of a rule, those of its L2 first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RuleSheet {
    /// Allowed kinds of the target; absent in a rule about the ego alone.
    pub target: Option<String>,
    /// Names of the objects that the rule binds, with the allowed kinds of each.
    pub roles: Vec<(String, String)>,
    /// Numbers.
    pub parameters: Vec<Parameter>,
    /// Named conditions.
    pub define: Vec<(String, String)>,
    /// The condition for a match.
    pub when: Vec<String>,
    /// Conditions at the keyframe.
    pub require: Vec<String>,
    /// What counts as the ego's response.
    pub response: Vec<String>,
    /// `min_duration`, `max_duration` and `merge_gap`, where the rule states them.
    pub durations: Vec<(&'static str, String)>,
}

impl RuleSheet {
    /// The rule of a leaf or of an L2; `None` without one.
    pub fn of(framework: &Framework, class: &ScenarioId) -> Option<RuleSheet> {
        let own = framework.rule(class)?;
        let l2 = ScenarioId { l3: None, ..class.clone() };
        let above = class.l3.as_ref().and_then(|_| framework.rule(&l2));
        Some(Self::read(&inherit(above.map(|r| &r.rule), &own.rule)))
    }

    fn read(block: &Node) -> RuleSheet {
        let parameter = |(name, v): (String, &Node)| Parameter {
            name,
            value: v.get("value").map(text).unwrap_or_default(),
            reason: v.get("reason").map(text).unwrap_or_default(),
        };
        let named = |key| entries(block.get(key)).map(|(name, v)| (name, text(v))).collect();
        let durations = ["min_duration", "max_duration", "merge_gap"];
        RuleSheet {
            target: block.get("target").map(text),
            roles: named("roles"),
            parameters: entries(block.get("parameters")).map(parameter).collect(),
            define: named("define"),
            when: list(block.get("when")),
            require: list(block.get("require")),
            response: list(block.get("response")),
            durations: durations.into_iter().filter_map(|k| Some((k, text(block.get(k)?)))).collect(),
        }
    }
}

fn entries(mapping: Option<&Node>) -> impl Iterator<Item = (String, &Node)> {
    mapping.map_or(&[][..], Node::entries).iter().map(|e| (e.key.clone(), &e.node))
}

fn list(node: Option<&Node>) -> Vec<String> {
    match node.map(|n| &n.value) {
        Some(Value::List(items)) => items.iter().map(text).collect(),
        Some(_) => node.map(text).into_iter().collect(),
        None => Vec::new(),
    }
}

/// The text of a scalar on one line, as written.
fn text(node: &Node) -> String {
    node.text().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaf_has_the_texts_of_its_l2_and_its_own() {
        // From scenarios/reactive_agent/cutin.yaml: the L2 states reach and when, urgent its TTC.
        let leaf = ScenarioId::leaf("reactive_agent", "cutin", "urgent");
        let sheet = RuleSheet::of(Framework::bundled(), &leaf).unwrap();
        assert_eq!(sheet.target.as_deref(), Some("vehicle"));
        let named = |name: &str| sheet.parameters.iter().find(|p| p.name == name).unwrap();
        assert_eq!(named("reach").value, "50 m");
        assert_eq!(
            (&*named("urgent_ttc").value, &*named("urgent_ttc").reason),
            ("3 s", "TAXONOMY.md, cutin.urgent")
        );
        assert_eq!(sheet.when, ["over_the_line"]);
        assert_eq!(sheet.require, ["target.gap >= 0 m", "target.ttc < urgent_ttc"]);
        assert_eq!(sheet.durations, [("min_duration", "0.2 s".to_owned()), ("merge_gap", "2 s".to_owned())]);
        assert!(sheet.define.iter().any(|(n, t)| n == "over_the_line" && !t.contains('\n')));
        assert_eq!(RuleSheet::of(Framework::bundled(), &ScenarioId::leaf("a", "b", "c")), None);
    }
}
