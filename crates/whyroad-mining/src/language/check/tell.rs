//! Conditions in words, for telling a person.

use super::super::program::Kind;
use super::super::syntax::{ArithmeticOp, Expr, ExprKind};
use super::Checker;
use std::fmt::Write as _;

/// Up to so many characters a condition is told with all names replaced.
const SHORT: usize = 90;

/// In longer ones, the names of definitions that would be longer than this are kept.
const LONG_NAME: usize = 36;

/// What becomes of the names of definitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Names {
    /// They give way to what they stand for.
    Replaced,
    /// Those of longer conditions stay.
    Kept,
}

/// How a definition is told. Made once, when it is read: a text that names others twice does not grow with what these
/// name.
#[derive(Clone, Debug)]
pub(super) struct Told {
    /// With all names replaced; none where that is longer than [`SHORT`].
    whole: Option<String>,
    /// With the names of longer conditions kept.
    named: String,
    /// Whether its own name is kept where it is spoken of.
    kept: bool,
}

impl Checker<'_> {
    /// The texts of a definition with this expression and value.
    pub(super) fn told(&self, expr: &Expr, kind: &Kind) -> Told {
        let named = self.words(expr, Names::Kept);
        let length = named.chars().count();
        let longest = if *kind == Kind::Condition { LONG_NAME } else { SHORT };
        Told { whole: self.whole(expr), named, kept: length > longest }
    }

    /// The expression in words, all names replaced by what they stand for as far as that is short.
    #[cfg(test)]
    pub fn describe(&self, expr: &Expr) -> String {
        self.words(expr, Names::Replaced)
    }

    /// The expression for a person: all names replaced by what they stand for where that stays short, else with the
    /// names of its conditions kept ([`Self::names_told`]).
    pub fn tell(&self, expr: &Expr) -> String {
        self.whole(expr).unwrap_or_else(|| self.tell_by_names(expr))
    }

    /// True where [`Self::tell`] replaces all names.
    pub(super) fn is_short(&self, expr: &Expr) -> bool {
        self.whole(expr).is_some()
    }

    fn whole(&self, expr: &Expr) -> Option<String> {
        if self.names_long(expr) {
            return None;
        }
        let text = self.words(expr, Names::Replaced);
        (text.chars().count() <= SHORT).then_some(text)
    }

    fn names_long(&self, expr: &Expr) -> bool {
        match &expr.kind {
            ExprKind::Name(n) => self.definitions.get(n).is_some_and(|d| d.told.whole.is_none()),
            _ => expr.parts().into_iter().any(|e| self.names_long(e)),
        }
    }

    /// The expression with the names of longer conditions kept.
    pub(super) fn tell_by_names(&self, expr: &Expr) -> String {
        self.words(expr, Names::Kept)
    }

    /// The conditions whose names are in [`Self::tell_by_names`], and those that their own texts speak of: each once,
    /// in the order in which one comes upon them.
    pub(super) fn names_told(&self, expr: &Expr) -> Vec<String> {
        let mut seen = Vec::new();
        self.collect_names(expr, &mut seen);
        let told = |n: &String| {
            let definition = &self.definitions[n];
            definition.told.kept && self.program.node(definition.node).kind == Kind::Condition
        };
        seen.into_iter().filter(told).collect()
    }

    fn collect_names(&self, expr: &Expr, seen: &mut Vec<String>) {
        if let ExprKind::Name(name) = &expr.kind {
            if let Some(definition) = self.definitions.get(name).filter(|_| !seen.contains(name)) {
                seen.push(name.clone());
                self.collect_names(&definition.expr, seen);
            }
            return;
        }
        for part in expr.parts() {
            self.collect_names(part, seen);
        }
    }

    /// The expression in words: as written, in the spacing of DATA_FORMAT.md 5.2, parameters by value.
    fn words(&self, expr: &Expr, names: Names) -> String {
        if let Some(q) = self.quantity(expr) {
            return format!("{}{}", q.value, q.unit.symbol);
        }
        let list = |all: &[Expr], word: &str| {
            all.iter().map(|e| self.tight(e, names)).collect::<Vec<_>>().join(&format!(" {word} "))
        };
        match &expr.kind {
            ExprKind::Number(q) => format!("{}{}", q.value, q.unit.symbol),
            ExprKind::Name(n) => match (self.definitions.get(n).map(|d| &d.told), names) {
                (Some(Told { whole: Some(text), .. }), Names::Replaced)
                | (Some(Told { named: text, kept: false, .. }), Names::Kept) => text.clone(),
                _ => n.clone(),
            },
            ExprKind::Call(n, arguments) => {
                format!(
                    "{n}({})",
                    arguments.iter().map(|a| self.words(a, names)).collect::<Vec<_>>().join(", ")
                )
            }
            ExprKind::Negate(of) => format!("-{}", self.tight(of, names)),
            ExprKind::Not(of) => match &of.kind {
                ExprKind::Known(inner) => format!("{} is unknown", self.tight(inner, names)),
                _ => format!("not {}", self.tight(of, names)),
            },
            ExprKind::Arithmetic(op, a, b) => {
                let sign = match op {
                    ArithmeticOp::Add => '+',
                    ArithmeticOp::Subtract => '-',
                    ArithmeticOp::Multiply => '*',
                };
                format!("{} {sign} {}", self.tight(a, names), self.tight(b, names))
            }
            ExprKind::And(all) => list(all, "and"),
            ExprKind::Or(all) => list(all, "or"),
            ExprKind::Compare(first, rest) => {
                let mut text = self.tight(first, names);
                for (op, e) in rest {
                    let _ = write!(text, " {} {}", op.symbol(), self.tight(e, names));
                }
                text
            }
            ExprKind::In(of, members) => {
                let words: Vec<&str> = members.iter().map(|(w, _)| w.as_str()).collect();
                format!("{} in {{{}}}", self.tight(of, names), words.join(", "))
            }
            ExprKind::Known(of) => format!("{} is known", self.tight(of, names)),
            ExprKind::For(of, t) => match &of.kind {
                ExprKind::Gaps(of, gaps) => {
                    let (of, t, gaps) =
                        (self.tight(of, names), self.words(t, names), self.words(gaps, names));
                    format!("{of} for {t} gaps {gaps}")
                }
                _ => format!("{} for {}", self.tight(of, names), self.words(t, names)),
            },
            ExprKind::Gaps(of, t) => format!("{} gaps {}", self.tight(of, names), self.words(t, names)),
            ExprKind::Since(a, b, t) => self.lasting((a, "since", b), t.as_deref(), names),
            ExprKind::Until(a, b, t) => self.lasting((a, "until", b), t.as_deref(), names),
            ExprKind::Within(of, t) => {
                format!("{} within {}", self.tight(of, names), self.words(t, names))
            }
            ExprKind::Then(a, b, t) => {
                format!(
                    "{} then {} within {}",
                    self.tight(a, names),
                    self.tight(b, names),
                    self.words(t, names)
                )
            }
            ExprKind::At(of) => format!("{} at keyframe", self.tight(of, names)),
        }
    }

    fn lasting(&self, (a, word, b): (&Expr, &str, &Expr), time: Option<&Expr>, names: Names) -> String {
        let within = time.map(|t| format!(" within {}", self.words(t, names))).unwrap_or_default();
        format!("{} {word} {}{within}", self.tight(a, names), self.tight(b, names))
    }

    /// In parentheses where the expression is more than one word.
    fn tight(&self, expr: &Expr, names: Names) -> String {
        let text = self.words(expr, names);
        let expanded =
            matches!(&expr.kind, ExprKind::Name(n) if *n != text && self.definitions.contains_key(n));
        let compound = !matches!(expr.kind, ExprKind::Number(_) | ExprKind::Name(_) | ExprKind::Call(..));
        if (compound || expanded) && text.contains(' ') { format!("({text})") } else { text }
    }
}
