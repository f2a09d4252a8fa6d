//! Whether the texts of a taxonomy agree: what tells two classes apart is stated by both in the same words, and classes
//! that texts name exist. Warnings: every class is usable nevertheless.

use super::{Taxonomy, is_snake_case};
use std::collections::{BTreeMap, BTreeSet};
use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::yaml::{FileReport, Node};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};

/// Fields of a class whose texts name other classes.
const TEXTS: [&str; 6] =
    ["definition", "definition_en", "condition", "condition_en", "mining_conditions", "mining_conditions_en"];

/// A deciding rule that the other class does not state, or states in other words. `against`: the class that states the
/// rule, the other one, and the position of the latter's id.
pub(super) fn decides(
    taxonomy: &Taxonomy,
    against: &[(ScenarioId, ScenarioId, &Node)],
    report: &mut FileReport<'_>,
) {
    let rules = rules(taxonomy);
    let rule = |of: &ScenarioId, other: &ScenarioId| rules.get(&(of.clone(), other.clone())).copied();
    for (owner, other, node) in against.iter().filter(|(owner, other, _)| owner != other) {
        let Some(own) = rule(owner, other).filter(|_| taxonomy.contains(other)) else { continue };
        let message = match rule(other, owner) {
            Some(back) if back == own => continue,
            // Said once, for the first of the two.
            Some(_) if owner > other => continue,
            Some(_) => Bilingual::new(
                format!("{owner} 与 {other} 的判别规则两边不同"),
                format!("{owner} and {other} state different rules that decide between them"),
            ),
            None => Bilingual::new(
                format!("{other} 没有写明与 {owner} 的判别规则"),
                format!("{other} does not state the rule that decides between it and {owner}"),
            ),
        };
        let hint = Bilingual::new(
            "两边都写明判别规则（decides），中英文各自相同",
            "state the rule under `decides` of both classes, in the same words in each language",
        );
        let d = Diagnostic::warning("taxonomy.decides.differs", message).with_hint(hint);
        report.push(d, node.mark, &node.pointer);
    }
}

/// The deciding rules by the class that states them and the other class.
fn rules(taxonomy: &Taxonomy) -> BTreeMap<(ScenarioId, ScenarioId), &Bilingual> {
    let mut out = BTreeMap::new();
    for a in &taxonomy.l1 {
        for b in &a.l2 {
            let id = ScenarioId { l1: a.id.clone(), l2: Some(b.id.clone()), l3: None };
            let of_leaves = b.l3.iter().map(|c| (ScenarioId::leaf(&a.id, &b.id, &c.id), &c.decides));
            for (id, decides) in std::iter::once((id, &b.decides)).chain(of_leaves) {
                out.extend(decides.iter().map(|d| ((id.clone(), d.against.clone()), &d.rule)));
            }
        }
    }
    out
}

/// Ids in definitions, conditions and deciding rules that name no class, as after another class was renamed. `nodes`:
/// the classes as written, by full id.
pub(super) fn named_classes(
    taxonomy: &Taxonomy,
    nodes: &BTreeMap<String, &Node>,
    report: &mut FileReport<'_>,
) {
    let ids = taxonomy.ids();
    let known: Vec<String> = ids.iter().map(ToString::to_string).collect();
    let names = Names {
        above: ids.iter().map(|id| id.l2.as_deref().unwrap_or(&id.l1)).collect(),
        leaves: ids.iter().filter_map(|id| id.l3.as_deref()).collect(),
        known: &known,
    };
    for node in nodes.values() {
        let own = TEXTS.iter().filter_map(|key| node.get(key));
        let rules = node.get("decides").map_or(&[][..], Node::items).iter();
        let rules = rules.flat_map(|rule| ["rule", "rule_en"].into_iter().filter_map(|key| rule.get(key)));
        for text in own.chain(rules).flat_map(texts) {
            for id in names.unknown(text.text().unwrap_or_default()) {
                let message = Bilingual::new(
                    format!("文本提到类别 '{id}'，分类体系中没有"),
                    format!("the text names the class '{id}', which the taxonomy does not have"),
                );
                let last = id.rsplit('.').next().unwrap_or(id);
                // The class with the same last part, or one with a similar id.
                let same = known.iter().find(|k| k.rsplit('.').next() == Some(last));
                let near = same.map(String::as_str);
                let near = near.or_else(|| did_you_mean(id, known.iter().map(String::as_str)));
                let d = Diagnostic {
                    hint: near.map(suggestion),
                    ..Diagnostic::warning("taxonomy.text.class", message)
                };
                report.push(d, text.mark, &text.pointer);
            }
        }
    }
}

