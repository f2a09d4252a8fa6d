//! The rule language: text to a checked program. `docs/reference/rules.md` is its manual.
//!
//! ```text
//! text --token--> tokens --parse--> syntax (names as written) --check--> Program (signals resolved, base units)
//! ```
//!
//! What a program *means* is in [`crate::interpret`].

pub mod check;
pub mod parse;
pub mod program;
pub mod syntax;
pub mod token;

pub use check::Checker;
pub use program::{Moment, NodeId, Op, Program, Subject, ValueScope};
pub use syntax::{Expr, Span};

use whyroad_model::{Bilingual, Diagnostic, Location};

/// An error in an expression, and the wrong part. Becomes a [`Diagnostic`] once the position of the expression is
/// known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// `rule.*` code.
    pub code: &'static str,
    /// What is wrong, naming the value.
    pub message: Bilingual,
    /// How to fix it.
    pub hint: Option<Box<Bilingual>>,
    /// The wrong part of the expression.
    pub span: Span,
}

impl Fault {
    /// A fault at `span`.
    pub fn new(code: &'static str, span: Span, zh: impl Into<String>, en: impl Into<String>) -> Self {
        Self { code, message: Bilingual::new(zh, en), hint: None, span }
    }

    /// The same with a hint.
    #[must_use]
    pub fn hint(mut self, zh: impl Into<String>, en: impl Into<String>) -> Self {
        self.hint = Some(Box::new(Bilingual::new(zh, en)));
        self
    }

    /// As a diagnostic about the expression `text`, shown unchanged; `origin` states where it comes from.
    pub fn about(self, text: &str, origin: &Location) -> Diagnostic {
        let start = self.span.start.min(text.len());
        let end = self.span.end.clamp(start, text.len());
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let place = Location {
            line: origin.line.or(Some(1)).map(|l| l + text[..start].matches('\n').count()),
            column: Some(text[line_start..start].chars().count() + 1),
            snippet: text[line_start..].lines().next().map(str::to_owned),
            span: text[start..end].lines().next().unwrap_or_default().chars().count().max(1),
            ..origin.clone()
        };
        self.at(place)
    }

    /// As a diagnostic at a place that is known already.
    pub fn at(self, place: Location) -> Diagnostic {
        let d = Diagnostic::error(self.code, self.message).at(place);
        match self.hint {
            Some(h) => d.with_hint(*h),
            None => d,
        }
    }
}

#[cfg(test)]
mod tests;
