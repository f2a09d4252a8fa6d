//! One file of rules, checked while it is being edited: a `scenarios/<l1>/<l2>.yaml` instead of the framework's own,
//! with its cases, or a bare rule (a `mining:` block and nothing else).

use super::block::duplicates;
use super::lint::lint;
use super::origin::{Origin, SourceFile};
use super::{OTHER, Rule, RuleSet, source};
use crate::cases::CaseRunner;
use std::collections::{BTreeMap, BTreeSet};
use whyroad_framework::{Framework, yaml_text};
use whyroad_model::yaml::{self, Node, SyntaxError};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId, Severity};
use whyroad_signals::Catalog;

/// What was checked, and the errors found.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Rules that could be made of the file.
    pub rules: usize,
    /// Cases that were run.
    pub cases: usize,
    /// Faults of the rules, then cases that fail.
    pub found: Vec<Diagnostic>,
}

/// Checks `file`, and runs `cases` if there are any. `framework` holds the texts of the framework in force.
pub fn check_file(
    file: SourceFile<'_>,
    cases: Option<SourceFile<'_>>,
    framework: &BTreeMap<String, String>,
    catalog: &Catalog,
) -> Checked {
    let yaml = match yaml::parse(file.text) {
        Ok(yaml) => yaml,
        Err(e) => return Checked { found: vec![unreadable(file, &e)], ..Checked::default() },
    };
    let word = |key: &str| yaml.get(key).and_then(Node::text).map(str::to_owned);
    match (word("l1"), word("l2")) {
        (Some(l1), l2) if l2.is_some() || yaml.get("labeling").is_some() => {
            scenarios(file, cases, &ScenarioId { l1, l2, l3: None }, framework, catalog)
        }
        _ => bare(file, cases, &yaml, catalog),
    }
}

fn unreadable(file: SourceFile<'_>, e: &SyntaxError) -> Diagnostic {
    yaml_text::syntax("rule.block", file.name, file.text, &Bilingual::new("文件", "the file"), e)
}

fn scenarios(
    file: SourceFile<'_>,
    cases: Option<SourceFile<'_>>,
    class: &ScenarioId,
    framework: &BTreeMap<String, String>,
    catalog: &Catalog,
) -> Checked {
    let own = match &class.l2 {
        Some(l2) => format!("scenarios/{}/{l2}.yaml", class.l1),
        None => format!("scenarios/{}.yaml", class.l1),
    };
    let mut files = framework.clone();
    files.insert(own.clone(), file.text.to_owned());
    let (framework, mut found) = Framework::from_files(&files);
    let mut checked = Checked::default();
    let usable = framework.is_some();
    if let Some(framework) = framework {
        found.extend(lint(&framework, catalog));
        let (rules, _) = RuleSet::of_framework(&framework, catalog);
        let rules = rules.restricted_to(std::slice::from_ref(class));
        checked.rules = rules.rules.len();
        if let Some(cases) = cases {
            let has_faults = |d: &Diagnostic| {
                d.severity == Severity::Error && d.location.file.as_deref() == Some(own.as_str())
            };
            let beside = cases.name.replace(".cases.yaml", ".yaml");
            let faulty = found.iter().any(has_faults).then_some(beside).into_iter().collect();
            let runner = CaseRunner { rules: &rules, catalog, faulty: &faulty };
            let tally = runner.run(cases.name, cases.text);
            checked.cases = tally.cases.values().sum();
            checked.found = tally.failures;
        }
    }
    // Faults elsewhere in the framework are not this file's, unless they prevent it from being checked at all.
    found.retain(|d| !usable || d.location.file.as_deref() == Some(own.as_str()));
    for d in found.iter_mut().filter(|d| d.location.file.as_deref() == Some(own.as_str())) {
        d.location.file = Some(file.name.to_owned());
    }
    found.append(&mut checked.found);
    Checked { found, ..checked }
}

/// The rule of a file with a `mining:` block, or only the content of one: it belongs to no class, and its moments are
/// those of the match.
pub fn bare_rule(file: SourceFile<'_>, catalog: &Catalog) -> Result<Rule, Vec<Diagnostic>> {
    let yaml = yaml::parse(file.text).map_err(|e| vec![unreadable(file, &e)])?;
    rule_of(file, &yaml, catalog)
}

fn rule_of(file: SourceFile<'_>, yaml: &Node, catalog: &Catalog) -> Result<Rule, Vec<Diagnostic>> {
    let mining = yaml.entries().iter().find(|e| e.key == "mining");
    let (block, mark) = mining.map_or((yaml, yaml.mark), |e| (&e.node, e.mark));
    let nameless = ScenarioId { l1: OTHER.to_owned(), l2: None, l3: None };
    let mut found = Vec::new();
    duplicates(yaml.entries(), file, &mut found);
    if mining.is_some() {
        duplicates(block.entries(), file, &mut found);
    }
    let rule = source::compile(&nameless, block, None, catalog, &Origin { file, mark, expressions: &[] });
    match rule {
        Ok(rule) if found.is_empty() => Ok(rule),
        Ok(_) => Err(found),
        Err(faults) => {
            found.extend(faults);
            Err(found)
        }
    }
}

fn bare(file: SourceFile<'_>, cases: Option<SourceFile<'_>>, yaml: &Node, catalog: &Catalog) -> Checked {
    let rule = match rule_of(file, yaml, catalog) {
        Ok(rule) => rule,
        Err(found) => return Checked { found, ..Checked::default() },
    };
    let rules = RuleSet { rules: vec![rule], ..RuleSet::default() };
    let runner = CaseRunner { rules: &rules, catalog, faulty: &BTreeSet::new() };
    let tally = cases.map(|c| runner.run(c.name, c.text)).unwrap_or_default();
    Checked { rules: 1, cases: tally.cases.values().sum(), found: tally.failures }
}
