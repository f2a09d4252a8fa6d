//! Mining queries for classes with too few samples in a release. A query names the class and has no conditions: it asks
//! for all episodes of the class by the rules at the time of mining. So the query of an L2 finds those of its leaves,
//! which count for it, and rules about two objects, which conditions cannot express, are asked, too.

use std::collections::BTreeSet;
use whyroad_framework::Framework;
use whyroad_mining::RuleSet;
use whyroad_model::ScenarioId;
use whyroad_model::messages::{MiningQuery, MiningQueryMessage};
use whyroad_signals::Catalog;

/// Makes queries for the classes that a framework's rules find.
pub(crate) struct Queries {
    /// Classes with a rule, and the L2 of each.
    found: BTreeSet<ScenarioId>,
}

impl Queries {
    /// Of all rules that compile.
    pub fn new(framework: &Framework) -> Self {
        let (catalog, _) = Catalog::parse(&framework.signals_yaml);
        let (rules, _) = RuleSet::of_framework(framework, &catalog);
        let classes = rules.rules.into_iter().map(|rule| rule.scenario);
        let found = classes.flat_map(|id| [ScenarioId { l3: None, ..id.clone() }, id]).collect();
        Self { found }
    }

    /// The query that finds a class, `missing` samples short; `None` when no rule finds it.
    pub fn query(&self, class: &ScenarioId, missing: usize) -> Option<MiningQueryMessage> {
        self.found.contains(class).then(|| MiningQueryMessage {
            mining_query: MiningQuery {
                query_id: Some(format!("shortfall_{class}")),
                scenario_id: class.clone(),
                conditions: Vec::new(),
                time_constraints: None,
                // People reject some mined episodes, and duplicates are dropped: twice the number is requested.
                output_limit: u32::try_from(missing.saturating_mul(2)).ok(),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_class_that_a_rule_finds_has_a_query_and_no_other() {
        let framework = Framework::bundled();
        let queries = Queries::new(framework);
        assert!(framework.rules.len() > 100);
        for rule in &framework.rules {
            let whole = ScenarioId { l3: None, ..rule.leaf.clone() };
            for class in [&rule.leaf, &whole] {
                let query = queries.query(class, 10).map(|m| m.mining_query);
                assert_eq!(query.map(|q| (q.scenario_id, q.output_limit)), Some((class.clone(), Some(20))));
            }
        }
        // An L2 whose leaves alone have rules, and a rule about two objects.
        for class in ["safety.aeb", "reactive_agent.following.follow_start"] {
            assert!(queries.query(&class.parse().unwrap(), 1).is_some(), "{class}");
        }
        assert_eq!(queries.query(&"other".parse().unwrap(), 1), None);
    }

    #[test]
    fn a_class_without_a_rule_has_no_query() {
        let mut framework = Framework::bundled().clone();
        framework.rules.retain(|r| r.leaf.to_string() != "reactive_agent.cutin.urgent");
        let queries = Queries::new(&framework);
        let has = |class: &str| queries.query(&class.parse().unwrap(), 1).is_some();
        assert_eq!(
            ["reactive_agent.cutin.urgent", "reactive_agent.cutin.slow", "reactive_agent.cutin"].map(has),
            [false, true, true]
        );
    }
}
