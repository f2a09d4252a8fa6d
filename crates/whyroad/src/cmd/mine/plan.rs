//! Which rules a run of `whyroad mine` needs, and what it is to answer.

use anyhow::Context as _;
use std::path::Path;
use whyroad_engine::output::{Question, Searched};
use whyroad_framework::Framework;
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_mining::RuleSet;
use whyroad_mining::language::Subject;
use whyroad_mining::rule::file::{Named, bare_rule};
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::rule::text::compile_text;
use whyroad_mining::rule::{OTHER, Rule};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};
use whyroad_signals::Catalogue;

/// What to run, and what to answer.
pub(super) struct Plan {
    pub rules: RuleSet,
    pub questions: Vec<Question>,
    pub searched: Searched,
}

pub(super) type Planned = Result<(Plan, Vec<Diagnostic>), Vec<Diagnostic>>;

/// All rules are run even when one class is asked for: which episode is primary depends on all of them.
pub(super) fn of_rules(wanted: &[String], framework: &Framework, catalogue: &Catalogue) -> Planned {
    let (rules, mut found) = RuleSet::of_framework(framework, catalogue);
    let rules = rules.with_decision_moments(catalogue);
    let mut classes = Vec::new();
    for text in wanted {
        match framework.taxonomy.resolve(text) {
            Resolution::Found(id) => classes.push(id),
            Resolution::Ambiguous(ids) => return Err(vec![class_ambiguous(text, &ids)]),
            Resolution::Unknown(near) => {
                let near: Vec<String> = near.iter().map(ToString::to_string).collect();
                return Err(vec![class_not_found(text, &near)]);
            }
        }
    }
    let has_rule = |id: &ScenarioId| rules.rules.iter().any(|r| r.scenario.is_within(id));
    for id in classes.iter().filter(|id| !has_rule(id)) {
        let message = Bilingual::new(format!("{id} 还没有挖掘规则"), format!("{id} has no mining rule yet"));
        found.push(Diagnostic::warning("mine.scenario.no_rule", message));
    }
    if wanted.is_empty() {
        classes = rules.rules.iter().map(|r| r.scenario.clone()).collect();
    } else if !classes.iter().any(has_rule) {
        return Err(found);
    }
    let question = |id: ScenarioId| Question { query_id: format!("rules_{id}"), scenario: id, limit: None };
    let questions = classes.into_iter().map(question).collect();
    Ok((Plan { rules, questions, searched: Searched::Framework }, found))
}

/// A question of the user's own belongs to no class: what it finds is reported as `other`.
pub(super) fn of_text(
    text: &str,
    target: Option<&str>,
    framework: &Framework,
    catalogue: &Catalogue,
) -> anyhow::Result<Planned> {
    let class = ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None };
    let rule = match own_rule(text, target, catalogue)? {
        Ok(rule) => rule,
        Err(found) => return Ok(Err(found)),
    };
    let question = Question { query_id: "rule".to_owned(), scenario: class, limit: None };
    let (all, _) = RuleSet::of_framework(framework, catalogue);
    let rules = RuleSet { rules: vec![rule], precedence: all.precedence };
    Ok(Ok((Plan { rules, questions: vec![question], searched: Searched::Question }, vec![])))
}

/// The rule of `--rule`: a text, or a file that holds a `mining:` block.
pub(in crate::cmd) fn own_rule(
    text: &str,
    target: Option<&str>,
    catalogue: &Catalogue,
) -> anyhow::Result<Result<Rule, Vec<Diagnostic>>> {
    if !Path::new(text).extension().is_some_and(|e| e == "yaml" || e == "yml") {
        let class = ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None };
        let target = target.and_then(Subject::from_word);
        return Ok(compile_text(text, target, &class, catalogue, "--rule").map_err(|d| vec![*d]));
    }
    if target.is_some() {
        anyhow::bail!("a rule file says itself what its target is: leave out --target");
    }
    let content = std::fs::read_to_string(text).with_context(|| format!("cannot read {text}"))?;
    Ok(bare_rule(Named { name: text, text: &content }, catalogue))
}

pub(super) fn of_query(file: &Path, framework: &Framework, catalogue: &Catalogue) -> anyhow::Result<Planned> {
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let name = file.display().to_string();
    let query = match parse_query(&text, &name, framework) {
        Ok(q) => q,
        Err(found) => return Ok(Err(found)),
    };
    let rule = match compile_query(&query, catalogue, &text, &name) {
        Ok(r) => r,
        Err(found) => return Ok(Err(found)),
    };
    let stem = file.file_stem().map_or_else(|| "query".to_owned(), |s| s.to_string_lossy().into_owned());
    let question = Question {
        query_id: query.query_id.clone().unwrap_or(stem),
        scenario: query.scenario_id.clone(),
        limit: query.output_limit,
    };
    let (all, _) = RuleSet::of_framework(framework, catalogue);
    let rules = RuleSet { rules: vec![rule], precedence: all.precedence };
    Ok(Ok((Plan { rules, questions: vec![question], searched: Searched::Question }, vec![])))
}
