//! Diagnostics: problems in the user's data, reported so they can be fixed. One type for logs,
//! taxonomies, specs, rules and labels. Codes are stable; each has a page in `docs/diagnostics/`.

mod quotation;
mod render;

pub use render::{json_row, render_ansi, render_json, render_sarif, render_text, sarif_result, summary};

use crate::{Bilingual, Lang};
use serde::Serialize;

/// How severe it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The document or record is not usable, or data was lost.
    Error,
    /// It is usable, but a person should look.
    Warning,
    /// For information.
    Note,
}

/// Where a finding is: the parts that are known.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Location {
    /// File as the user named it; `<stdin>` for standard input.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// Column in characters, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// JSON pointer (RFC 6901) inside the document, `""` for the whole of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// The line's text, for the snippet.
    #[serde(skip)]
    pub snippet: Option<String>,
    /// Characters of the line that were left out before the snippet; 0 when it starts with its line.
    #[serde(skip)]
    pub snippet_start: usize,
    /// Length in characters of the underlined part.
    #[serde(skip)]
    pub span: usize,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Stable code: `label.enum.longitudinal`, `av2.feather.truncated`.
    pub code: &'static str,
    /// How severe it is.
    pub severity: Severity,
    /// What is wrong, naming the value.
    pub message: Bilingual,
    /// Where.
    #[serde(rename = "place")]
    pub location: Location,
    /// How to fix it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<Bilingual>,
}

/// The text with long values of the user cut.
fn shortened(text: Bilingual) -> Bilingual {
    let Bilingual { zh, en } = text;
    Bilingual { zh: quotation::shortened(zh), en: quotation::shortened(en) }
}

impl Diagnostic {
    /// An error.
    pub fn error(code: &'static str, message: Bilingual) -> Self {
        let message = shortened(message);
        Self { code, severity: Severity::Error, message, location: Location::default(), hint: None }
    }
    /// A warning.
    pub fn warning(code: &'static str, message: Bilingual) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }
    /// A note.
    pub fn note(code: &'static str, message: Bilingual) -> Self {
        Self { severity: Severity::Note, ..Self::error(code, message) }
    }
    /// The same with a hint.
    #[must_use]
    pub fn with_hint(mut self, hint: Bilingual) -> Self {
        self.hint = Some(shortened(hint));
        self
    }
    /// The same at `location`.
    #[must_use]
    pub fn at(mut self, location: Location) -> Self {
        self.location = location;
        self
    }
    /// The same in `file`, the rest of the location kept.
    #[must_use]
    pub fn in_file(mut self, file: impl Into<String>) -> Self {
        self.location.file = Some(file.into());
        self
    }
    /// The message in `lang`.
    pub fn message(&self, lang: Lang) -> &str {
        self.message.get(lang)
    }
}
