//! `validate`: findings about labels and other messages, as dictionaries or as a table.

use crate::error::{location, of_arrow};
use crate::table::{Table, batches_of};
use arrow_array::cast::AsArray as _;
use arrow_array::{Array, ArrayRef, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use std::sync::Arc;
use whyroad_framework::Framework;
use whyroad_label::check::Checker;
use whyroad_model::{Diagnostic, Lang};

/// Findings of one document, as JSON texts of the form that `whyroad validate --format json` prints.
#[pyfunction]
pub fn validate_text(py: Python<'_>, text: &str, lang: &str) -> PyResult<Vec<String>> {
    let lang = language(lang)?;
    Ok(py.detach(|| {
        let found = Checker::new(Framework::bundled()).check_text(text);
        found.iter().map(|d| whyroad_model::diagnostic::json_row(d, lang).to_string()).collect()
    }))
}

/// Findings of every document in a text column of an Arrow table: `row, code, severity, message, hint, location`.
#[pyfunction]
pub fn validate_table(py: Python<'_>, table: &Bound<'_, PyAny>, column: &str, lang: &str) -> PyResult<Table> {
    let lang = language(lang)?;
    let (schema, batches) = batches_of(table)?;
    let index = schema
        .index_of(column)
        .map_err(|_| PyKeyError::new_err(format!("the table has no column '{column}'")))?;
    py.detach(|| {
        let checker = Checker::new(Framework::bundled());
        let (mut rows, mut found): (Vec<u64>, Vec<Diagnostic>) = (Vec::new(), Vec::new());
        let mut row = 0;
        for batch in &batches {
            for text in texts(batch.column(index))? {
                if let Some(text) = text {
                    let of = checker.check_text(&text);
                    rows.extend(std::iter::repeat_n(row, of.len()));
                    found.extend(of);
                }
                row += 1;
            }
        }
        findings(rows, &found, lang)
    })
}

/// The values of a text column, whichever of Arrow's text types it has.
fn texts(column: &ArrayRef) -> PyResult<Vec<Option<String>>> {
    let owned = |t: Option<&str>| t.map(str::to_owned);
    match column.data_type() {
        DataType::Utf8 => Ok(column.as_string::<i32>().iter().map(owned).collect()),
        DataType::LargeUtf8 => Ok(column.as_string::<i64>().iter().map(owned).collect()),
        DataType::Utf8View => Ok(column.as_string_view().iter().map(owned).collect()),
        other => Err(PyTypeError::new_err(format!("the column holds {other}, not text"))),
    }
}

fn findings(rows: Vec<u64>, found: &[Diagnostic], lang: Lang) -> PyResult<Table> {
    let text = |of: &dyn Fn(&Diagnostic) -> Option<String>| -> ArrayRef {
        Arc::new(found.iter().map(of).collect::<StringArray>())
    };
    let severity = |d: &Diagnostic| serde_json::to_value(d.severity).ok()?.as_str().map(str::to_owned);
    let columns: Vec<(&str, ArrayRef)> = vec![
        ("row", Arc::new(UInt64Array::from(rows))),
        ("code", text(&|d| Some(d.code.to_owned()))),
        ("severity", text(&severity)),
        ("message", text(&|d| Some(d.message(lang).to_owned()))),
        ("hint", text(&|d| d.hint.as_ref().map(|h| h.get(lang).to_owned()))),
        ("location", text(&location)),
    ];
    let nullable = |name: &str| matches!(name, "hint" | "location");
    let fields: Vec<Field> =
        columns.iter().map(|(n, c)| Field::new(*n, c.data_type().clone(), nullable(n))).collect();
    let schema = Arc::new(Schema::new(fields));
    let arrays = columns.into_iter().map(|(_, c)| c).collect();
    let batch = RecordBatch::try_new(schema.clone(), arrays).map_err(of_arrow)?;
    Ok(Table::new(schema, vec![batch]))
}

fn language(text: &str) -> PyResult<Lang> {
    match text {
        "zh" => Ok(Lang::Zh),
        "en" => Ok(Lang::En),
        _ => Err(PyKeyError::new_err("lang is 'zh' or 'en'")),
    }
}
