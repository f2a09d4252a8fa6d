//! Findings as they come: text, or one JSON or SARIF document written piece by piece, so that memory does not
//! grow with their number.

use crate::output::{FindingFormat, render_text};
use std::collections::BTreeSet;
use std::io::{self, Write};
use whyroad_model::diagnostic::{json_row, sarif_result};
use whyroad_model::{Diagnostic, Lang};

pub(super) struct Printer<'o> {
    out: &'o mut dyn Write,
    format: FindingFormat,
    lang: Lang,
    printed: usize,
    codes: BTreeSet<&'static str>,
}

impl<'o> Printer<'o> {
    pub fn new(out: &'o mut dyn Write, format: FindingFormat, lang: Lang) -> Self {
        Self { out, format, lang, printed: 0, codes: BTreeSet::new() }
    }

    pub fn print(&mut self, d: &Diagnostic) -> io::Result<()> {
        if self.printed == 0 {
            self.open()?;
        }
        let separator = if self.printed == 0 { "\n" } else { ",\n" };
        self.printed += 1;
        match self.format {
            FindingFormat::Text => {
                let blank = if self.printed == 1 { "" } else { "\n" };
                write!(self.out, "{blank}{}", render_text(d, self.lang))
            }
            FindingFormat::Json => write!(self.out, "{separator}{}", json_row(d, self.lang)),
            FindingFormat::Sarif => {
                self.codes.insert(d.code);
                write!(self.out, "{separator}{}", sarif_result(d, self.lang))
            }
        }
    }

    fn open(&mut self) -> io::Result<()> {
        match self.format {
            FindingFormat::Text => Ok(()),
            FindingFormat::Json => write!(self.out, "{{\"diagnostics\":["),
            FindingFormat::Sarif => write!(
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
            FindingFormat::Text => {}
            FindingFormat::Json => writeln!(
                self.out,
                "\n],\"documents\":{documents},\"valid\":{valid},\"errors\":{errors},\"warnings\":{warnings}}}"
            )?,
            FindingFormat::Sarif => {
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
