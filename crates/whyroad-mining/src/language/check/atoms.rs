//! The parts of a condition that are shown to people: each comparison with what it measured. Parts of a
//! conjunction, a disjunction or a duration are listed one by one, anything else as a whole.

use super::super::program::{Atom, NodeId, Op, ValueKind};
use super::super::syntax::{Expr, ExprKind, Quantity};
use super::compare::{Extreme, extreme_of};
use super::{Checker, Fault};
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
                self.definitions_in_text(expr, &mut atoms)?;
                self.atoms(expr, &mut atoms)?;
                out.push((self.text_for_people(expr), self.condition(expr)?, atoms));
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
            _ => {
                self.push_atom(expr, expr, None, out)?;
                self.named_atoms(expr, out)
            }
        }
    }

    /// Of a condition that is too long to be shown with all its names replaced: each definition that its text names,
    /// and what these compare.
    fn named_atoms(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        for name in self.definitions_in_text(expr, out)? {
            let definition = self.definitions[&name].expr.clone();
            self.comparisons(&definition, out)?;
        }
        Ok(())
    }

    /// Each definition that the text of a condition names, as an atom: its name and what it means.
    fn definitions_in_text(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<Vec<String>, Fault> {
        let mut names = if self.is_short(expr) { Vec::new() } else { self.names_in_text(expr) };
        // What holds of each object in turn has no one value to show.
        names.retain(|name| !self.speaks_of_nobody(self.definitions[name].node));
        for name in &names {
            let definition = self.definitions[name].expr.clone();
            let condition = self.condition(&definition)?;
            let atom = Atom {
                text: format!("{name}: {}", self.text_by_names(&definition)),
                condition,
                measured: condition,
                signals: self.program.signals(condition),
                unit: &UNITS[0],
            };
            if !out.contains(&atom) {
                out.push(atom);
            }
        }
        Ok(names)
    }

    /// Comparisons that stand in a conjunction or disjunction, not those of what it is made of.
    fn comparisons(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) | ExprKind::Or(all) => all.iter().try_for_each(|e| self.comparisons(e, out)),
            ExprKind::Compare(..) | ExprKind::In(..) => self.atoms(expr, out),
            _ => Ok(()),
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
            ValueKind::Number(d) => d.base(),
            _ => &UNITS[0],
        };
        let atom = Atom {
            text: self.text_for_people(expr),
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

    /// The node of what was measured: the number, or, where the condition is about many, what sums it up.
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
}
