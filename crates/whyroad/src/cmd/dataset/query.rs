//! Mining queries for classes with too few samples in a release: the class's own rule, written out as the conditions of
//! a `mining_query`. Only queries that compile are returned.

use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_mining::rule::query::compile_query;
use whyroad_model::ScenarioId;
use whyroad_model::messages::query_clause::{QueryClause, RuleText};
use whyroad_model::messages::{MiningQuery, MiningQueryMessage};
use whyroad_model::yaml::Node;
use whyroad_signals::Catalog;

/// Rounds of replacing names by their texts: definitions may use definitions.
const DEPTH: usize = 12;

/// Makes queries from the rules of a framework.
pub(crate) struct Queries {
    catalog: Catalog,
    blocks: BTreeMap<ScenarioId, Block>,
}

/// The texts of a `mining:` block.
#[derive(Clone, Debug, Default)]
struct Block {
    names: BTreeMap<String, String>,
    when: Vec<String>,
    require: Vec<String>,
    target: Option<String>,
    roles: bool,
}

impl Queries {
    /// Of all rules.
    pub fn new(framework: &Framework) -> Self {
        let (catalog, _) = Catalog::parse(&framework.signals_yaml);
        let mut blocks: BTreeMap<ScenarioId, Block> = BTreeMap::new();
        for rule in &framework.rules {
            let own = read(&rule.rule);
            let whole = ScenarioId { l3: None, ..rule.leaf.clone() };
            let block = match blocks.get(&whole) {
                Some(l2) if rule.leaf.is_leaf() => inherit(l2, own),
                _ => own,
            };
            blocks.insert(rule.leaf.clone(), block);
        }
        Self { catalog, blocks }
    }

    /// The query that finds a class, `missing` samples short; `None` when it has no rule or one that a query cannot
    /// express.
    pub fn query(&self, class: &ScenarioId, missing: usize) -> Option<MiningQueryMessage> {
        let block = self.blocks.get(class).filter(|b| !b.roles && !b.when.is_empty())?;
        let of_class = block.target.as_deref().and_then(members).map(|m| format!("target.class in {{{m}}}"));
        let conditions = block.when.iter().chain(&block.require).chain(&of_class);
        let conditions =
            conditions.map(|text| QueryClause::Rule(RuleText { rule: written_out(text, &block.names) }));
        let query = MiningQuery {
            query_id: Some(format!("shortfall_{class}")),
            scenario_id: class.clone(),
            conditions: conditions.collect(),
            time_constraints: None,
            // People reject some mined episodes, and duplicates are dropped: twice the number is requested.
            output_limit: u32::try_from(missing.saturating_mul(2)).ok(),
        };
        let message = MiningQueryMessage { mining_query: query };
        let text = serde_json::to_string_pretty(&message).ok()?;
        compile_query(&message.mining_query, &self.catalog, &text, "query").ok()?;
        Some(message)
    }
}

/// Classes that a rule's `target` covers, in the words of `target.class`.
fn members(target: &str) -> Option<&'static str> {
    match target {
        "vehicle" => Some(
            "car, truck, bus, large_vehicle, motorcycle, motorcyclist, tricycle, emergency_vehicle, vehicle",
        ),
        "large_vehicle" => Some("truck, bus, large_vehicle"),
        "vru" => Some("pedestrian, wheeled_pedestrian, bicycle, bicyclist, e_bike"),
        "pedestrian" => Some("pedestrian, wheeled_pedestrian"),
        "animal" => Some("animal"),
        _ => None,
    }
}

fn read(node: &Node) -> Block {
    let texts = |key: &str| -> Vec<String> {
        let Some(value) = node.get(key) else { return Vec::new() };
        let one = value.text().map(str::to_owned);
        one.into_iter().chain(value.items().iter().filter_map(|n| n.text().map(str::to_owned))).collect()
    };
    let mut names = BTreeMap::new();
    for entry in node.get("parameters").map(Node::entries).unwrap_or_default() {
        if let Some(value) = entry.node.get("value").and_then(Node::text) {
            names.insert(entry.key.clone(), value.to_owned());
        }
    }
    for entry in node.get("define").map(Node::entries).unwrap_or_default() {
        if let Some(text) = entry.node.text() {
            names.insert(entry.key.clone(), format!("({text})"));
        }
    }
    let target = texts("target").pop();
    Block {
        names,
        when: texts("when"),
        require: texts("require"),
        target,
        roles: node.get("roles").is_some(),
    }
}

/// Same inheritance as for rules: names are merged, `require` is appended, `when` is replaced.
fn inherit(l2: &Block, leaf: Block) -> Block {
    let mut names = l2.names.clone();
    names.extend(leaf.names);
    Block {
        names,
        when: if leaf.when.is_empty() { l2.when.clone() } else { leaf.when },
        require: l2.require.iter().cloned().chain(leaf.require).collect(),
        target: leaf.target.or_else(|| l2.target.clone()),
        roles: l2.roles || leaf.roles,
    }
}

/// The text with every parameter and definition replaced by its meaning.
fn written_out(text: &str, names: &BTreeMap<String, String>) -> String {
    let mut text = text.to_owned();
    for _ in 0..DEPTH {
        let next = replaced(&text, names);
        if next == text {
            break;
        }
        text = next;
    }
    text
}

fn replaced(text: &str, names: &BTreeMap<String, String>) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(is_part) {
        let end = rest[start..].find(|c: char| !is_part(c)).map_or(rest.len(), |n| start + n);
        let word = &rest[start..end];
        out.push_str(&rest[..start]);
        out.push_str(names.get(word).map_or(word, String::as_str));
        rest = &rest[end..];
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_as_whole_words_only() {
        let names: BTreeMap<String, String> = [("near", "5 m"), ("close", "(target.gap < near)")]
            .map(|(a, b)| (a.to_owned(), b.to_owned()))
            .into();
        assert_eq!(
            written_out("close and not target.near", &names),
            "(target.gap < 5 m) and not target.near"
        );
        assert_eq!(written_out("nearer > near", &names), "nearer > 5 m");
    }

    #[test]
    fn most_classes_with_a_rule_have_a_query_that_compiles() {
        let framework = Framework::bundled();
        let queries = Queries::new(framework);
        let with_rule: Vec<&ScenarioId> =
            framework.rules.iter().map(|r| &r.leaf).filter(|c| c.is_leaf()).collect();
        let without: Vec<String> =
            with_rule.iter().filter(|c| queries.query(c, 10).is_none()).map(ToString::to_string).collect();
        assert!(with_rule.len() > 100);
        // Rules that bind two objects have no form as a query.
        assert!(
            without.len() * 10 <= with_rule.len(),
            "{} of {}: {without:?}",
            without.len(),
            with_rule.len()
        );
        assert_eq!(queries.query(&"other".parse().unwrap(), 1).map(|_| ()), None);
    }
}
