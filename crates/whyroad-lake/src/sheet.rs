//! Small tables of results for other programs: the same rows as CSV (RFC 4180) and as Parquet. Unknown is an empty
//! field in CSV and null in Parquet.

use crate::LakeError;
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A table in memory; all columns have one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Name of the file without its ending.
    pub name: &'static str,
    /// Columns in order.
    pub columns: Vec<SheetColumn>,
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetColumn {
    /// Its name, with the unit where it has one: `worked_h`.
    pub name: &'static str,
    /// Its values.
    pub values: SheetValues,
}

/// Values of a column; `None` is unknown.
#[derive(Clone, Debug, PartialEq)]
pub enum SheetValues {
    /// Texts.
    Texts(Vec<Option<String>>),
    /// Whole numbers.
    Integers(Vec<Option<i64>>),
    /// Numbers.
    Numbers(Vec<Option<f64>>),
    /// Yes or no.
    Flags(Vec<Option<bool>>),
}

impl SheetValues {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Texts(v) => v.len(),
            Self::Integers(v) => v.len(),
            Self::Numbers(v) => v.len(),
            Self::Flags(v) => v.len(),
        }
    }

    /// True without values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn csv(&self, row: usize) -> String {
        match self {
            Self::Texts(v) => v[row].as_deref().map(quoted).unwrap_or_default(),
            Self::Integers(v) => v[row].map(|n| n.to_string()).unwrap_or_default(),
            Self::Numbers(v) => v[row].filter(|n| n.is_finite()).map(|n| n.to_string()).unwrap_or_default(),
            Self::Flags(v) => v[row].map(|n| n.to_string()).unwrap_or_default(),
        }
    }

    fn array(&self) -> ArrayRef {
        match self {
            Self::Texts(v) => Arc::new(v.iter().cloned().collect::<StringArray>()),
            Self::Integers(v) => Arc::new(v.iter().copied().collect::<Int64Array>()),
            Self::Numbers(v) => {
                Arc::new(v.iter().map(|n| n.filter(|n| n.is_finite())).collect::<Float64Array>())
            }
            Self::Flags(v) => Arc::new(v.iter().copied().collect::<BooleanArray>()),
        }
    }
}

/// A text as a CSV field. An empty text is quoted, so that it is not read as unknown.
fn quoted(text: &str) -> String {
    let plain = !text.is_empty() && !text.contains([',', '"', '\n', '\r']);
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

impl Sheet {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The table as CSV, with a line of names.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|c| c.name).collect();
        let mut out = names.join(",") + "\n";
        for row in 0..self.rows() {
            let fields: Vec<String> = self.columns.iter().map(|c| c.values.csv(row)).collect();
            out += &fields.join(",");
            out.push('\n');
        }
        out
    }

    /// Writes `<dir>/<name>.csv` and `<dir>/<name>.parquet`; the files.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, dir: &Path) -> Result<[PathBuf; 2], LakeError> {
        fs::create_dir_all(dir).map_err(LakeError::io(dir))?;
        let csv = dir.join(format!("{}.csv", self.name));
        fs::write(&csv, self.csv()).map_err(LakeError::io(&csv))?;
        let path = dir.join(format!("{}.parquet", self.name));
        let broken = |e: &dyn std::fmt::Display| LakeError::broken(&path, e);
        let columns = self.columns.iter().map(|c| (c.name, c.values.array(), true));
        let batch = RecordBatch::try_from_iter_with_nullable(columns).map_err(|e| broken(&e))?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
            .build();
        let file = File::create(&path).map_err(LakeError::io(&path))?;
        let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties))
            .map_err(LakeError::unwritten(&path))?;
        writer.write(&batch).map_err(LakeError::unwritten(&path))?;
        writer.close().map_err(LakeError::unwritten(&path))?;
        Ok([csv, path])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

    fn sheet() -> Sheet {
        let column = |name, values| SheetColumn { name, values };
        Sheet {
            name: "t",
            columns: vec![
                column(
                    "text",
                    SheetValues::Texts(vec![Some("a,\"b\"\n中".into()), None, Some(String::new())]),
                ),
                column("n", SheetValues::Integers(vec![Some(-1), None, Some(2)])),
                column("x", SheetValues::Numbers(vec![Some(0.5), None, Some(f64::NAN)])),
                column("yes", SheetValues::Flags(vec![Some(true), None, Some(false)])),
            ],
        }
    }

    #[test]
    fn csv_is_quoted_and_unknown_is_empty() {
        assert_eq!(sheet().csv(), "text,n,x,yes\n\"a,\"\"b\"\"\n中\",-1,0.5,true\n,,,\n\"\",2,,false\n");
    }

    #[test]
    fn parquet_has_the_same_rows_and_null_for_unknown() {
        let dir = tempfile::tempdir().unwrap();
        let [_, path] = sheet().write(dir.path()).unwrap();
        let reader =
            ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap().build().unwrap();
        let batch = reader.map(Result::unwrap).next().unwrap();
        assert_eq!((batch.num_rows(), batch.num_columns()), (3, 4));
        let nulls: Vec<usize> = batch.columns().iter().map(|c| c.null_count()).collect();
        assert_eq!(nulls, [1, 1, 2, 1]);
    }

    #[test]
    fn a_table_without_rows_keeps_its_columns() {
        let dir = tempfile::tempdir().unwrap();
        let mut empty = sheet();
        empty.columns.truncate(1);
        empty.columns[0].values = SheetValues::Texts(vec![]);
        let [csv, _] = empty.write(dir.path()).unwrap();
        assert_eq!(fs::read_to_string(csv).unwrap(), "text\n");
    }
}
