//! Everything of a framework that is written in the rule language, checked: rules, order of precedence, and the
//! moments of labelling specs, also of classes that have no rule yet. Mining needs only the rules ([`RuleSet`]).

use super::RuleSet;
use super::block::scalar;
use super::origin::Origin;
use super::source::inherit;
use crate::language::Checker;
use crate::language::parse::parse;
use crate::language::syntax::{ExprKind, Quantity};
use serde_yaml_ng::{Mapping, Value};
use whyroad_framework::{ExpressionSource, Framework};
use whyroad_model::{Diagnostic, ScenarioId};
use whyroad_signals::Catalogue;

/// All that is wrong, in the order of the files.
pub fn lint(framework: &Framework, catalogue: &Catalogue) -> Vec<Diagnostic> {
    let (_, mut found) = RuleSet::of_framework(framework, catalogue);
    // A rule takes over the moments of its labelling spec; those are checked below where they are written, once each.
    found.retain(|d| !d.location.pointer.as_ref().is_some_and(|p| p.contains("/labeling/")));
    for source in &framework.expressions {
        found.extend(moment(source, framework, catalogue));
    }
    found.sort_by(|a, b| {
        let key = |d: &Diagnostic| (d.location.file.clone(), d.location.line, d.location.column);
        key(a).cmp(&key(b))
    });
    found
}

fn moment(source: &ExpressionSource, framework: &Framework, catalogue: &Catalogue) -> Option<Diagnostic> {
    let mut checker = Checker::new(catalogue);
    names_of_the_rule(&source.class, framework, &mut checker);
    let fault = parse(&source.expression).and_then(|expr| checker.moment(&expr)).err()?;
    let origin =
        Origin { file: &source.file, text: &source.text, line: source.line, owner: source.pointer.clone() };
    Some(origin.diagnose("", &source.expression, fault))
}

/// A moment may use the parameters and definitions of the rule that it times. What is wrong with these is said of the rule.
fn names_of_the_rule(class: &ScenarioId, framework: &Framework, checker: &mut Checker<'_>) {
    let l2 = ScenarioId { l3: None, ..class.clone() };
    let upper = framework.rule(&l2).map(|r| &r.rule);
    let own = framework.rule(class).map(|r| &r.rule);
    let Some(block) = own.map(|own| inherit(upper.filter(|_| class.l3.is_some()), own)).or(upper.cloned())
    else {
        return;
    };
    let roles = block.get("roles").and_then(Value::as_mapping).cloned().unwrap_or_default();
    checker.roles = super::roles::names(block.get("target").and_then(Value::as_str), &roles);
    let names = |key: &str| block.get(key).and_then(Value::as_mapping).cloned().unwrap_or_default();
    let text = |value: &Value| scalar(value).and_then(|t| parse(&t).ok());
    let (parameters, definitions): (Mapping, Mapping) = (names("parameters"), names("define"));
    for (name, parameter) in &parameters {
        let value = parameter.get("value").and_then(text).and_then(|e| quantity(e.kind));
        if let (Some(name), Some(q)) = (name.as_str(), value) {
            checker.parameters.insert(name.to_owned(), q);
        }
    }
    for (name, definition) in &definitions {
        if let (Some(name), Some(text)) = (name.as_str(), scalar(definition)) {
            // What is wrong with it is said where the rule is read.
            let _ = checker.define(name, &text);
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
