//! The parts of a condition that are shown to people: each comparison with its measured value. Parts of a
//! conjunction, a disjunction or a duration are listed one by one, anything else as a whole.

use super::super::program::{Atom, NodeId, Op, ValueKind};
use super::super::syntax::{CompareOp, Expr, ExprKind, Quantity};
use super::compare::{Extreme, extreme_of};
use super::displayed::{Displayed, pairs};
use super::structure::Structure;
use super::wording::{EN_OR_UNKNOWN, ZH_OR_UNKNOWN};
use super::{Checker, Fault};
use std::collections::BTreeMap;
use whyroad_model::Bilingual;
use whyroad_model::units::UNITS;

/// Longest condition in words, in characters (a Chinese one counts twice), that needs no name.
const LENGTHY: usize = 140;

/// A definition of this length makes its users lengthy.
const PART_OF_LENGTH: usize = 40;

/// A part of a condition as displayed.
pub struct PartText {
    /// As written, names replaced by their definitions.
    pub text: String,
    /// In words.
    pub words: Bilingual,
    /// Its truth.
    pub condition: NodeId,
    /// Its comparisons.
    pub atoms: Vec<Atom>,
    /// What it is made of.
    pub structure: Structure,
}

impl Checker<'_> {
    /// The conditions that must hold together for this one, each with its text and its atoms: the members of
    /// a conjunction, also where it is written as a definition.
    pub fn parts(&mut self, expr: &Expr, out: &mut Vec<PartText>) -> Result<(), Fault> {
        self.parts_of(expr, None, out)
    }

    /// As [`Self::parts`], of a condition that is written as a definition of this name.
    fn parts_of(&mut self, expr: &Expr, name: Option<&str>, out: &mut Vec<PartText>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) => all.iter().try_for_each(|e| self.parts(e, out)),
            ExprKind::Name(name) if self.definitions.contains_key(name) => {
                let definition = self.definitions[name].expr.clone();
                self.parts_of(&definition, Some(name), out)
            }
            _ => {
                let mut atoms = Vec::new();
                self.definitions_in_text(expr, &mut atoms)?;
                self.atoms_of(expr, name, &mut atoms)?;
                let (text, words) = (self.text_for_people(expr), self.words_of(expr, name));
                let structure = self.structure(expr, name)?;
                out.push(PartText { text, words, condition: self.condition(expr)?, atoms, structure });
                Ok(())
            }
        }
    }

    /// Appends the atoms of a condition that has been checked.
    pub fn atoms(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        self.atoms_of(expr, None, out)
    }

    /// As [`Self::atoms`], of a condition that is written as a definition of this name.
    fn atoms_of(&mut self, expr: &Expr, name: Option<&str>, out: &mut Vec<Atom>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) | ExprKind::Or(all) => all.iter().try_for_each(|e| self.atoms(e, out)),
            ExprKind::For(of, _) | ExprKind::Gaps(of, _) => self.atoms_of(of, name, out),
            ExprKind::Name(name) if self.definitions.contains_key(name) => {
                let definition = self.definitions[name].expr.clone();
                self.atoms_of(&definition, Some(name), out)
            }
            ExprKind::Compare(..) => {
                let pairs = pairs(expr);
                let name = name.filter(|_| pairs.len() == 1);
                pairs.iter().try_for_each(|pair| self.push_atom(pair, name, out))
            }
            ExprKind::In(..) => self.push_atom(expr, name, out),
            _ => {
                self.push_atom(expr, name, out)?;
                self.named_atoms(expr, out)
            }
        }
    }

    /// For a condition that is too long to be shown with all names replaced: each definition that its text names, and
    /// their comparisons.
    fn named_atoms(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        for name in self.definitions_in_text(expr, out)? {
            let definition = self.definitions[&name].expr.clone();
            self.comparisons(&definition, out)?;
        }
        Ok(())
    }

    /// Each definition that the text of a condition names, as an atom: its name and meaning.
    fn definitions_in_text(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<Vec<String>, Fault> {
        let mut names = if self.is_short(expr) { Vec::new() } else { self.names_in_text(expr) };
        // A condition on each object in turn has no single value to show.
        names.retain(|name| !self.speaks_of_nobody(self.definitions[name].node));
        for name in &names {
            let atom = self.atom_of_definition(name)?;
            push_once(atom, out);
        }
        Ok(names)
    }

    /// A definition as an atom: its name and meaning.
    fn atom_of_definition(&mut self, name: &str) -> Result<Atom, Fault> {
        if let Some(known) = self.named.get(name) {
            return Ok(known.clone());
        }
        let definition = self.definitions[name].expr.clone();
        let condition = self.condition(&definition)?;
        let words = self.words_of(&definition, Some(name));
        let atom = Atom {
            text: format!("{name}: {}", self.text_by_names(&definition)),
            words,
            value_names: BTreeMap::new(),
            condition,
            measured: condition,
            signals: self.program.signals(condition),
            unit: &UNITS[0],
            threshold: None,
            is_denied: false,
        };
        self.named.insert(name.to_owned(), atom.clone());
        Ok(atom)
    }

    /// Comparisons directly in a conjunction or disjunction, not those inside its parts.
    fn comparisons(&mut self, expr: &Expr, out: &mut Vec<Atom>) -> Result<(), Fault> {
        match &expr.kind {
            ExprKind::And(all) | ExprKind::Or(all) => all.iter().try_for_each(|e| self.comparisons(e, out)),
            ExprKind::Compare(..) | ExprKind::In(..) => self.atoms(expr, out),
            _ => Ok(()),
        }
    }

    fn push_atom(&mut self, expr: &Expr, name: Option<&str>, out: &mut Vec<Atom>) -> Result<(), Fault> {
        let words = self.words_of(expr, name);
        push_once(self.atom(expr, words)?, out);
        Ok(())
    }

    /// A condition with what is measured for it: the number or category that it compares, else the condition itself.
    pub(super) fn atom(&mut self, expr: &Expr, words: Bilingual) -> Result<Atom, Fault> {
        if let Some(known) = self.shown.get(expr) {
            return Ok(Atom { words, ..known });
        }
        let condition = self.condition(expr)?;
        let (measured, compared) = self.measured_in(expr);
        let is_denied = match &expr.kind {
            ExprKind::Compare(_, rest) => matches!(rest.as_slice(), [(op, right)]
                if right.truth() == Some(*op == CompareOp::NotEqual)),
            _ => false,
        };
        let measured = self.measure(measured, condition)?;
        let (base, value_names) = match &self.program.node(measured).kind {
            ValueKind::Number(d) => (d.base(), BTreeMap::new()),
            ValueKind::Category(values) => {
                let named = |v: &String| (v.clone(), self.catalog.value_name(v));
                (&UNITS[0], values.iter().map(named).collect())
            }
            ValueKind::Condition => (&UNITS[0], BTreeMap::new()),
        };
        let unit = compared.map_or(base, |q| q.unit);
        let atom = Atom {
            text: self.text_for_people(expr),
            words,
            value_names,
            condition,
            measured,
            signals: self.program.signals(condition),
            unit,
            threshold: self.threshold(condition).map(|base| base / unit.to_base),
            is_denied,
        };
        Ok(self.shown.put(expr, atom))
    }

    /// What a condition measures, and the fixed number that it compares that with.
    fn measured_in<'e>(&self, expr: &'e Expr) -> (&'e Expr, Option<Quantity>) {
        match &expr.kind {
            ExprKind::Compare(left, rest) => {
                let [(_, right)] = rest.as_slice() else { return (expr, None) };
                let (l, r) = (self.quantity(left), self.quantity(right));
                (if l.is_some() { right } else { left }, l.or(r))
            }
            ExprKind::In(of, _) => (of, None),
            _ => (expr, None),
        }
    }

    /// The constant of a comparison, in the base unit of its dimension.
    fn threshold(&self, condition: NodeId) -> Option<f64> {
        let Op::Compare { left, right, .. } = &self.program.node(condition).op else { return None };
        [right, left].into_iter().find_map(|id| match self.program.node(*id).op {
            Op::Constant(value) => Some(value),
            _ => None,
        })
    }

    /// Text of a condition: the name of its definition where it has one and is more than a short comparison.
    pub(super) fn displayed(&self, expr: &Expr, name: Option<&str>) -> Displayed {
        let words = self.in_words(expr);
        let compares = matches!(expr.kind, ExprKind::Compare(..) | ExprKind::In(..));
        // A comparison is more informative than its name, and has a value.
        match name.and_then(|n| self.name_of_definition(n)) {
            Some(named) if !compares || is_lengthy(&words) => Displayed { words: named, is_name: true },
            _ => Displayed { words, is_name: false },
        }
    }

    /// As [`Self::displayed`]; a condition that is displayed at length is recorded.
    fn words_of(&mut self, expr: &Expr, name: Option<&str>) -> Bilingual {
        let Displayed { words, is_name } = self.displayed(expr, name);
        if !is_name && is_lengthy(&words) {
            let mut within = Vec::new();
            self.lengthy_definitions(expr, &mut within);
            let definition = name.map(str::to_owned).into_iter().chain(within).next();
            if let Some(definition) = definition {
                self.lengthy.entry(definition).or_insert_with(|| words.clone());
            }
        }
        words
    }

    /// The outermost definitions without a name whose own words are long.
    fn lengthy_definitions(&self, expr: &Expr, out: &mut Vec<String>) {
        if let ExprKind::Name(name) = &expr.kind {
            let definition = self.definitions.get(name).filter(|_| !self.names.contains_key(name));
            if definition.is_some_and(|d| is_part_of_length(&self.in_words(&d.expr))) {
                out.push(name.clone());
            }
            return;
        }
        expr.parts().into_iter().for_each(|e| self.lengthy_definitions(e, out));
    }

    /// The node of the measured value: the number, or its summary where the condition is about many objects.
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

fn push_once(atom: Atom, out: &mut Vec<Atom>) {
    let is_same =
        |a: &Atom| (a.condition, a.measured) == (atom.condition, atom.measured) && a.text == atom.text;
    if !out.iter().any(is_same) {
        out.push(atom);
    }
}

/// What a negation adds for unknown values is not counted: no name could replace it.
fn is_lengthy(words: &Bilingual) -> bool {
    let (zh, en) = (words.zh.replace(ZH_OR_UNKNOWN, ""), words.en.replace(EN_OR_UNKNOWN, ""));
    zh.chars().count() * 2 > LENGTHY || en.chars().count() > LENGTHY
}

fn is_part_of_length(words: &Bilingual) -> bool {
    words.zh.chars().count() * 2 > PART_OF_LENGTH || words.en.chars().count() > PART_OF_LENGTH
}
