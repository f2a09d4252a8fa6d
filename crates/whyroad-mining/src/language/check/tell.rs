//! Conditions in words, for telling a person.

use super::super::program::Kind;
use super::super::syntax::{ArithmeticOp, Expr, ExprKind};
use super::{Checker, Definition};
use std::fmt::Write as _;

/// Up to so many characters a condition is told with all names replaced.
const SHORT: usize = 90;

/// In longer ones, the names of definitions that would be longer than this are kept.
const LONG_NAME: usize = 36;

impl Checker<'_> {
    /// The expression in words, all names replaced by what they stand for.
    pub fn describe(&self, expr: &Expr) -> String {
        self.words(expr, usize::MAX)
    }

    /// The expression for a person: all names replaced by what they stand for where that stays short, else with the names
    /// of its conditions kept ([`Self::names_told`]).
    pub fn tell(&self, expr: &Expr) -> String {
        let whole = self.describe(expr);
        if whole.chars().count() <= SHORT { whole } else { self.tell_by_names(expr) }
    }

    /// True where [`Self::tell`] replaces all names.
    pub(super) fn is_short(&self, expr: &Expr) -> bool {
        self.describe(expr).chars().count() <= SHORT
    }

    /// The expression with the names of longer conditions kept.
    pub(super) fn tell_by_names(&self, expr: &Expr) -> String {
        self.words(expr, LONG_NAME)
    }

    /// The definitions whose names are in [`Self::tell_by_names`], and those that their own texts speak of: each once, in
    /// the order in which one comes upon them.
    pub(super) fn names_told(&self, expr: &Expr) -> Vec<String> {
        let mut out = Vec::new();
        self.collect_names(expr, &mut out);
        out
    }

    fn collect_names(&self, expr: &Expr, out: &mut Vec<String>) {
        if let ExprKind::Name(name) = &expr.kind
            && let Some(definition) = self.definitions.get(name)
        {
            if self.is_kept(definition, LONG_NAME) {
                if out.contains(name) {
                    return;
                }
                out.push(name.clone());
            }
            self.collect_names(&definition.expr, out);
            return;
        }
        for part in expr.parts() {
            self.collect_names(part, out);
        }
    }

    fn is_kept(&self, definition: &Definition, longest: usize) -> bool {
        self.program.node(definition.node).kind == Kind::Condition
            && longest < usize::MAX
            && self.words(&definition.expr, longest).chars().count() > longest
    }

    /// The expression in words: as written, in the spacing of DATA_FORMAT.md 5.2, parameters by value; names of conditions
    /// that would be longer than `longest` characters are kept.
    fn words(&self, expr: &Expr, longest: usize) -> String {
        if let Some(q) = self.quantity(expr) {
            return format!("{}{}", q.value, q.unit.symbol);
        }
        let list = |all: &[Expr], word: &str| {
            all.iter().map(|e| self.tight(e, longest)).collect::<Vec<_>>().join(&format!(" {word} "))
        };
        match &expr.kind {
            ExprKind::Number(q) => format!("{}{}", q.value, q.unit.symbol),
            ExprKind::Name(n) => match self.definitions.get(n) {
                Some(definition) if !self.is_kept(definition, longest) => {
                    self.words(&definition.expr, longest)
                }
                _ => n.clone(),
            },
            ExprKind::Call(n, arguments) => {
                format!(
                    "{n}({})",
                    arguments.iter().map(|a| self.words(a, longest)).collect::<Vec<_>>().join(", ")
                )
            }
            ExprKind::Negate(of) => format!("-{}", self.tight(of, longest)),
            ExprKind::Not(of) => match &of.kind {
                ExprKind::Known(inner) => format!("{} is unknown", self.tight(inner, longest)),
                _ => format!("not {}", self.tight(of, longest)),
            },
            ExprKind::Arithmetic(op, a, b) => {
                let sign = match op {
                    ArithmeticOp::Add => '+',
                    ArithmeticOp::Subtract => '-',
                    ArithmeticOp::Multiply => '*',
                };
                format!("{} {sign} {}", self.tight(a, longest), self.tight(b, longest))
            }
            ExprKind::And(all) => list(all, "and"),
            ExprKind::Or(all) => list(all, "or"),
            ExprKind::Compare(first, rest) => {
                let mut text = self.tight(first, longest);
                for (op, e) in rest {
                    let _ = write!(text, " {} {}", op.symbol(), self.tight(e, longest));
                }
                text
            }
            ExprKind::In(of, members) => {
                let words: Vec<&str> = members.iter().map(|(w, _)| w.as_str()).collect();
                format!("{} in {{{}}}", self.tight(of, longest), words.join(", "))
            }
            ExprKind::Known(of) => format!("{} is known", self.tight(of, longest)),
            ExprKind::For(of, t) => match &of.kind {
                ExprKind::Gaps(of, gaps) => {
                    let (of, t, gaps) =
                        (self.tight(of, longest), self.words(t, longest), self.words(gaps, longest));
                    format!("{of} for {t} gaps {gaps}")
                }
                _ => format!("{} for {}", self.tight(of, longest), self.words(t, longest)),
            },
            ExprKind::Gaps(of, t) => format!("{} gaps {}", self.tight(of, longest), self.words(t, longest)),
            ExprKind::Since(a, b, t) => self.lasting((a, "since", b), t.as_deref(), longest),
            ExprKind::Until(a, b, t) => self.lasting((a, "until", b), t.as_deref(), longest),
            ExprKind::Within(of, t) => {
                format!("{} within {}", self.tight(of, longest), self.words(t, longest))
            }
            ExprKind::Then(a, b, t) => {
                format!(
                    "{} then {} within {}",
                    self.tight(a, longest),
                    self.tight(b, longest),
                    self.words(t, longest)
                )
            }
            ExprKind::At(of) => format!("{} at keyframe", self.tight(of, longest)),
        }
    }

    fn lasting(&self, (a, word, b): (&Expr, &str, &Expr), time: Option<&Expr>, longest: usize) -> String {
        let within = time.map(|t| format!(" within {}", self.words(t, longest))).unwrap_or_default();
        format!("{} {word} {}{within}", self.tight(a, longest), self.tight(b, longest))
    }

    /// In parentheses where the expression is more than one word.
    fn tight(&self, expr: &Expr, longest: usize) -> String {
        let text = self.words(expr, longest);
        let expanded =
            matches!(&expr.kind, ExprKind::Name(n) if *n != text && self.definitions.contains_key(n));
        let compound = !matches!(expr.kind, ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Call(..));
        if (compound || expanded) && text.contains(' ') { format!("({text})") } else { text }
    }
}
