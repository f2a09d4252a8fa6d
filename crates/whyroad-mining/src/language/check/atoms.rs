//! The parts of a condition that a person is told about: each comparison with what it measured. Parts of a
//! conjunction, a disjunction or a duration are told one by one, anything else as a whole.

use super::super::program::{Atom, Kind, NodeId, Op};
use super::super::syntax::{ArithmeticOp, Expr, ExprKind, Quantity};
use super::compare::{Extreme, extreme_of};
use super::{Checker, Fault};
use std::fmt::Write as _;
use whyroad_model::units::{UNITS, Unit};

impl Checker<'_> {
    /// The conditions that must hold together for this one to hold, each with its text and its atoms: the members of
    /// a conjunction, also where it is written as a definition.
    pub fn parts(&mut self, expr: &Expr, out: &mut Vec<(String, NodeId, Vec<Atom>)>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) => all.iter().try_for_each(|e| self.parts(e, out)),
            ExprKind::Name(name) if self.definitions.contains_key(name) => {
                let definition = self.definitions[name].expr.clone();
                self.parts(&definition, out)
            }
            _ => {
                let mut atoms = Vec::new();
                self.atoms(expr, &mut atoms)?;
                out.push((self.describe(expr), self.condition(expr)?, atoms));
                Ok(())
            }
        }
    }

    /// Appends the atoms of a condition that has been checked.
    pub fn atoms(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) | ExprKind::Or(all) => all.iter().try_for_each(|e| self.atoms(e, out)),
            ExprKind::For(of, _) | ExprKind::Gaps(of, _) => self.atoms(of, out),
            ExprKind::Name(name) if self.definitions.contains_key(name) => {
                let definition = self.definitions[name].expr.clone();
                self.atoms(&definition, out)
            }
            ExprKind::Compare(first, rest) => {
                let mut left = first.as_ref();
                for (op, right) in rest {
                    let pair = Expr {
                        kind: ExprKind::Compare(Box::new(left.clone()), vec![(*op, right.clone())]),
                        span: expr.span,
                    };
                    let (l, r) = (self.quantity(left), self.quantity(right));
                    let measured = if l.is_some() { right } else { left };
                    let unit = l.or(r).map(|q| q.unit);
                    self.push_atom(&pair, measured, unit, out)?;
                    left = right;
                }
                Ok(())
            }
            ExprKind::In(of, _) => self.push_atom(expr, of, None, out),
            _ => self.push_atom(expr, expr, None, out),
        }
    }

    fn push_atom(
        &mut self,
        expr: &Expr,
        measured: &Expr,
        unit: Option<&'static Unit>,
        out: &mut Vec<Atom>,
    ) -> Result<(), Fault> {
        let condition = self.condition(expr)?;
        let measured = self.measure(measured, condition)?;
        let base = match &self.program.node(measured).kind {
            Kind::Number(d) => d.base(),
            _ => &UNITS[0],
        };
        let atom = Atom {
            text: self.describe(expr),
            condition,
            measured,
            signals: self.program.signals(condition),
            unit: unit.unwrap_or(base),
        };
        if !out.contains(&atom) {
            out.push(atom);
        }
        Ok(())
    }

    /// The node that tells what was measured: the number, or, where the condition speaks of many, what sums it up.
    fn measure(&mut self, expr: &Expr, condition: NodeId) -> Result<NodeId, Fault> {
        if let Some((which, of)) = extreme_of(expr) {
            let of = self.lower(of)?;
            let kind = self.program.node(of).kind.clone();
            let op = match which {
                Extreme::Least => Op::MatchLeast(of),
                Extreme::Greatest => Op::MatchGreatest(of),
            };
            return Ok(self.program.add(op, kind));
        }
        match &expr.kind {
            ExprKind::Call(name, _) if name == "count" => Ok(condition),
            _ => self.lower(expr),
        }
    }

    pub(super) fn quantity(&self, expr: &Expr) -> Option<Quantity> {
        match &expr.kind {
            ExprKind::Number(q) => Some(*q),
            ExprKind::Negate(of) => self.quantity(of).map(|q| Quantity { value: -q.value, ..q }),
            ExprKind::Name(n) => self.parameters.get(n).copied(),
            _ => None,
        }
    }

    /// The expression in words: as written, in the spacing of DATA_FORMAT.md 5.2, parameters by value.
    pub fn describe(&self, expr: &Expr) -> String {
        if let Some(q) = self.quantity(expr) {
            return format!("{}{}", q.value, q.unit.symbol);
        }
        let list = |all: &[Expr], word: &str| {
            all.iter().map(|e| self.describe_tight(e)).collect::<Vec<_>>().join(&format!(" {word} "))
        };
        match &expr.kind {
            ExprKind::Number(q) => format!("{}{}", q.value, q.unit.symbol),
            ExprKind::Name(n) => match self.definitions.get(n) {
                Some(definition) => self.describe(&definition.expr),
                None => n.clone(),
            },
            ExprKind::Call(n, arguments) => {
                format!("{n}({})", arguments.iter().map(|a| self.describe(a)).collect::<Vec<_>>().join(", "))
            }
            ExprKind::Negate(of) => format!("-{}", self.describe_tight(of)),
            ExprKind::Not(of) => match &of.kind {
                ExprKind::Known(inner) => format!("{} is unknown", self.describe_tight(inner)),
                _ => format!("not {}", self.describe_tight(of)),
            },
            ExprKind::Arithmetic(op, a, b) => {
                let sign = match op {
                    ArithmeticOp::Add => '+',
                    ArithmeticOp::Subtract => '-',
                    ArithmeticOp::Multiply => '*',
                };
                format!("{} {sign} {}", self.describe_tight(a), self.describe_tight(b))
            }
            ExprKind::And(all) => list(all, "and"),
            ExprKind::Or(all) => list(all, "or"),
            ExprKind::Compare(first, rest) => {
                let mut text = self.describe_tight(first);
                for (op, e) in rest {
                    let _ = write!(text, " {} {}", op.symbol(), self.describe_tight(e));
                }
                text
            }
            ExprKind::In(of, members) => {
                let words: Vec<&str> = members.iter().map(|(w, _)| w.as_str()).collect();
                format!("{} in {{{}}}", self.describe_tight(of), words.join(", "))
            }
            ExprKind::Known(of) => format!("{} is known", self.describe_tight(of)),
            ExprKind::For(of, t) => match &of.kind {
                ExprKind::Gaps(of, gaps) => {
                    let (of, t, gaps) = (self.describe_tight(of), self.describe(t), self.describe(gaps));
                    format!("{of} for {t} gaps {gaps}")
                }
                _ => format!("{} for {}", self.describe_tight(of), self.describe(t)),
            },
            ExprKind::Gaps(of, t) => format!("{} gaps {}", self.describe_tight(of), self.describe(t)),
            ExprKind::Since(a, b, t) => self.describe_lasting(a, "since", b, t.as_deref()),
            ExprKind::Until(a, b, t) => self.describe_lasting(a, "until", b, t.as_deref()),
            ExprKind::Within(of, t) => format!("{} within {}", self.describe_tight(of), self.describe(t)),
            ExprKind::Then(a, b, t) => {
                format!(
                    "{} then {} within {}",
                    self.describe_tight(a),
                    self.describe_tight(b),
                    self.describe(t)
                )
            }
            ExprKind::At(of) => format!("{} at keyframe", self.describe_tight(of)),
        }
    }

    fn describe_lasting(&self, a: &Expr, word: &str, b: &Expr, time: Option<&Expr>) -> String {
        let within = time.map(|t| format!(" within {}", self.describe(t))).unwrap_or_default();
        format!("{} {word} {}{within}", self.describe_tight(a), self.describe_tight(b))
    }

    /// In parentheses where the expression is more than one word.
    fn describe_tight(&self, expr: &Expr) -> String {
        let text = self.describe(expr);
        let expanded = matches!(&expr.kind, ExprKind::Name(n) if self.definitions.contains_key(n));
        let compound = !matches!(expr.kind, ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Call(..));
        if (compound || expanded) && text.contains(' ') { format!("({text})") } else { text }
    }
}
