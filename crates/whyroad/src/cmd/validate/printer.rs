//! Findings as they come: text, or one JSON or SARIF document written piece by piece, so that memory does not
//! grow with their number.

use crate::output::render_text;
use std::collections::BTreeSet;
use std::io::{self, Write};
use whyroad_model::diagnostic::{json_row, sarif_result};
use whyroad_model::{Diagnostic, Lang};

/// How findings are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// For people
    Text,
    /// One object: diagnostics and counts
    Json,
    /// SARIF 2.1.0, for code hosting and editors
    Sarif,
}

pub(super) struct Printer<'o> {
    out: &'o mut dyn Write,
    format: Format,
    lang: Lang,
    printed: usize,
    codes: BTreeSet<&'static str>,
}

impl<'o> Printer<'o> {
    pub fn new(out: &'o mut dyn Write, format: Format, lang: Lang) -> Self {
        Self { out, format, lang, printed: 0, codes: BTreeSet::new() }
    }

    pub fn print(&mut self, d: &Diagnostic) -> io::Result<()> {
        if self.printed == 0 {
            self.open()?;
        }
        let separator = if self.printed == 0 { "\n" } else { ",\n" };
        self.printed += 1;
        match self.format {
            Format::Text => {
                let blank = if self.printed == 1 { "" } else { "\n" };
                write!(self.out, "{blank}{}", render_text(d, self.lang))
            }
            Format::Json => write!(self.out, "{separator}{}", json_row(d, self.lang)),
            Format::Sarif => {
                self.codes.insert(d.code);
                write!(self.out, "{separator}{}", sarif_result(d, self.lang))
            }
        }
    }

    fn open(&mut self) -> io::Result<()> {
        match self.format {
            Format::Text => Ok(()),
            Format::Json => write!(self.out, "{{\"diagnostics\":["),
            Format::Sarif => write!(
                self.out,
                "{{\"$schema\":\"https://json.schemastore.org/sarif-2.1.0.json\",\"version\":\"2.1.0\",\"runs\":[{{\"columnKind\":\"unicodeCodePoints\",\"results\":["
            ),
        }
    }

    /// Closes the document.
    pub fn finish(
        &mut self,
        documents: usize,
        valid: usize,
        errors: usize,
        warnings: usize,
        lang: Lang,
    ) -> io::Result<()> {
        if self.printed == 0 {
            self.open()?;
        }
        match self.format {
            Format::Text => {}
            Format::Json => writeln!(
                self.out,
                "\n],\"documents\":{documents},\"valid\":{valid},\"errors\":{errors},\"warnings\":{warnings}}}"
            )?,
            Format::Sarif => {
                let rules: Vec<_> = self
                    .codes
                    .iter()
                    .map(|c| serde_json::json!({ "id": c, "helpUri": format!("docs/diagnostics/{c}.md") }))
                    .collect();
                let driver = serde_json::json!({
                    "name": "whyroad",
                    "version": env!("CARGO_PKG_VERSION"),
                    "language": if lang == Lang::Zh { "zh-CN" } else { "en" },
                    "rules": rules,
                });
                writeln!(self.out, "\n],\"tool\":{{\"driver\":{driver}}}}}]}}")?;
            }
        }
        self.out.flush()
    }
}