/// A text, or each text of a list.
fn texts(node: &Node) -> Vec<&Node> {
    if node.text().is_some() { vec![node] } else { node.items().iter().collect() }
}

/// Ids of classes, to recognize those that are none.
struct Names<'t> {
    /// Of L1 and L2.
    above: BTreeSet<&'t str>,
    /// Of leaves.
    leaves: BTreeSet<&'t str>,
    /// In full.
    known: &'t [String],
}

impl Names<'_> {
    /// Parts of `text` that are written as ids of classes and name none: the last part is that of a leaf, or the first
    /// that of a class above one. Names of signals (`ego.speed`) are neither.
    fn unknown<'x>(&self, text: &'x str) -> BTreeSet<&'x str> {
        let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
        let words = text.split(|c: char| !is_part(c)).map(|word| word.trim_matches('.'));
        let is_id = |word: &&str| {
            let parts: Vec<&str> = word.split('.').collect();
            matches!(parts.len(), 2 | 3)
                && parts.iter().all(|part| is_snake_case(part))
                && (self.above.contains(parts[0]) || parts.last().is_some_and(|p| self.leaves.contains(p)))
        };
        let is_known = |word: &&str| {
            self.known
                .iter()
                .any(|id| id == word || id.strip_suffix(word).is_some_and(|up| up.ends_with('.')))
        };
        words.filter(is_id).filter(|word| !is_known(word)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::Framework;
    use crate::taxonomy::read_taxonomy;

    /// Codes and messages for the built-in taxonomy with other texts.
    fn said(from: &str, to: &str) -> Vec<String> {
        let text = &Framework::bundled_files()["schema/scenario_taxonomy.yaml"];
        let changed = text.replacen(from, to, 1);
        assert_ne!(&changed, text, "{from}");
        let found = read_taxonomy("t.yaml", &changed).1;
        found.iter().map(|d| format!("{}: {}", d.code, d.message.en)).collect()
    }

    /// docs/how-to/edit-the-framework.md: "state the deciding rule in both, in the same words".
    #[test]
    fn a_deciding_rule_is_the_same_on_both_sides() {
        let text = &Framework::bundled_files()["schema/scenario_taxonomy.yaml"];
        let at = text.find("        - against: \"reactive_agent.cutin.slow\"\n").unwrap();
        let len = text[at + 10..].find("        - against:").unwrap() + 10;
        let entry = &text[at..at + len];
        let english = entry.lines().find(|l| l.contains("rule_en:")).unwrap();
        let differs = said(english, "          rule_en: \"Whichever lasts 5 s.\"");
        assert_eq!(differs.len(), 1, "{differs:?}");
        assert!(differs[0].starts_with("taxonomy.decides.differs: ") && differs[0].contains("different"));
        let gone = said(entry, "");
        assert_eq!(gone.len(), 1, "{gone:?}");
        assert!(gone[0].starts_with("taxonomy.decides.differs: ") && gone[0].contains("does not state"));
    }

    #[test]
    fn a_text_that_names_a_class_that_is_gone_is_reported() {
        let found = said("(turn.straight)", "(junction_turn.straight)");
        assert_eq!(
            found,
            [
                "taxonomy.text.class: the text names the class 'junction_turn.straight', which the taxonomy does not have"
            ]
        );
        assert!(said("(turn.straight)", "(ego.speed, e.g. i.e. 0.5 m)").is_empty());
    }
}
