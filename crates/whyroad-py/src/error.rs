//! Diagnostics as Python exceptions: `WhyroadError(code, message, hint, location)`.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use whyroad_lake::LakeError;
use whyroad_model::{Diagnostic, Lang};

create_exception!(
    _whyroad,
    WhyroadError,
    PyException,
    "A failure with the code of its diagnostic: args are (code, message, hint, location)."
);

/// The error for one diagnostic, in English.
pub fn of_diagnostic(d: &Diagnostic) -> PyErr {
    let hint = d.hint.as_ref().map(|h| h.get(Lang::En).to_owned());
    WhyroadError::new_err((d.code.to_owned(), d.message(Lang::En).to_owned(), hint, location(d)))
}

/// The error for the first of several; the others follow in its message.
pub fn of_diagnostics(all: &[Diagnostic]) -> PyErr {
    match all {
        [] => WhyroadError::new_err((
            "whyroad.unknown".to_owned(),
            String::new(),
            None::<String>,
            None::<String>,
        )),
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

/// A failure of Arrow itself.
pub fn of_arrow(e: impl std::fmt::Display) -> PyErr {
    WhyroadError::new_err(("arrow".to_owned(), e.to_string(), None::<String>, None::<String>))
}
