//! Tables of the stages: one row per candidate, kept or dropped with the reason.

use crate::DatasetError;
use arrow_schema::{DataType, Field, FieldRef, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use serde::Serialize;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Rows written at once.
const ROWS: usize = 10_000;

/// A row of a stage's table.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StageRow {
    pub sample_id: Option<String>,
    pub drive_id: Option<String>,
    pub keyframe_time_ns: Option<i64>,
    pub scenario_id: String,
    pub label_status: Option<String>,
    pub split: Option<String>,
    pub component: Option<u32>,
    pub weight: Option<f64>,
    pub kept: bool,
    pub reason: Option<String>,
    pub detail: Option<String>,
}

/// Columns of [`StageRow`].
pub(crate) fn stage_columns() -> Vec<(&'static str, DataType)> {
    vec![
        ("sample_id", DataType::Utf8),
        ("drive_id", DataType::Utf8),
        ("keyframe_time_ns", DataType::Int64),
        ("scenario_id", DataType::Utf8),
        ("label_status", DataType::Utf8),
        ("split", DataType::Utf8),
        ("component", DataType::UInt32),
        ("weight", DataType::Float64),
        ("kept", DataType::Boolean),
        ("reason", DataType::Utf8),
        ("detail", DataType::Utf8),
    ]
}

/// How all files of a release are written.
pub(crate) fn properties(rows_per_group: usize) -> WriterProperties {
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_max_row_group_row_count(Some(rows_per_group))
        .build()
}

/// Writes rows as Parquet.
pub(crate) fn write<T: Serialize>(
    path: &Path,
    columns: Vec<(&'static str, DataType)>,
    rows: impl Iterator<Item = T>,
) -> Result<(), DatasetError> {
    let broken = |e: &dyn std::fmt::Display| DatasetError::broken(path, e);
    let fields: Vec<FieldRef> =
        columns.into_iter().map(|(name, kind)| Arc::new(Field::new(name, kind, true))).collect();
    let file = File::create(path).map_err(DatasetError::io(path))?;
    let schema = Arc::new(Schema::new(fields.clone()));
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties(ROWS))).map_err(|e| broken(&e))?;
    let mut waiting: Vec<T> = Vec::new();
    let flush = |waiting: &mut Vec<T>, writer: &mut ArrowWriter<File>| -> Result<(), DatasetError> {
        let batch = serde_arrow::to_record_batch(&fields, waiting).map_err(|e| broken(&e))?;
        waiting.clear();
        writer.write(&batch).map_err(|e| broken(&e))
    };
    for row in rows {
        waiting.push(row);
        if waiting.len() >= ROWS {
            flush(&mut waiting, &mut writer)?;
        }
    }
    if !waiting.is_empty() {
        flush(&mut waiting, &mut writer)?;
    }
    writer.close().map_err(|e| broken(&e))?;
    Ok(())
}
