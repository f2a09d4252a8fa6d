//! A JSON `mining_query` (DATA_FORMAT.md 5.1) to a [`Rule`]: the same program that a rule file makes.

mod clause;
mod source;

use super::{Listed, PartPlace, Rule, RuleParts, TARGET, Timing};
use crate::language::parse::too_large;
use crate::language::program::{Op, ValueKind};
use crate::language::syntax::Span;
use crate::language::{Checker, Fault};
use clause::Reader;
use source::QueryText;
use whyroad_framework::Framework;
use whyroad_framework::check::{ClassIndex, MessageKind, check_message};
use whyroad_framework::taxonomy::{Resolution, class_ambiguous, class_not_found};
use whyroad_model::messages::{MiningQuery, MiningQueryMessage};
use whyroad_model::{Bilingual, Diagnostic, Location, Nanos, Severity};
use whyroad_signals::Catalog;

/// The query in a JSON text, its class resolved. `file` is its name in diagnostics.
pub fn parse_query(text: &str, file: &str, framework: &Framework) -> Result<MiningQuery, Vec<Diagnostic>> {
    let message: MiningQueryMessage =
        serde_json::from_str(text).map_err(|e| unreadable(text, file, framework, &e))?;
    let mut query = message.mining_query;
    let written = query.scenario_id.to_string();
    let problem = match framework.taxonomy.resolve(&written) {
        Resolution::Found(id) => {
            query.scenario_id = id;
            return Ok(query);
        }
        Resolution::Ambiguous(ids) => class_ambiguous(&written, &ids),
        Resolution::Unknown(near) => {
            let near: Vec<String> = near.iter().map(ToString::to_string).collect();
            class_not_found(&written, &near)
        }
    };
    let location = QueryText::new(text, file).location("/mining_query/scenario_id");
    Err(vec![Diagnostic { code: "mine.query.scenario", ..problem }.at(location)])
}

/// All errors in the form of a query, as the checker of messages reports them.
fn unreadable(text: &str, file: &str, framework: &Framework, e: &serde_json::Error) -> Vec<Diagnostic> {
    let mut found = check_message(text, MessageKind::MiningQuery, &ClassIndex::new(framework));
    // A class may be given by a short name here.
    found.retain(|d| d.severity == Severity::Error && d.code != "label.scenario.unknown");
    for d in &mut found {
        d.location.file = Some(file.to_owned());
        // For this checker, a text that is not JSON is an invalid label.
        if d.code == "label.json.syntax" {
            d.code = "mine.query.syntax";
        }
    }
    if found.is_empty() {
        let place = Location {
            file: Some(file.to_owned()),
            line: Some(e.line()),
            column: Some(e.column().max(1)),
            snippet: text.lines().nth(e.line().saturating_sub(1)).map(str::to_owned),
            span: 1,
            ..Location::default()
        };
        let said = Bilingual::new(format!("查询无法读取：{e}"), format!("the query cannot be read: {e}"));
        found.push(Diagnostic::error("mine.query.syntax", said).at(place));
    }
    found
}

/// The rule that the conditions of a query make; `None` where it has none, and so matches all of its class. All
/// conditions hold at once; how long is bounded by its time constraints; a
/// break of a single frame ends a match.
pub fn compile_query(
    query: &MiningQuery,
    catalog: &Catalog,
    text: &str,
    file: &str,
) -> Result<Option<Rule>, Vec<Diagnostic>> {
    let mut checker = Checker::new(catalog);
    let mut found = Vec::new();
    let mut conditions = Vec::new();
    let mut described = RuleParts::default();
    let source = QueryText::new(text, file);
    let mut reader = Reader { checker: &mut checker, catalog, source: &source, found: Vec::new() };
    for (i, clause) in query.conditions.iter().enumerate() {
        let pointer = format!("/mining_query/conditions/{i}");
        let Some(expr) = reader.clause(clause, &pointer) else { continue };
        let sane = if reader.checker.extent(&expr).is_sane() { Ok(()) } else { Err(too_large(expr.span)) };
        let whole = sane.and_then(|()| reader.checker.condition(&expr)).and_then(|id| {
            described.add(reader.checker, &expr, PartPlace::When)?;
            Ok(id)
        });
        match whole {
            Ok(id) => conditions.push(id),
            // Each part is valid by itself: the combination is wrong.
            Err(fault) => reader.found.push(fault.at(source.location(&pointer))),
        }
    }
    found.append(&mut reader.found);
    if let Err(fault) = checker.possible_together(&conditions, Span::default()) {
        found.push(fault.at(source.location("/mining_query/conditions")));
    }
    let bounds = query.time_constraints.clone().unwrap_or_default();
    let (least, most) = (bounds.condition_duration_min, bounds.condition_duration_max);
    let mut refuse = |name: &str, zh: String, en: String| {
        let pointer = format!("/mining_query/time_constraints/{name}");
        let fault = Fault::new("mine.query.syntax", Span::default(), zh, en);
        found.push(fault.at(source.location(&pointer)));
    };
    for (name, bound) in [("condition_duration_min", least), ("condition_duration_max", most)] {
        if bound.is_some_and(|s| !(s.is_finite() && s >= 0.0)) {
            refuse(
                name,
                format!("{name} 应为非负的秒数"),
                format!("{name} is a number of seconds, zero or more"),
            );
        }
    }
    if let (Some(least), Some(most)) = (least, most)
        && least > most
    {
        refuse(
            "condition_duration_max",
            format!("最长 {most} s 短于最短 {least} s，不会有匹配"),
            format!("the longest, {most} s, is shorter than the shortest, {least} s: nothing can match"),
        );
    }
    if !found.is_empty() {
        return Err(found);
    }
    if query.conditions.is_empty() {
        return Ok(None);
    }
    let when = checker.program.add(Op::And(conditions.clone()), ValueKind::Condition);
    let of_target = conditions.iter().any(|id| checker.is_of_target(*id));
    let any = of_target.then_some(crate::language::Subject::Any);
    Ok(Some(Rule {
        scenario: query.scenario_id.clone(),
        subject: checker.subject.or(any),
        target_role: TARGET.to_owned(),
        second: None,
        when,
        require: vec![],
        response: None,
        atoms: described.atoms,
        parts: described.parts,
        listed: Listed::All,
        min_duration: Nanos::from_secs_f64(bounds.condition_duration_min.unwrap_or(0.0)),
        max_duration: bounds.condition_duration_max.map(Nanos::from_secs_f64),
        merge_gap: Nanos::default(),
        lengthy: checker.lengthy,
        timing: Timing::of_match(),
        program: checker.program,
    }))
}
