//! A clause of a query to an expression of the rule language. Each comparison and each rule text is checked by itself,
//! so that a fault is shown at the value that has to be changed.

use super::source::QueryText;
use crate::language::syntax::{CompareOp, Expr, ExprKind, Quantity, Span};
use crate::language::token::unknown_unit;
use crate::language::{Checker, Fault, parse};
use serde_json::Value;
use whyroad_model::Diagnostic;
use whyroad_model::messages::{
    OneOperator, OverTime, QueryClause, QueryCondition, QueryOperator, TwoOperator, TwoOverTime,
};
use whyroad_model::units::{UNITS, Unit};
use whyroad_signals::{Catalog, SignalKind};

/// Reads the clauses of one query in the order of its text.
pub(super) struct Reader<'a, 'c> {
    pub checker: &'a mut Checker<'c>,
    pub catalog: &'c Catalog,
    /// The query's JSON.
    pub source: &'a QueryText<'a>,
    pub found: Vec<Diagnostic>,
}

impl Reader<'_, '_> {
    /// The expression of a clause; `None` when a part of it has been reported.
    pub fn clause(&mut self, clause: &QueryClause, pointer: &str) -> Option<Expr> {
        let kind = match clause {
            QueryClause::Comparison(c) => return self.comparison(c, pointer),
            QueryClause::Rule(r) => return self.rule(&r.rule, &format!("{pointer}/rule")),
            QueryClause::Any(any) => ExprKind::Or(self.clauses(&any.any, &format!("{pointer}/any"))?),
            QueryClause::All(all) => ExprKind::And(self.clauses(&all.all, &format!("{pointer}/all"))?),
            QueryClause::Not(not) => ExprKind::Not(self.boxed(&not.not, &format!("{pointer}/not"))?),
            QueryClause::OverTime(over) => self.over_time(over, pointer)?,
            QueryClause::TwoOverTime(over) => self.two_over_time(over, pointer)?,
        };
        Some(Expr { kind, span: Span::default() })
    }

    fn boxed(&mut self, clause: &QueryClause, pointer: &str) -> Option<Box<Expr>> {
        self.clause(clause, pointer).map(Box::new)
    }

    fn clauses(&mut self, all: &[QueryClause], pointer: &str) -> Option<Vec<Expr>> {
        // Every one is checked, also after a wrong one.
        let each: Vec<Option<Expr>> =
            all.iter().enumerate().map(|(i, c)| self.clause(c, &format!("{pointer}/{i}"))).collect();
        if all.is_empty() {
            let fault =
                Fault::new("mine.query.syntax", Span::default(), "没有条件", "no conditions are given");
            self.found.push(fault.at(self.source.location(pointer)));
            return None;
        }
        each.into_iter().collect()
    }

    fn over_time(&mut self, over: &OverTime, pointer: &str) -> Option<ExprKind> {
        let of = self.boxed(&over.condition, &format!("{pointer}/condition"))?;
        let time = over.seconds.map(seconds);
        let call = |name: &str, time: Option<Expr>| {
            ExprKind::Call(name.to_owned(), std::iter::once(*of.clone()).chain(time).collect())
        };
        Some(match (over.temporal, time) {
            (OneOperator::For, Some(time)) => ExprKind::For(of, Box::new(time)),
            (OneOperator::Within, Some(time)) => ExprKind::Within(of, Box::new(time)),
            (OneOperator::Previously, time) => call("previously", time),
            (OneOperator::Rises, _) => call("rises", None),
            (OneOperator::Falls, _) => call("falls", None),
            // Refused when the message was read.
            (OneOperator::For | OneOperator::Within, None) => return None,
        })
    }

    fn two_over_time(&mut self, over: &TwoOverTime, pointer: &str) -> Option<ExprKind> {
        let first = self.boxed(&over.first, &format!("{pointer}/first"));
        let second = self.boxed(&over.second, &format!("{pointer}/second"));
        let (first, second) = (first?, second?);
        let time = over.seconds.map(|s| Box::new(seconds(s)));
        Some(match over.temporal {
            TwoOperator::Then => ExprKind::Then(first, second, time?),
            TwoOperator::Since => ExprKind::Since(first, second, time),
            TwoOperator::Until => ExprKind::Until(first, second, time),
        })
    }

