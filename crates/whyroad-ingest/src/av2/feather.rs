//! Feather (Arrow IPC) files as AV2 writes them, read column by column. A file that was cut short keeps its
//! readable record batches.

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, RecordBatch};
use arrow_ipc::reader::{FileReader, StreamReader};
use arrow_schema::DataType;
use std::io::Cursor;

/// What could be read of a feather file.
pub(super) struct Feather {
    pub batches: Vec<RecordBatch>,
    /// Set when the file ends before its footer: what the reader said.
    pub truncated: Option<String>,
}

const MAGIC: &[u8] = b"ARROW1";

/// Reads all record batches. `Err` when it is no Arrow file at all.
pub(super) fn read(bytes: &[u8]) -> Result<Feather, String> {
    if !bytes.starts_with(MAGIC) {
        return Err("the file does not begin as an Arrow IPC (feather) file".to_owned());
    }
    let whole = FileReader::try_new(Cursor::new(bytes), None).and_then(|r| r.collect::<Result<Vec<_>, _>>());
    let reason = match whole {
        Ok(batches) => return Ok(Feather { batches, truncated: None }),
        Err(e) => e.to_string(),
    };
    // The file format is a stream between two magic words, so what stands before the cut can be read as a stream.
    // Zeros pad the first word to 8 bytes (C++) or 64 (Rust); the stream begins with 0xFFFFFFFF.
    let start = bytes.iter().skip(MAGIC.len()).position(|b| *b != 0).map_or(bytes.len(), |p| p + MAGIC.len());
    let mut batches = Vec::new();
    if let Ok(stream) = StreamReader::try_new(Cursor::new(&bytes[start..]), None) {
        batches.extend(stream.map_while(Result::ok));
    }
    Ok(Feather { batches, truncated: Some(reason) })
}

impl Feather {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    fn cast(&self, name: &str, to: &DataType) -> Result<Vec<arrow_array::ArrayRef>, String> {
        self.batches
            .iter()
            .map(|b| {
                let column = b.column_by_name(name).ok_or_else(|| format!("column '{name}' is missing"))?;
                arrow_cast::cast(column, to).map_err(|e| format!("column '{name}': {e}"))
            })
            .collect()
    }

    /// True when the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.batches.first().is_some_and(|b| b.column_by_name(name).is_some())
    }

    /// A column of numbers; null is NaN.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        let arrays = self.cast(name, &DataType::Float64)?;
        Ok(arrays
            .iter()
            .flat_map(|a| a.as_primitive::<Float64Type>().iter().map(|v| v.unwrap_or(f64::NAN)))
            .collect())
    }

    /// A column of integers.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, String> {
        let arrays = self.cast(name, &DataType::Int64)?;
        Ok(arrays.iter().flat_map(|a| a.as_primitive::<Int64Type>().iter()).collect())
    }

    /// A column of texts, whatever their encoding.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<String>>, String> {
        let arrays = self.cast(name, &DataType::Utf8)?;
        Ok(arrays
            .iter()
            .flat_map(|a| {
                let a = a.as_string::<i32>();
                (0..a.len()).map(move |i| (!a.is_null(i)).then(|| a.value(i).to_owned()))
            })
            .collect())
    }
}
