//! A `mining_query` (DATA_FORMAT.md 5.1) with the clauses that we add (`any`, `all`, `not`, `temporal`, `rule`).
//! whyroad-mining, which knows signals and rules, checks those.

use super::values::{out_of_range, scenario_id};
use crate::check::class_index::ClassIndex;
use crate::check::finding::{Finding, Sink, Words};
use crate::check::json::{JsonKind, Node};
use crate::check::slot::Slot;
use crate::check::walk::{Object, Walk};
use crate::taxonomy::did_you_mean;
use whyroad_model::Severity;
use whyroad_model::units::UNITS;

const OPERATORS: &[&str] = &[">", ">=", "<", "<=", "==", "!=", "in"];

/// The keys that identify the kind of a clause; one with none of them is a comparison.
const CLAUSES: &[&str] = &["any", "all", "not", "temporal", "rule"];
/// The keys of a comparison.
const COMPARISON: &[&str] = &["field", "operator", "value"];

/// Operators over time, and whether they need their time, may have one, or have none.
const TEMPORAL: &[(&str, Operands, Seconds)] = &[
    ("for", Operands::One, Seconds::Needed),
    ("within", Operands::One, Seconds::Needed),
    ("previously", Operands::One, Seconds::Allowed),
    ("rises", Operands::One, Seconds::None),
    ("falls", Operands::One, Seconds::None),
    ("then", Operands::Two, Seconds::Needed),
    ("since", Operands::Two, Seconds::Allowed),
    ("until", Operands::Two, Seconds::Allowed),
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Operands {
    /// `condition`.
    One,
    /// `first` and `second`.
    Two,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Seconds {
    Needed,
    Allowed,
    None,
}

pub(super) fn query<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, classes: &ClassIndex) {
    let Some(mut o) = walk.object(node, "/mining_query".into()) else { return };
    let (n, at) = (o.get("query_id"), o.at("query_id"));
    walk.text(n, &at);
    let n = walk.need(&mut o, "scenario_id");
    // Mining accepts a short id, too.
    let is_short = |n: &Node<'_>| matches!(&n.kind, JsonKind::Text(text) if classes.is_short_id(text));
    if !n.is_some_and(is_short) {
        scenario_id(walk, n, "/mining_query/scenario_id", classes);
    }
    let (n, at) = (walk.need(&mut o, "conditions"), o.at("conditions"));
    // Without conditions, a query matches all of its class.
    if let Slot::Is(items) = walk.list(n, &at)
        && !items.is_empty()
    {
        clauses(walk, items, &at);
    }
    if let Some(n) = o.get("time_constraints") {
        time_constraints(walk, n);
    }
    let (n, at) = (o.get("output_limit"), o.at("output_limit"));
    walk.frame(n, &at);
    // A misspelled field of a query would silently change the question.
    walk.close(o, Severity::Error);
}

/// A list of clauses; an empty one has no meaning.
fn clauses<'d>(walk: &mut Walk<'d>, items: &'d [Node<'d>], at: &str) {
    if items.is_empty() {
        walk.report(Finding::error("message.query.clause", at.to_owned()), &|| {
            Words::new("没有条件", "no conditions are given")
        });
    }
    for (i, item) in items.iter().enumerate() {
        clause(walk, item, format!("{at}/{i}"));
    }
}

/// One clause. The form of its parts bounds the depth: JSON nested deeper than 128 is not read.
fn clause<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, pointer: String) {
    let there = |keys: &[&'static str]| -> Vec<&'static str> {
        let entries = node.entries().unwrap_or_default();
        keys.iter().copied().filter(|k| entries.iter().any(|e| e.key == *k)).collect()
    };
    let (kinds, plain) = (there(CLAUSES), there(COMPARISON));
    let mut said = kinds.clone();
    said.extend(plain.first());
    if said.len() > 1 {
        let said = said.join(" + ");
        walk.report(Finding::error("message.query.clause", pointer), &|| {
            Words::new(
                format!("一个条件只能是一种：此处同时有 {said}"),
                format!("a condition is of one kind; this one has {said}"),
            )
            .hint(
                "用 {\"all\": [..]} 或 {\"any\": [..]} 组合多个条件",
                "combine several with {\"all\": [..]} or {\"any\": [..]}",
            )
        });
        return;
    }
    let Some(kind) = kinds.first().copied() else {
        comparison(walk, node, pointer);
        return;
    };
    let Some(mut o) = walk.object(node, pointer) else { return };
    let (n, at) = (walk.need(&mut o, kind), o.at(kind));
    match kind {
        "any" | "all" => {
            if let Slot::Is(items) = walk.list(n, &at) {
                clauses(walk, items, &at);
            }
        }
        "not" => {
            if let Some(n) = n {
                clause(walk, n, at);
            }
        }
        "rule" => {
            walk.text(n, &at);
        }
        _ => {
            let operator = walk.text(n, &at).get();
            temporal(walk, &mut o, operator, at);
        }
    }
    walk.close(o, Severity::Error);
}

fn temporal<'d>(walk: &mut Walk<'d>, o: &mut Object<'d>, operator: Option<&str>, at: String) {
    let known = operator.and_then(|word| TEMPORAL.iter().find(|(name, ..)| *name == word));
    if let (Some(word), None) = (operator, known) {
        walk.report(Finding::error("message.enum", at), &|| {
            let words = Words::new(
                format!("'{word}' 不是时序运算"),
                format!("'{word}' is not an operator over time"),
            );
            let names: Vec<&str> = TEMPORAL.iter().map(|(name, ..)| *name).collect();
            match did_you_mean(word, names.iter().copied()) {
                Some(m) => words.meant(m),
                None => words.one_of(&names.join(" "), &names.join(" ")),
            }
        });
    }
    let (operands, seconds) = match known {
        Some((_, operands, seconds)) => (Some(*operands), *seconds),
        None => (None, Seconds::Allowed),
    };
    let at = o.at("seconds");
    let n = match seconds {
        Seconds::Needed => walk.need(o, "seconds"),
        Seconds::Allowed => o.get("seconds"),
        Seconds::None => None,
    };
    if let Some(v) = walk.number(n, &at).get().filter(|v| *v < 0.0) {
        out_of_range(walk, &at, &v.to_string(), "不小于 0", "0 or more");
    }
    // Of an unknown operator, every operand is checked.
    let keys: &[&'static str] = match operands {
        Some(Operands::One) => &["condition"],
        Some(Operands::Two) => &["first", "second"],
        None => &["condition", "first", "second"],
    };
    for key in keys.iter().copied() {
        let (n, at) =
            if operands.is_some() { (walk.need(o, key), o.at(key)) } else { (o.get(key), o.at(key)) };
        if let Some(n) = n {
            clause(walk, n, at);
        }
    }
}

