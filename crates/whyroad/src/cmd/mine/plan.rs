//! The rules that a run of `whyroad mine` needs, and its questions.

use crate::output::reason::{Reason, cannot_read, possible_values, reason, stop};
use anyhow::Context as _;
use std::path::Path;
use whyroad_engine::output::query::conditions_class;
use whyroad_engine::output::{Question, Searched};
use whyroad_framework::Framework;
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_lake::mined::MiningQuestion;
use whyroad_mining::RuleSet;
use whyroad_mining::language::Subject;
use whyroad_mining::rule::Rule;
use whyroad_mining::rule::file::bare_rule;
use whyroad_mining::rule::origin::SourceFile;
use whyroad_mining::rule::query::{compile_query, parse_query};
use whyroad_mining::rule::text::compile_text;
use whyroad_model::{Bilingual, Diagnostic, ObjectClass, ScenarioId};
use whyroad_signals::Catalog;

/// The rules to run, and the questions.
pub(super) struct Plan {
    pub rules: RuleSet,
    pub questions: Vec<Question>,
    pub searched: Searched,
    /// The question recorded in the folder.
    pub asked: MiningQuestion,
    /// The class of a query; its conditions are one of the rules.
    pub query: Option<ScenarioId>,
}

pub(super) type Planned = Result<(Plan, Vec<Diagnostic>), Vec<Diagnostic>>;

/// All rules are run even when one class is requested: which episode is primary depends on all of them.
pub(super) fn of_rules(wanted: &[String], framework: &Framework, catalog: &Catalog) -> Planned {
    let (rules, mut found) = RuleSet::of_framework(framework, catalog);
    let rules = rules.with_decision_moments(catalog);
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
    let mut scenarios = classes.clone();
    scenarios.sort();
    scenarios.dedup();
    if wanted.is_empty() {
        classes = rules.rules.iter().map(|r| r.scenario.clone()).collect();
    } else if !classes.iter().any(has_rule) {
        return Err(found);
    }
    let question = |id: ScenarioId| Question { query_id: format!("rules_{id}"), scenario: id, limit: None };
    let questions = classes.into_iter().map(question).collect();
    let asked = MiningQuestion::Framework { scenarios };
    Ok((Plan { rules, questions, searched: Searched::Framework, asked, query: None }, found))
}

/// A custom rule from the command line.
pub(in crate::cmd) struct CustomRule<'a> {
    /// A text, or the path of a file that holds a `mining:` block.
    pub rule: &'a str,
    pub name: Option<&'a str>,
    pub target: Option<&'a str>,
}

/// A custom rule belongs to no class of the taxonomy: its episodes have the class `custom.<name>`.
pub(super) fn of_custom(
    custom: &CustomRule<'_>,
    framework: &Framework,
    catalog: &Catalog,
) -> anyhow::Result<Planned> {
    let (rule, text) = match custom.compile(catalog)? {
        Ok(compiled) => compiled,
        Err(found) => return Ok(Err(found)),
    };
    let scenario = rule.scenario.clone();
    let question = Question { query_id: custom.name(), scenario: scenario.clone(), limit: None };
    let asked = MiningQuestion::Rule { scenario, rule: text, target: custom.target.map(str::to_owned) };
    let (all, _) = RuleSet::of_framework(framework, catalog);
    let rules = RuleSet { rules: vec![rule], ..all };
    let plan = Plan { rules, questions: vec![question], searched: Searched::Question, asked, query: None };
    Ok(Ok((plan, vec![])))
}

/// A rule and its text.
type Compiled = (Rule, String);

