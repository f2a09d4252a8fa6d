//! One file of rules, checked as it is being written: a `scenarios/<l1>/<l2>.yaml` in the place of the framework's
//! own, with the cases beside it, or a bare rule (a `mining:` block and nothing else).

use super::lint::lint;
use super::origin::Origin;
use super::{OTHER, Rule, RuleSet, source};
use crate::cases::run_cases;
use serde_yaml_ng::Value;
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_model::{Bilingual, Diagnostic, Location, ScenarioId};
use whyroad_signals::Catalogue;

/// A text with the name that diagnostics give it.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
}

/// What was looked at, and what is wrong with it.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Rules that could be made of the file.
    pub rules: usize,
    /// Cases that were run.
    pub cases: usize,
    /// Faults of the rules, then cases that fail.
    pub found: Vec<Diagnostic>,
}

/// Checks `file`, and runs `cases` where there are some. `framework` holds the texts of the framework in force.
pub fn check_file(
    file: Named<'_>,
    cases: Option<Named<'_>>,
    framework: &BTreeMap<String, String>,
    catalogue: &Catalogue,
) -> Checked {
    let yaml: Value = match serde_yaml_ng::from_str(file.text) {
        Ok(yaml) => yaml,
        Err(e) => return Checked { found: vec![unreadable(file, &e)], ..Checked::default() },
    };
    let word = |key: &str| yaml.get(key).and_then(Value::as_str);
    if let (Some(l1), Some(l2)) = (word("l1"), word("l2")) {
        return scenarios(
            file,
            cases,
            &ScenarioId { l1: l1.to_owned(), l2: Some(l2.to_owned()), l3: None },
            framework,
            catalogue,
        );
    }
    bare(file, cases, &yaml, catalogue)
}

fn unreadable(file: Named<'_>, e: &serde_yaml_ng::Error) -> Diagnostic {
    let message = Bilingual::new(format!("文件无法读取：{e}"), format!("the file cannot be read: {e}"));
    let at = e.location();
    Diagnostic::error("rule.block", message).at(Location {
        file: Some(file.name.to_owned()),
        line: at.as_ref().map(serde_yaml_ng::Location::line),
        column: at.as_ref().map(serde_yaml_ng::Location::column),
        snippet: at.and_then(|l| file.text.lines().nth(l.line().saturating_sub(1)).map(str::to_owned)),
        span: 1,
        ..Location::default()
    })
}

fn scenarios(
    file: Named<'_>,
    cases: Option<Named<'_>>,
    class: &ScenarioId,
    framework: &BTreeMap<String, String>,
    catalogue: &Catalogue,
) -> Checked {
    let own = format!("scenarios/{}/{}.yaml", class.l1, class.l2.as_deref().unwrap_or_default());
    let mut files = framework.clone();
    files.insert(own.clone(), file.text.to_owned());
    let (framework, mut found) = Framework::from_files(&files);
    let mut checked = Checked::default();
    if let Some(framework) = framework {
        found.extend(lint(&framework, catalogue));
        let (rules, _) = RuleSet::of_framework(&framework, catalogue);
        let rules = rules.restricted_to(std::slice::from_ref(class));
        checked.rules = rules.rules.len();
        if let Some(cases) = cases {
            let tally = run_cases(cases.name, cases.text, &rules, catalogue);
            checked.cases = tally.cases.values().sum();
            checked.found = tally.failures;
        }
    }
    // What is wrong elsewhere in the framework is not this file's business.
    found.retain(|d| d.location.file.as_deref() == Some(own.as_str()));
    for d in &mut found {
        d.location.file = Some(file.name.to_owned());
    }
    found.append(&mut checked.found);
    Checked { found, ..checked }
}

/// The rule of a file that holds a `mining:` block, or only what stands in one: it belongs to no class, and its moments
/// are those of the match.
pub fn bare_rule(file: Named<'_>, catalogue: &Catalogue) -> Result<Rule, Vec<Diagnostic>> {
    let yaml = serde_yaml_ng::from_str(file.text).map_err(|e| vec![unreadable(file, &e)])?;
    rule_of(file, &yaml, catalogue)
}

fn rule_of(file: Named<'_>, yaml: &Value, catalogue: &Catalogue) -> Result<Rule, Vec<Diagnostic>> {
    let origin = Origin { file: file.name, text: file.text, line: 1, owner: String::new() };
    let nameless = ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None };
    source::compile(&nameless, yaml.get("mining").unwrap_or(yaml), None, catalogue, &origin)
}

fn bare(file: Named<'_>, cases: Option<Named<'_>>, yaml: &Value, catalogue: &Catalogue) -> Checked {
    let rule = match rule_of(file, yaml, catalogue) {
        Ok(rule) => rule,
        Err(found) => return Checked { found, ..Checked::default() },
    };
    let rules = RuleSet { rules: vec![rule], ..RuleSet::default() };
    let tally = cases.map(|c| run_cases(c.name, c.text, &rules, catalogue)).unwrap_or_default();
    Checked { rules: 1, cases: tally.cases.values().sum(), found: tally.failures }
}
