//! Conditions as displayed text.

use super::super::program::ValueKind;
use super::super::syntax::{ArithmeticOp, Expr, ExprKind};
use super::Checker;
use std::fmt::Write as _;

/// Longest text, in characters, in which all names are replaced.
const SHORT: usize = 90;

/// In longer ones, the names of definitions that would be longer than this are kept.
const LONG_NAME: usize = 36;

/// Treatment of the names of definitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Names {
    /// They are replaced by their meaning.
    Replaced,
    /// Names of longer conditions are kept.
    Kept,
}

/// The text of a definition. Made once, when it is read: a text that names others twice does not grow with what these
/// name.
#[derive(Clone, Debug)]
pub(super) struct DefinitionText {
    /// With all names replaced; unset where that is longer than [`SHORT`].
    whole: Option<String>,
    /// With the names of longer conditions kept.
    named: String,
    /// Whether its own name is kept where it is used.
    kept: bool,
}

impl Checker<'_> {
    /// The texts of a definition with this expression and value.
    pub(super) fn definition_text(&self, expr: &Expr, kind: &ValueKind) -> DefinitionText {
        let named = self.words(expr, Names::Kept);
        let length = named.chars().count();
        let longest = if *kind == ValueKind::Condition { LONG_NAME } else { SHORT };
        DefinitionText { whole: self.whole(expr), named, kept: length > longest }
    }

    /// The expression as text, all names replaced by their meaning as far as that is short.
    #[cfg(test)]
    pub fn describe(&self, expr: &Expr) -> String {
        self.words(expr, Names::Replaced)
    }

    /// The displayed expression: all names replaced by their meaning where that is short, else with the names of its
    /// conditions kept ([`Self::names_in_text`]).
    pub fn text_for_people(&self, expr: &Expr) -> String {
        self.whole(expr).unwrap_or_else(|| self.text_by_names(expr))
    }

    /// True where [`Self::text_for_people`] replaces all names.
    pub(super) fn is_short(&self, expr: &Expr) -> bool {
        self.whole(expr).is_some()
    }

    fn whole(&self, expr: &Expr) -> Option<String> {
        if let Some(text) = self.whole.get(expr) {
            return text;
        }
        let text = (!self.names_long(expr)).then(|| self.words(expr, Names::Replaced));
        self.whole.put(expr, text.filter(|text| text.chars().count() <= SHORT))
    }

    fn names_long(&self, expr: &Expr) -> bool {
        match &expr.kind {
            ExprKind::Name(n) => self.definitions.get(n).is_some_and(|d| d.text.whole.is_none()),
            _ => expr.parts().into_iter().any(|e| self.names_long(e)),
        }
    }

    /// The expression with the names of longer conditions kept.
    pub(super) fn text_by_names(&self, expr: &Expr) -> String {
        self.words(expr, Names::Kept)
    }

    /// The conditions whose names are in [`Self::text_by_names`], and those that their own texts use: each once, in
    /// order of appearance.
    pub(super) fn names_in_text(&self, expr: &Expr) -> Vec<String> {
        let mut seen = Vec::new();
        self.collect_names(expr, &mut seen);
        let is_kept = |n: &String| {
            let definition = &self.definitions[n];
            definition.text.kept && self.program.node(definition.node).kind == ValueKind::Condition
        };
        seen.into_iter().filter(is_kept).collect()
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

    /// The expression as text: as written, in the spacing of DATA_FORMAT.md 5.2, parameters by value.
    fn words(&self, expr: &Expr, names: Names) -> String {
        if let Some(q) = self.quantity(expr) {
            return format!("{}{}", q.value, q.unit.symbol);
        }
        let list = |all: &[Expr], word: &str| {
            all.iter().map(|e| self.tight(e, names)).collect::<Vec<_>>().join(&format!(" {word} "))
        };
        match &expr.kind {
            ExprKind::Number(q) => format!("{}{}", q.value, q.unit.symbol),
            ExprKind::Name(n) => match (self.definitions.get(n).map(|d| &d.text), names) {
                (Some(DefinitionText { whole: Some(text), .. }), Names::Replaced)
                | (Some(DefinitionText { named: text, kept: false, .. }), Names::Kept) => text.clone(),
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
