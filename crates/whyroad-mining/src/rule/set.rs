//! All rules of a framework, and the order in which their classes take precedence.

use super::Rule;
use super::origin::{Origin, SourceFile};
use super::source::{compile, inherit};
use crate::language::{Fault, Span};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::{Calibration, Framework, Taxonomy, yaml_text};
use whyroad_model::suggest::{did_you_mean, suggestion};
use whyroad_model::units::{Dimension, Unit};
use whyroad_model::yaml::Mark;
use whyroad_model::{Bilingual, Diagnostic, Nanos, ScenarioId};
use whyroad_signals::Catalog;

/// Rules, in taxonomy order, an L2 before its leaves.
#[derive(Clone, Debug, Default)]
pub struct RuleSet {
    /// The rules that could be made.
    pub rules: Vec<Rule>,
    /// Which class is primary where several match.
    pub precedence: Precedence,
    /// Accuracy of episodes of each class.
    pub calibration: Calibration,
}

impl RuleSet {
    /// All rules of a framework. A rule with faults is left out and its faults are reported.
    pub fn of_framework(framework: &Framework, catalog: &Catalog) -> (RuleSet, Vec<Diagnostic>) {
        let mut found = Vec::new();
        let mut rules = Vec::new();
        let blocks: BTreeMap<_, _> = framework.rules.iter().map(|r| (&r.leaf, &r.rule)).collect();
        for source in &framework.rules {
            let l2 = ScenarioId { l3: None, ..source.leaf.clone() };
            let (block, spec) = match &source.leaf.l3 {
                Some(_) => {
                    let block = inherit(blocks.get(&l2).copied(), &source.rule);
                    (block, framework.specs.get(&source.leaf))
                }
                // A block without `when` only has the parts that the leaves share.
                None if source.rule.get("when").is_none() => continue,
                None => (source.rule.clone(), framework.l2_specs.get(&l2)),
            };
            let file = SourceFile { name: &source.file, text: &source.text };
            let origin = Origin { file, mark: source.mark, expressions: &framework.expressions };
            match compile(&source.leaf, &block, spec, catalog, &origin) {
                Ok(rule) => rules.push(rule),
                Err(faults) => found.extend(faults),
            }
        }
        // An error in an L2's block appears again in each leaf that inherits it.
        let mut unique: Vec<Diagnostic> = Vec::new();
        for d in found {
            if !unique.iter().any(|u| {
                (u.code, u.location.line, u.location.column, &u.message)
                    == (d.code, d.location.line, d.location.column, &d.message)
            }) {
                unique.push(d);
            }
        }
        let (precedence, faults) = Precedence::parse(&framework.precedence_yaml, &framework.taxonomy);
        unique.extend(faults);
        let calibration = framework.calibration.clone();
        (RuleSet { rules, precedence, calibration }, unique)
    }

    /// Leaves of `framework` whose rule is written but not among these rules: it has errors, or the file that should
    /// hold it cannot be read.
    pub fn unusable(&self, framework: &Framework) -> BTreeSet<ScenarioId> {
        let usable: BTreeSet<&ScenarioId> = self.rules.iter().map(|r| &r.scenario).collect();
        let written: BTreeSet<&ScenarioId> = framework.rules.iter().map(|r| &r.leaf).collect();
        let leaves = framework.taxonomy.leaves().map(|(l1, l2, l3)| {
            let is_read = framework.spec_versions.contains_key(&Framework::spec_path(&l1.id, &l2.id));
            (ScenarioId::leaf(&l1.id, &l2.id, &l3.id), is_read)
        });
        let unusable =
            leaves.filter(|(id, is_read)| !usable.contains(id) && (written.contains(id) || !is_read));
        unusable.map(|(id, _)| id).collect()
    }

    /// Files of `framework` with a rule that is not among these: it has errors, or uses a signal that has.
    pub fn files_left_out(&self, framework: &Framework) -> BTreeSet<String> {
        let usable: BTreeSet<&ScenarioId> = self.rules.iter().map(|r| &r.scenario).collect();
        let is_rule = |r: &&whyroad_framework::RuleSource| r.leaf.is_leaf() || r.rule.get("when").is_some();
        let left_out = framework.rules.iter().filter(is_rule).filter(|r| !usable.contains(&r.leaf));
        left_out.map(|r| r.file.clone()).collect()
    }

