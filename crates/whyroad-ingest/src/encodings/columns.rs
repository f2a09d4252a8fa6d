//! Columns of others' tables (Arrow record batches, from whatever file), read by name and brought to the type that is
//! asked for.

use super::{cells, compressed};
use crate::file_reader::FileReader;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::DataType;
use bytes::Bytes;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use std::collections::HashMap;
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
    let mut left = compressed::limit(source.len());
    let builder = ParquetRecordBatchReaderBuilder::try_new(source).map_err(|e| e.to_string())?;
    whyroad_lake::check_columns(builder.metadata())?;
    let mut reader = builder.build().map_err(|e| e.to_string())?;
    let mut batches = Vec::new();
    while let Some(batch) = whyroad_lake::next_batch(&mut reader)? {
        // Equal values of any number of rows take a few bytes in a file.
        left = left
            .checked_sub(batch.get_array_memory_size() as u64)
            .ok_or("it unpacks to far more than a table of this size can hold")?;
        batches.push(batch);
    }
    Ok(Columns(batches))
}

impl Columns {
    /// Tries to read every column as each type; false without columns.
    fn read_all(&self) -> bool {
        let names = self.names();
        for name in &names {
            drop((self.numbers(name), self.integers(name), self.texts(name), self.words(name)));
        }
        !names.is_empty()
    }

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

    /// A column, batch by batch; `read` appends the cells of a batch.
    fn cells<T>(
        &self,
        name: &str,
        mut read: impl FnMut(&ArrayRef, &mut Vec<T>) -> Result<(), String>,
    ) -> Result<Vec<T>, String> {
        let mut out = Vec::with_capacity(self.rows());
        for batch in &self.0 {
            let column = batch.column_by_name(name).ok_or_else(|| format!("column '{name}' is missing"))?;
            read(column, &mut out).map_err(|e| format!("column '{name}': {e}"))?;
        }
        Ok(out)
    }

    /// True when the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.0.first().is_some_and(|b| b.column_by_name(name).is_some())
    }

    /// True where the column's type is a date or a time since 1970.
    pub fn has_times(&self, name: &str) -> bool {
        let kind = self.0.first().and_then(|b| Some(b.column_by_name(name)?.data_type().clone()));
        matches!(kind, Some(DataType::Timestamp(_, _) | DataType::Date32 | DataType::Date64))
    }

    /// A column of numbers; null is NaN.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        self.cells(name, |column, out| {
            // The two most common types of measurement tables need no check of each cell.
            if let Some(floats) = column.as_primitive_opt::<Float64Type>() {
                match floats.null_count() {
                    0 => out.extend_from_slice(floats.values()),
                    _ => out.extend(floats.iter().map(|v| v.unwrap_or(f64::NAN))),
                }
            } else if let Some(integers) = column.as_primitive_opt::<Int64Type>() {
                out.extend(integers.iter().map(|v| v.map_or(f64::NAN, |v| v as f64)));
            } else {
                out.extend(cells::numbers(column)?.into_iter().map(|v| v.unwrap_or(f64::NAN)));
            }
            Ok(())
        })
    }

    /// A column of integers.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, String> {
        self.cells(name, |column, out| {
            match column.as_primitive_opt::<Int64Type>() {
                Some(integers) => out.extend(integers.iter()),
                None => out.extend(cells::integers(column)?),
            }
            Ok(())
        })
    }

    /// A column of texts, whatever their encoding.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<String>>, String> {
        let mut left = cells::FREE_TEXT;
        self.cells(name, |column, out| {
            out.extend(cells::texts(column, &mut left)?);
            Ok(())
        })
    }

    /// The same with times as nanoseconds since 1970.
    pub fn nanosecond_texts(&self, name: &str) -> Result<Vec<Option<String>>, String> {
        let mut left = cells::FREE_TEXT;
        self.cells(name, |column, out| {
            out.extend(cells::nanosecond_texts(column, &mut left)?);
            Ok(())
        })
    }

    /// A column of texts of which there are few, each held once.
    pub fn words(&self, name: &str) -> Result<Words, String> {
        let (mut texts, mut numbers) = (Vec::<String>::new(), HashMap::<Box<str>, usize>::new());
        // Of each text, the one that came after it last time: mostly it does again, as objects of one frame and the
        // next do, and a comparison is enough.
        let (mut after, mut before) = (Vec::<usize>::new(), 0);
        let mut number = |text: &str| {
            let expected =
                after.get(before).copied().filter(|next| texts.get(*next).is_some_and(|t| t == text));
            let number = expected.or_else(|| numbers.get(text).copied()).unwrap_or_else(|| {
                let new = texts.len();
                texts.push(text.to_owned());
                after.push(new);
                numbers.insert(text.into(), new);
                new
            });
            if let Some(next) = after.get_mut(before) {
                *next = number;
            }
            before = number;
            number
        };
        let mut rows = Vec::with_capacity(self.rows());
        for batch in &self.0 {
            let column = batch.column_by_name(name).ok_or_else(|| format!("column '{name}' is missing"))?;
            match column.as_string_opt::<i32>() {
                Some(texts) => rows.extend(texts.iter().map(|text| text.map(&mut number))),
                None => {
                    let texts = cells::texts(column, &mut { cells::FREE_TEXT })
                        .map_err(|e| format!("column '{name}': {e}"))?;
                    rows.extend(texts.iter().map(|text| text.as_deref().map(&mut number)));
                }
            }
        }
        Ok(Words { texts, rows })
    }
}

/// A column of repeated texts: each text once, and an index per row.
pub(crate) struct Words {
    /// The texts, in the order of their first rows.
    pub texts: Vec<String>,
    /// Index into `texts` of each row; `None` is null.
    pub rows: Vec<Option<usize>>,
}

/// For [`crate::readers`].
pub(crate) const PARQUET: FileReader = FileReader {
    name: "parquet",
    read: |bytes| {
        let columns = read_parquet_bytes(bytes.to_vec());
        columns.is_ok_and(|columns| columns.read_all() && crate::rows::of_columns(&columns, None).len() > 1)
    },
};

/// For [`crate::readers`].
pub(crate) const FEATHER: FileReader = FileReader {
    name: "feather",
    read: |bytes| super::feather::read(bytes).is_ok_and(|feather| feather.columns.read_all()),
};

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::{Float64Array, RecordBatch};
    use parquet::arrow::ArrowWriter;
    use std::sync::Arc;

    fn file(rows: usize) -> Vec<u8> {
        let some = rows.min(1_000_000);
        let column: ArrayRef = Arc::new(Float64Array::from(vec![1.0; some]));
        let batch = RecordBatch::try_from_iter([("x", column)]).unwrap();
        let mut out = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut out, batch.schema(), None).unwrap();
        (0..rows / some).for_each(|_| writer.write(&batch).unwrap());
        writer.close().unwrap();
        out
    }

    /// 20 million equal numbers are 160 MB in a file of some kB.
    #[test]
    fn a_file_that_unpacks_to_far_more_than_its_size_is_refused() {
        let bomb = file(20_000_000);
        assert!(bomb.len() < 200_000, "{}", bomb.len());
        assert!(read_parquet_bytes(bomb).err().is_some_and(|e| e.contains("unpacks")));
        assert!(read_parquet_bytes(file(100_000)).is_ok());
    }
}