    fn rule(&mut self, rule: &str, pointer: &str) -> Option<Expr> {
        let expr = match parse::parse(rule) {
            Ok(expr) => expr,
            Err(fault) => return self.faulty(pointer, vec![fault]),
        };
        match self.checker.condition(&expr) {
            Ok(_) => Some(expr),
            Err(first) => {
                let all = self.checker.every_fault(&expr, first);
                self.faulty(pointer, all)
            }
        }
    }

    fn faulty(&mut self, pointer: &str, faults: Vec<Fault>) -> Option<Expr> {
        for fault in faults {
            let part = fault.span.start..fault.span.end;
            self.found.push(fault.at(self.source.part(pointer, part)));
        }
        None
    }

    fn comparison(&mut self, c: &QueryCondition, pointer: &str) -> Option<Expr> {
        let checked = expression(c, self.catalog).and_then(|expr| {
            self.checker.condition(&expr).map_err(|f| (ComparisonPart::of(&f), f))?;
            Ok(expr)
        });
        let (part, fault) = match checked {
            Ok(expr) => return Some(expr),
            Err(at) => at,
        };
        let location = match part {
            ComparisonPart::Whole => self.source.comparison(pointer),
            ComparisonPart::Field => self.source.location(&format!("{pointer}/field")),
            ComparisonPart::Value => self.source.location(&format!("{pointer}/value")),
            ComparisonPart::Unit => self.source.location(&format!("{pointer}/unit")),
        };
        self.found.push(fault.at(location));
        None
    }
}

fn seconds(value: f64) -> Expr {
    let unit = Unit::parse("s").unwrap_or(&UNITS[0]);
    Expr { kind: ExprKind::Number(Quantity { value, unit }), span: Span::default() }
}

/// Field of a condition that a fault refers to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ComparisonPart {
    Whole,
    Field,
    Value,
    Unit,
}

const FIELD: Span = Span { start: 1, end: 1 };
const VALUE: Span = Span { start: 2, end: 2 };

impl ComparisonPart {
    /// The parts of the expression below are distinguished by their spans.
    fn of(fault: &Fault) -> ComparisonPart {
        match fault.span {
            FIELD => ComparisonPart::Field,
            VALUE => ComparisonPart::Value,
            _ => ComparisonPart::Whole,
        }
    }
}

fn expression(c: &QueryCondition, catalog: &Catalog) -> Result<Expr, (ComparisonPart, Fault)> {
    let field = Expr { kind: ExprKind::Name(c.field.clone()), span: FIELD };
    let whole = FIELD.to(VALUE);
    let wrong = |zh: &str, en: &str| (ComparisonPart::Value, Fault::new("rule.type", VALUE, zh, en));
    let op = match c.operator {
        QueryOperator::Gt => CompareOp::Greater,
        QueryOperator::Ge => CompareOp::GreaterOrEqual,
        QueryOperator::Lt => CompareOp::Less,
        QueryOperator::Le => CompareOp::LessOrEqual,
        QueryOperator::Eq => CompareOp::Equal,
        QueryOperator::Ne => CompareOp::NotEqual,
        QueryOperator::In => {
            let Some(list) = c.value.as_array() else {
                return Err(wrong("in 的取值应为数组", "`in` takes a list of values"));
            };
            let words: Option<Vec<_>> =
                list.iter().map(|v| v.as_str().map(|w| (w.to_owned(), VALUE))).collect();
            let words = words.ok_or_else(|| wrong("in 的取值应为名称", "`in` takes a list of names"))?;
            return Ok(Expr { kind: ExprKind::In(Box::new(field), words), span: whole });
        }
    };
    let value = match &c.value {
        Value::Number(n) => {
            let unit = match (&c.unit, catalog.get(&c.field).map(|d| &d.kind)) {
                (Some(symbol), _) => {
                    Unit::parse(symbol).ok_or_else(|| (ComparisonPart::Unit, unknown_unit(symbol, VALUE)))?
                }
                (None, Some(SignalKind::Number(d))) => d.base(),
                (None, _) => &UNITS[0],
            };
            let value = n.as_f64().ok_or_else(|| wrong("取值不是数", "the value is not a number"))?;
            ExprKind::Number(Quantity { value, unit })
        }
        Value::Bool(b) => ExprKind::Name(b.to_string()),
        Value::String(word) => ExprKind::Name(word.clone()),
        _ => return Err(wrong("取值应为数、名称或真假", "the value is a number, a name or true or false")),
    };
    let right = Expr { kind: value, span: VALUE };
    Ok(Expr { kind: ExprKind::Compare(Box::new(field), vec![(op, right)]), span: whole })
}
