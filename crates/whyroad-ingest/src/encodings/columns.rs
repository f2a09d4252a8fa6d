//! Columns of others' tables (Arrow record batches, from whatever file), read by name and brought to the type that is
//! asked for.

use super::cells;
use arrow_array::{Array, RecordBatch};
use bytes::Bytes;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use std::fs::File;
use std::path::Path;

/// A table, batch by batch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns(pub Vec<RecordBatch>);

/// Reads a whole Parquet file.
pub(crate) fn read_parquet(path: &Path) -> Result<Columns, String> {
    read_batches(File::open(path).map_err(|e| e.to_string())?)
}

/// Reads a whole Parquet file from memory.
pub(crate) fn read_parquet_bytes(content: Vec<u8>) -> Result<Columns, String> {
    read_batches(Bytes::from(content))
}

fn read_batches(source: impl ChunkReader + 'static) -> Result<Columns, String> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(source).map_err(|e| e.to_string())?;
    whyroad_lake::check_columns(builder.metadata())?;
    let mut reader = builder.build().map_err(|e| e.to_string())?;
    let mut batches = Vec::new();
    while let Some(batch) = whyroad_lake::next_batch(&mut reader)? {
        batches.push(batch);
    }
    Ok(Columns(batches))
}

impl Columns {
    /// Names of the columns, in the file's order.
    pub fn names(&self) -> Vec<String> {
        self.0
            .first()
            .map_or_else(Vec::new, |b| b.schema().fields().iter().map(|f| f.name().clone()).collect())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.0.iter().map(RecordBatch::num_rows).sum()
    }

    /// The cells of a column, batch by batch.
    fn cells<T>(
        &self,
        name: &str,
        read: impl Fn(&dyn Array) -> Result<Vec<Option<T>>, String>,
    ) -> Result<Vec<Option<T>>, String> {
        let mut out = Vec::with_capacity(self.rows());
        for batch in &self.0 {
            let column = batch.column_by_name(name).ok_or_else(|| format!("column '{name}' is missing"))?;
            out.extend(read(column.as_ref()).map_err(|e| format!("column '{name}': {e}"))?);
        }
        Ok(out)
    }

    /// True when the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.0.first().is_some_and(|b| b.column_by_name(name).is_some())
    }

    /// A column of numbers; null is NaN.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        Ok(self.cells(name, cells::numbers)?.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
    }

    /// A column of integers.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, String> {
        self.cells(name, cells::integers)
    }

    /// A column of texts, whatever their encoding.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<String>>, String> {
        self.cells(name, cells::texts)
    }
}