    /// The rules for these classes: of the class itself and of everything below it.
    #[must_use]
    pub fn restricted_to(&self, wanted: &[ScenarioId]) -> Self {
        let within = |r: &&Rule| wanted.iter().any(|w| r.scenario.is_within(w));
        let rules = self.rules.iter().filter(within).cloned().collect();
        Self { rules, precedence: self.precedence.clone(), calibration: self.calibration.clone() }
    }
}

/// Order of classes (`schema/precedence.yaml`).
#[derive(Clone, Debug)]
pub struct Precedence {
    /// Keyframes closer than this compete.
    pub neighbourhood: Nanos,
    order: Vec<ScenarioId>,
}

impl Default for Precedence {
    fn default() -> Self {
        Self { neighbourhood: Nanos(1_000_000_000), order: Vec::new() }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PrecedenceFile {
    #[serde(rename = "version")]
    _version: String,
    neighbourhood: String,
    order: Vec<String>,
}

/// Name of the file in a framework.
const PRECEDENCE_FILE: &str = "schema/precedence.yaml";

impl Precedence {
    /// Reads the file; a class that does not exist, or is named twice, is reported.
    pub fn parse(text: &str, taxonomy: &Taxonomy) -> (Precedence, Vec<Diagnostic>) {
        let source = SourceFile { name: PRECEDENCE_FILE, text };
        let what = Bilingual::new("优先级文件", "the order of precedence");
        let read = yaml_text::read::<PrecedenceFile>("rule.precedence", PRECEDENCE_FILE, text, what);
        let (file, root) = match read {
            Ok(read) => read,
            Err(finding) => return (Precedence::default(), vec![*finding]),
        };
        let mut found = Vec::new();
        let fault = |zh, en| Fault::new("rule.precedence", Span::default(), zh, en);
        let mut report =
            |mark: Mark, pointer: &str, fault: Fault| found.push(source.at(mark, pointer, fault));
        let classes: Vec<String> = taxonomy.ids().iter().map(ToString::to_string).collect();
        let mut out = Precedence::default();
        match seconds(&file.neighbourhood) {
            Some(n) => out.neighbourhood = n,
            None => report(
                root.get("neighbourhood").map(|n| n.mark).unwrap_or_default(),
                "/neighbourhood",
                fault(
                    format!("neighbourhood '{}' 不是时长", file.neighbourhood),
                    format!("neighbourhood '{}' is not a time", file.neighbourhood),
                )
                .hint("例如 neighbourhood: 1 s", "such as neighbourhood: 1 s"),
            ),
        }
        let entries = root.get("order").map_or(&[][..], |n| n.items());
        for (word, node) in file.order.iter().zip(entries) {
            match word.parse::<ScenarioId>() {
                Ok(id) if taxonomy.contains(&id) && !out.order.contains(&id) => out.order.push(id),
                Ok(id) if out.order.contains(&id) => {
                    let (zh, en) = (format!("'{word}' 出现了两次"), format!("'{word}' is listed twice"));
                    let twice = fault(zh, en).hint("删除其中一行", "delete one of the two lines");
                    report(node.mark, &node.pointer, twice);
                }
                _ => {
                    let (zh, en) = (format!("没有名为 '{word}' 的类别"), format!("class '{word}' not found"));
                    let unknown = fault(zh, en);
                    let near = did_you_mean(word, classes.iter().map(String::as_str)).map(suggestion);
                    let unknown = match near {
                        Some(near) => unknown.hint(near.zh, near.en),
                        None => unknown,
                    };
                    report(node.mark, &node.pointer, unknown);
                }
            }
        }
        (out, found)
    }

    /// Position in the order, lowest first. A class that is not named comes last.
    pub fn rank(&self, id: &ScenarioId) -> usize {
        let named = self.order.iter().enumerate().filter(|(_, o)| id.is_within(o));
        // The most specific entry is the one with the most parts.
        named
            .max_by_key(|(_, o)| usize::from(o.l2.is_some()) + usize::from(o.l3.is_some()))
            .map_or(usize::MAX, |(i, _)| i)
    }
}

fn seconds(text: &str) -> Option<Nanos> {
    let (value, symbol) = text.trim().split_once(' ')?;
    let unit = Unit::parse(symbol).filter(|u| u.dimension == Dimension::Time)?;
    let value: f64 = value.parse().ok()?;
    (value >= 0.0).then(|| Nanos::from_secs_f64(value * unit.to_base))
}
