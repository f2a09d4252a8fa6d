//! Checks everything in a framework that is written in the rule language: rules, order of precedence, and the
//! moments of labeling specs, also of classes that have no rule yet. Mining needs only the rules ([`RuleSet`]).

use super::RuleSet;
use super::origin::SourceFile;
use super::source::inherit;
use crate::language::parse::parse;
use crate::language::syntax::{ExprKind, Quantity};
use crate::language::{Checker, Fault};
use whyroad_framework::{ExpressionSource, Framework};
use whyroad_model::{Bilingual, Diagnostic, ScenarioId};
use whyroad_signals::Catalog;

/// All errors, in the order of the files.
pub fn lint(framework: &Framework, catalog: &Catalog) -> Vec<Diagnostic> {
    let (rules, mut found) = RuleSet::of_framework(framework, catalog);
    found.extend(unnamed(&rules, framework));
    // A rule takes over the moments of its labeling spec; those are checked below where they are written, once each.
    found.retain(|d| !d.location.pointer.as_ref().is_some_and(|p| p.contains("/labeling/")));
    for source in &framework.expressions {
        found.extend(moment(source, framework, catalog));
    }
    found.sort_by(|a, b| {
        let key = |d: &Diagnostic| (d.location.file.clone(), d.location.line, d.location.column);
        key(a).cmp(&key(b))
    });
    found
}

/// A note for each definition without a name that is displayed at length: once where it is written.
fn unnamed(rules: &RuleSet, framework: &Framework) -> Vec<Diagnostic> {
    let mut found: Vec<Diagnostic> = Vec::new();
    for rule in &rules.rules {
        let l2 = ScenarioId { l3: None, ..rule.scenario.clone() };
        for (name, words) in &rule.lengthy {
            let entry = |class: &ScenarioId| {
                let source = framework.rule(class)?;
                let define = source.rule.get("define")?.entries();
                let entry = define.iter().find(|e| e.key == *name)?;
                Some((source, entry.mark, entry.node.pointer.clone()))
            };
            let written = entry(&rule.scenario).or_else(|| entry(&l2));
            let Some((source, mark, pointer)) = written else { continue };
            let file = SourceFile { name: &source.file, text: &source.text };
            let message = Bilingual::new(
                format!("'{name}' 没有名称，界面与报告中显示为：{}", words.zh),
                format!("'{name}' has no name; people are shown: {}", words.en),
            );
            let hint = Bilingual::new(
                format!("在 names 中写明：{name}: {{ zh: …, en: … }}"),
                format!("name it under `names`: {name}: {{ zh: ..., en: ... }}"),
            );
            let at = file.location(mark, &pointer);
            if found.iter().all(|d| d.location.pointer != at.pointer || d.location.file != at.file) {
                found.push(Diagnostic::note("rule.words", message).with_hint(hint).at(at));
            }
        }
    }
    found
}

fn moment(source: &ExpressionSource, framework: &Framework, catalog: &Catalog) -> Vec<Diagnostic> {
    let mut checker = Checker::new(catalog);
    names_of_the_rule(&source.class, framework, &mut checker);
    let text = source.expression.text().unwrap_or_default();
    let faults = match parse(text) {
        Ok(expr) => match checker.moment(&expr) {
            Ok(_) => vec![],
            Err(first) => checker.every_fault_of_moment(&expr, first),
        },
        Err(fault) => vec![fault],
    };
    let file = SourceFile { name: &source.file, text: &source.source };
    // A signal whose entry in the catalog has an error is reported there.
    let marked = |f: &Fault| text.get(f.span.start..f.span.end).unwrap_or_default();
    let is_own = |f: &Fault| f.code != "rule.signal.unknown" || !catalog.lacks(marked(f));
    faults.into_iter().filter(is_own).map(|fault| file.diagnose(&source.expression, fault)).collect()
}

/// A moment may use the parameters and definitions of the rule that it times. Errors in these are reported for the
/// rule.
fn names_of_the_rule(class: &ScenarioId, framework: &Framework, checker: &mut Checker<'_>) {
    let l2 = ScenarioId { l3: None, ..class.clone() };
    let upper = framework.rule(&l2).map(|r| &r.rule);
    let own = framework.rule(class).map(|r| &r.rule);
    let Some(block) =
        own.map(|own| inherit(upper.filter(|_| class.l3.is_some()), own)).or_else(|| upper.cloned())
    else {
        return;
    };
    let of = |key: &str| block.get(key).map_or(&[][..], |n| n.entries());
    let target = block.get("target").is_some_and(|n| n.text().is_some());
    checker.roles = super::roles::names(target, of("roles"));
    for parameter in of("parameters") {
        let value = parameter.node.get("value").and_then(|n| n.text()).and_then(|t| parse(t).ok());
        if let Some(q) = value.and_then(|e| quantity(e.kind)) {
            checker.parameters.insert(parameter.key.clone(), q);
        }
    }
    for definition in of("define") {
        if let Some(text) = definition.node.text() {
            // Faults in it are reported where the rule is read.
            let _ = checker.define(&definition.key, text);
        }
    }
}

/// A number with its unit, as `-0.5 m/s2`.
fn quantity(value: ExprKind) -> Option<Quantity> {
    match value {
        ExprKind::Number(q) => Some(q),
        ExprKind::Negate(of) => quantity(of.kind).map(|q| Quantity { value: -q.value, ..q }),
        _ => None,
    }
}
