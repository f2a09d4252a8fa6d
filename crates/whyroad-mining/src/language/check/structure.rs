//! What a displayed condition is made of, as written: its members under "all of", "any of" or "not", down to single
//! comparisons. A pattern that is worded as one condition (`wording::idioms`) is one here, too.

use super::super::program::Atom;
use super::super::syntax::{Expr, ExprKind};
use super::displayed::{Displayed, pairs};
use super::wording::idioms::{around, during, without_repeats};
use super::{Checker, Fault};
use std::collections::BTreeSet;

/// How the members of a condition decide it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// It has none: a comparison, or a condition that is shown as a whole.
    Single,
    /// All must hold.
    All,
    /// One must hold.
    Any,
    /// The only one must not hold.
    Not,
    /// Its members at other moments, or for some time.
    OverTime,
}

/// A condition and its members.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// Its text, truth and measured value.
    pub shown: Atom,
    /// The definition of the rule that it is.
    pub definition: Option<String>,
    /// Its words are the name that the rule gives the definition.
    pub is_named: bool,
    /// How its members decide it.
    pub join: Join,
    /// In the order in which they are written; without any where they are listed above.
    pub members: Vec<Structure>,
    /// The members of the same definition are listed above, in the same part of the rule.
    pub is_listed_above: bool,
}

impl Checker<'_> {
    /// The structure of a condition that has been checked, and that is written as a definition of this name. Members
    /// of a definition are listed once, so that the structure is not larger than the text.
    pub(super) fn structure(&mut self, expr: &Expr, name: Option<&str>) -> Result<Structure, Fault> {
        self.structure_of(expr, name, &mut BTreeSet::new())
    }

    fn structure_of(
        &mut self,
        expr: &Expr,
        name: Option<&str>,
        listed: &mut BTreeSet<String>,
    ) -> Result<Structure, Fault> {
        if let Some((name, definition)) = self.defined(expr) {
            return self.structure_of(&definition, Some(&name), listed);
        }
        let (join, members) = self.members(expr);
        let is_listed_above = !members.is_empty() && name.is_some_and(|name| !listed.insert(name.to_owned()));
        let members = if is_listed_above { Vec::new() } else { members };
        let Displayed { words, is_name } = self.displayed(expr, name);
        Ok(Structure {
            shown: self.atom(expr, words)?,
            definition: name.map(str::to_owned),
            is_named: is_name,
            join,
            members: members.iter().map(|e| self.structure_of(e, None, listed)).collect::<Result<_, _>>()?,
            is_listed_above,
        })
    }

    /// The name and meaning of a definition.
    fn defined(&self, expr: &Expr) -> Option<(String, Expr)> {
        let ExprKind::Name(name) = &expr.kind else { return None };
        Some((name.clone(), self.definitions.get(name)?.expr.clone()))
    }

    fn members(&self, expr: &Expr) -> (Join, Vec<Expr>) {
        let over_time = |of: &[&Expr]| (Join::OverTime, of.iter().map(|e| (*e).clone()).collect());
        match &expr.kind {
            ExprKind::And(all) => (Join::All, all.clone()),
            ExprKind::Or(all) => match without_repeats(all).as_slice() {
                [one] => self.members(one),
                [a, b] => match (during(a, b), around(a, b)) {
                    (Some((stretch, happens)), _) => over_time(&[stretch, happens]),
                    (_, Some((of, _))) => over_time(&[of]),
                    _ => (Join::Any, vec![(*a).clone(), (*b).clone()]),
                },
                all => (Join::Any, all.iter().map(|e| (*e).clone()).collect()),
            },
            ExprKind::Compare(_, rest) if rest.len() > 1 => (Join::All, pairs(expr)),
            ExprKind::Not(of) if self.is_plain(of) => (Join::Single, Vec::new()),
            ExprKind::Not(of) => (Join::Not, vec![(**of).clone()]),
            ExprKind::For(of, _) => match &of.kind {
                ExprKind::Gaps(of, _) => over_time(&[of]),
                _ => over_time(&[of]),
            },
            ExprKind::Gaps(of, _) | ExprKind::Within(of, _) => over_time(&[of]),
            ExprKind::Since(a, b, _) | ExprKind::Until(a, b, _) | ExprKind::Then(a, b, _) => {
                over_time(&[a, b])
            }
            ExprKind::Call(name, arguments) if matches!(name.as_str(), "previously" | "rises" | "falls") => {
                over_time(&arguments.iter().take(1).collect::<Vec<_>>())
            }
            _ => (Join::Single, Vec::new()),
        }
    }

    /// True where there is nothing to show besides whether it holds: a flag, a test of knowledge, a condition on many
    /// objects.
    fn is_plain(&self, expr: &Expr) -> bool {
        if let Some((_, definition)) = self.defined(expr) {
            return self.is_plain(&definition);
        }
        !matches!(expr.kind, ExprKind::Compare(..) | ExprKind::In(..)) && self.members(expr).0 == Join::Single
    }
}
