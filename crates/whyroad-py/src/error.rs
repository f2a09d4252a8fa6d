//! Diagnostics as Python exceptions, `WhyroadError(code, message, hint, location)`, and as warnings.

use pyo3::prelude::*;
use std::ffi::CString;
use whyroad_lake::LakeError;
use whyroad_model::{Bilingual, Diagnostic, Lang, Severity};

// Python classes: a native subclass of `Exception` cannot be built for the stable ABI of all supported versions.
pyo3::import_exception!(whyroad.errors, WhyroadError);
pyo3::import_exception!(whyroad.errors, WhyroadWarning);

/// The error for one diagnostic, in English.
pub fn of_diagnostic(d: &Diagnostic) -> PyErr {
    let hint = d.hint.as_ref().map(|h| h.get(Lang::En).to_owned());
    WhyroadError::new_err((d.code.to_owned(), d.message(Lang::En).to_owned(), hint, location(d)))
}

/// The error for a code of the documentation.
pub fn of_code(code: &'static str, message: String, hint: Option<String>) -> PyErr {
    let d = Diagnostic::error(code, Bilingual::same(message));
    of_diagnostic(&match hint {
        Some(hint) => d.with_hint(Bilingual::same(hint)),
        None => d,
    })
}

/// Python warnings for what was left out; notes need no action.
pub fn warn(py: Python<'_>, all: &[Diagnostic]) -> PyResult<()> {
    let category = py.get_type::<WhyroadWarning>();
    for d in all.iter().filter(|d| d.severity != Severity::Note) {
        let place = location(d).map(|l| format!("{l}: ")).unwrap_or_default();
        let text = format!("[{}] {place}{}", d.code, d.message(Lang::En));
        // A message never has a zero byte; if one came from a file's name, the text ends there.
        let text = CString::new(text.split('\0').next().unwrap_or_default()).unwrap_or_default();
        PyErr::warn(py, &category, &text, 1)?;
    }
    Ok(())
}

/// The error for the first of several; the others follow in its message.
pub fn of_diagnostics(all: &[Diagnostic]) -> PyErr {
    match all {
        [] => of_code("lake.io", "unknown failure".to_owned(), None),
        [one] => of_diagnostic(one),
        [first, rest @ ..] => {
            let others: Vec<String> =
                rest.iter().map(|d| format!("{}: {}", d.code, d.message(Lang::En))).collect();
            let message = format!("{}\n{}", first.message(Lang::En), others.join("\n"));
            let hint = first.hint.as_ref().map(|h| h.get(Lang::En).to_owned());
            WhyroadError::new_err((first.code.to_owned(), message, hint, location(first)))
        }
    }
}

/// `file:line:column`, as far as it is known.
pub fn location(d: &Diagnostic) -> Option<String> {
    let l = &d.location;
    let mut text = l.file.clone().unwrap_or_default();
    if let Some(line) = l.line {
        text += &format!(":{line}");
        if let Some(column) = l.column {
            text += &format!(":{column}");
        }
    }
    (!text.is_empty()).then_some(text)
}

/// The error of a lake.
pub fn of_lake(e: &LakeError) -> PyErr {
    of_diagnostic(&e.diagnostic())
}

/// A Parquet or Arrow table that cannot be read.
pub fn of_arrow(e: impl std::fmt::Display) -> PyErr {
    of_code("lake.table_broken", e.to_string(), None)
}
