//! Small Parquet files in memory, with the index that pandas restores.

use crate::DatasetError;
use crate::freeze::tables::properties;
use arrow_array::{ArrayRef, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Columns by name; all are nullable.
pub(super) type Columns = Vec<(String, ArrayRef)>;

/// The bytes of a Parquet file. `index` names the column that pandas takes as the index of its rows.
pub(super) fn bytes(columns: Columns, index: Option<&str>) -> Result<Vec<u8>, DatasetError> {
    let broken = |e: &dyn std::fmt::Display| DatasetError::broken(Path::new("export"), e);
    let fields: Vec<Field> =
        columns.iter().map(|(n, c)| Field::new(n, c.data_type().clone(), true)).collect();
    let metadata = index.map(|index| ("pandas".to_owned(), pandas(&fields, index).to_string()));
    let schema = Arc::new(Schema::new_with_metadata(
        fields,
        metadata.into_iter().collect::<HashMap<String, String>>(),
    ));
    let arrays = columns.into_iter().map(|(_, c)| c).collect();
    let batch = RecordBatch::try_new(schema.clone(), arrays).map_err(|e| broken(&e))?;
    let mut out = Vec::new();
    let mut writer =
        ArrowWriter::try_new(&mut out, schema, Some(properties(1 << 16))).map_err(|e| broken(&e))?;
    writer.write(&batch).map_err(|e| broken(&e))?;
    writer.close().map_err(|e| broken(&e))?;
    Ok(out)
}

/// What pandas writes into a file's metadata to find its index again.
fn pandas(fields: &[Field], index: &str) -> Value {
    let columns: Vec<Value> = fields
        .iter()
        .map(|f| {
            let (kind, numpy) = match f.data_type() {
                DataType::Utf8 => ("unicode", "object"),
                DataType::Int64 => ("int64", "int64"),
                DataType::Float64 => ("float64", "float64"),
                DataType::Boolean => ("bool", "bool"),
                _ => ("object", "object"),
            };
            json!({
                "name": f.name(),
                "field_name": f.name(),
                "pandas_type": kind,
                "numpy_type": numpy,
                "metadata": null,
            })
        })
        .collect();
    json!({
        "index_columns": [index],
        "column_indexes": [],
        "columns": columns,
        "pandas_version": "2.0.0",
    })
}
