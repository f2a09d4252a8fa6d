//! The rule language: text to a checked program. `docs/rules.md` is its manual.
//!
//! ```text
//! text --token--> tokens --parse--> syntax (names as written) --check--> Program (signals resolved, base units)
//! ```
//!
//! What a program *means* is in [`crate::evaluate`].

pub mod check;
pub mod parse;
pub mod program;
pub mod syntax;
pub mod token;

pub use check::Checker;
pub use program::{Moment, NodeId, Op, Program, Scope, Subject};
pub use syntax::{Expr, Span};

use whyroad_model::{Bilingual, Diagnostic, Place};

/// What is wrong in an expression, and which part of it. Becomes a [`Diagnostic`] once the expression's
/// own place is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// `rule.*` code.
    pub code: &'static str,
    /// What is wrong, naming the value.
    pub message: Bilingual,
    /// How to mend it.
    pub hint: Option<Bilingual>,
    /// The part of the expression that is meant.
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
        self.hint = Some(Bilingual::new(zh, en));
        self
    }

    /// As a diagnostic; `origin` is where the expression `text` stands.
    pub fn locate(self, text: &str, origin: &Place) -> Diagnostic {
        let before = &text[..self.span.start.min(text.len())];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line_text = text[line_start..].lines().next().unwrap_or_default();
        let marked = &text[self.span.start.min(text.len())..self.span.end.min(text.len())];
        let column_in_line = before[line_start..].chars().count() + 1;
        let first_line = line_start == 0;
        let place = Place {
            file: origin.file.clone(),
            line: origin.line.map(|l| l + before.matches('\n').count()),
            // A place with a column is the expression's exact start in its file; without one the
            // expression itself is shown.
            column: Some(match origin.column {
                Some(c) if first_line => c + column_in_line - 1,
                _ => column_in_line,
            }),
            pointer: origin.pointer.clone(),
            snippet: Some(match &origin.snippet {
                Some(s) if first_line && origin.column.is_some() => s.clone(),
                _ => line_text.to_owned(),
            }),
            snippet_start: 0,
            span: marked.lines().next().unwrap_or_default().chars().count().max(1),
        };
        let d = Diagnostic::error(self.code, self.message).at(place);
        match self.hint {
            Some(h) => d.with_hint(h),
            None => d,
        }
    }
}

#[cfg(test)]
mod tests;