impl CustomRule<'_> {
    fn is_file(&self) -> bool {
        Path::new(self.rule).extension().is_some_and(|e| e == "yaml" || e == "yml")
    }

    /// Its name: the given one, else the stem of its file, else `rule`.
    fn name(&self) -> String {
        match (self.name, Path::new(self.rule).file_stem()) {
            (Some(name), _) => name.to_owned(),
            (None, Some(stem)) if self.is_file() => identifier(&stem.to_string_lossy()),
            _ => "rule".to_owned(),
        }
    }

    /// Compiles it.
    pub(in crate::cmd) fn compile(
        &self,
        catalog: &Catalog,
    ) -> anyhow::Result<Result<Compiled, Vec<Diagnostic>>> {
        let scenario = ScenarioId::custom(&self.name());
        if !self.is_file() {
            let target = self.target.and_then(Subject::from_word);
            let rule = compile_text(self.rule, target, &scenario, catalog, "--rule");
            return Ok(rule.map(|rule| (rule, self.rule.to_owned())).map_err(|d| vec![*d]));
        }
        if self.target.is_some() {
            return Err(stop(
                "规则文件自带目标，请去掉 --target",
                "a rule file states its target itself: leave out --target",
            ));
        }
        let content = std::fs::read_to_string(self.rule).with_context(|| cannot_read(self.rule))?;
        let rule = bare_rule(SourceFile { name: self.rule, text: &content }, catalog);
        Ok(rule.map(|rule| (Rule { scenario, ..rule }, content)))
    }
}

/// `text` as an identifier: lower case, `_` in place of every other character.
fn identifier(text: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = text.chars().map(letter).collect();
    if name.starts_with(|c: char| c.is_ascii_lowercase()) { name } else { format!("rule_{name}") }
}

/// A kind of target: one of the groups, or a class of objects.
pub(in crate::cmd) fn target_kind(text: &str) -> Result<String, Reason> {
    let all =
        ["vehicle", "large_vehicle", "vru", "any"].into_iter().chain(ObjectClass::ALL.iter().map(|c| c.id()));
    Subject::from_word(text).map(|_| text.to_owned()).ok_or_else(|| possible_values(&all.collect::<Vec<_>>()))
}

/// A name that can be part of a class's id.
pub(in crate::cmd) fn rule_name(text: &str) -> Result<String, Reason> {
    (identifier(text) == text && text.len() <= 64).then(|| text.to_owned()).ok_or_else(|| {
        reason(
            "名称由小写字母、数字和 '_' 组成，以字母开头",
            "a name has lower-case letters, digits and '_', and begins with a letter",
        )
    })
}

pub(super) fn of_query(file: &Path, framework: &Framework, catalog: &Catalog) -> anyhow::Result<Planned> {
    let text = std::fs::read_to_string(file).with_context(|| cannot_read(file.display()))?;
    // `validate` accepts it too.
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let name = file.display().to_string();
    let query = match parse_query(text, &name, framework) {
        Ok(q) => q,
        Err(found) => return Ok(Err(found)),
    };
    let conditions = match compile_query(&query, catalog, text, &name) {
        Ok(r) => r,
        Err(found) => return Ok(Err(found)),
    };
    // The class's own rules define its episodes, all rules together decide which are primary; the conditions select
    // among them.
    let (mut rules, mut found) = RuleSet::of_framework(framework, catalog);
    if !rules.rules.iter().any(|r| r.scenario.is_within(&query.scenario_id)) {
        let id = &query.scenario_id;
        let message = Bilingual::new(format!("{id} 还没有挖掘规则"), format!("{id} has no mining rule yet"));
        found.push(Diagnostic::warning("mine.scenario.no_rule", message));
        return Ok(Err(found));
    }
    rules.rules.extend(conditions.map(|rule| Rule { scenario: conditions_class(), ..rule }));
    let stem = file.file_stem().map_or_else(|| "query".to_owned(), |s| s.to_string_lossy().into_owned());
    let question = Question {
        query_id: query.query_id.clone().unwrap_or(stem),
        scenario: query.scenario_id.clone(),
        limit: query.output_limit,
    };
    let asked = MiningQuestion::Query { query: serde_json::from_str(text)? };
    let class = query.scenario_id.clone();
    let plan =
        Plan { rules, questions: vec![question], searched: Searched::Question, asked, query: Some(class) };
    Ok(Ok((plan, found)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_custom_rule_is_named_by_its_option_its_file_or_not_at_all() {
        let name = |rule, name| CustomRule { rule, name, target: None }.name();
        assert_eq!(name("rules/Late-Brake.yaml", None), "late_brake");
        assert_eq!(name("2slow.yml", None), "rule_2slow");
        assert_eq!(name("rules/Late-Brake.yaml", Some("x")), "x");
        assert_eq!(name("ego.speed < 1 m/s", None), "rule");
        assert!(rule_name("late_brake2").is_ok());
        for bad in ["", "2x", "Late", "a.b", "a b", "迟"] {
            assert!(rule_name(bad).is_err(), "{bad}");
        }
    }
}