fn comparison<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>, pointer: String) {
    let Some(mut o) = walk.object(node, pointer) else { return };
    let (n, at) = (walk.need(&mut o, "field"), o.at("field"));
    walk.text(n, &at);
    let (n, at) = (walk.need(&mut o, "operator"), o.at("operator"));
    let operator = walk.text(n, &at).get();
    if let Some(op) = operator.filter(|op| !OPERATORS.contains(op)) {
        walk.report(Finding::error("message.enum", at), &|| {
            let words = Words::new(format!("'{op}' 不是比较符"), format!("'{op}' is not an operator"));
            let meant = match op {
                "=" | "===" | "eq" => Some("=="),
                "≥" | "=>" => Some(">="),
                "≤" | "=<" => Some("<="),
                "<>" | "≠" => Some("!="),
                _ => None,
            };
            match meant {
                Some(m) => words.meant(m),
                None => words.one_of(&OPERATORS.join(" "), &OPERATORS.join(" ")),
            }
        });
    }
    let (n, at) = (walk.need(&mut o, "value"), o.at("value"));
    if let Some(n) = n {
        let plain =
            |n: &Node<'_>| matches!(n.kind, JsonKind::Number(_) | JsonKind::Text(_) | JsonKind::Flag(_));
        let fits = match (&n.kind, operator) {
            (JsonKind::List(items), Some("in") | None) => items.iter().all(plain),
            (JsonKind::List(_), _) | (JsonKind::Map(_) | JsonKind::Null, _) => false,
            (JsonKind::Text(_) | JsonKind::Flag(_), Some(">" | ">=" | "<" | "<=")) => false,
            (_, Some("in")) => false,
            _ => true,
        };
        if !fits {
            let op = operator.unwrap_or_default();
            walk.report(Finding::error("message.query.value", at), &|| {
                Words::new(
                    format!("该值不能用于比较符 '{op}'"),
                    format!("this value does not fit the operator '{op}'"),
                )
                .hint("大小比较用数字，in 用列表", "numbers for < and >, a list for in")
            });
        }
    }
    let (n, at) = (o.get("unit"), o.at("unit"));
    if let Some(unit) = walk.any_text(n, &at).get().filter(|u| UNITS.iter().all(|k| k.symbol != *u)) {
        walk.report(Finding::error("message.query.unit", at), &|| {
            let words = Words::new(format!("未知单位 '{unit}'"), format!("unknown unit '{unit}'"));
            let symbols: Vec<&str> = UNITS.iter().map(|u| u.symbol).filter(|s| !s.is_empty()).collect();
            match did_you_mean(&unit.to_lowercase(), symbols.iter().copied()) {
                Some(m) => words.meant(m),
                None => words.one_of(&symbols.join("、"), &symbols.join(", ")),
            }
        });
    }
    walk.close(o, Severity::Error);
}

fn time_constraints<'d>(walk: &mut Walk<'d>, node: &'d Node<'d>) {
    let Some(mut o) = walk.object(node, "/mining_query/time_constraints".into()) else { return };
    let mut seconds = |walk: &mut Walk<'d>, key| {
        let (n, at) = (o.get(key), o.at(key));
        let v = walk.number(n, &at).get()?;
        if v < 0.0 {
            out_of_range(walk, &at, &v.to_string(), "不小于 0", "0 or more");
        }
        Some((v, at))
    };
    let (min, max) = (seconds(walk, "condition_duration_min"), seconds(walk, "condition_duration_max"));
    if let (Some((min, _)), Some((max, at))) = (min, max)
        && min > max
    {
        walk.report(Finding::error("message.order", at), &|| {
            Words::new(
                format!("最长 {max} s 短于最短 {min} s"),
                format!("the maximum {max} s is less than the minimum {min} s"),
            )
        });
    }
    walk.close(o, Severity::Error);
}
