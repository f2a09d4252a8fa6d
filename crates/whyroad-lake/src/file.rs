//! One table, one Parquet file: how it is written, and what is checked when it is read.

use crate::columns::{Table, TableBuilder};
use crate::{LAKE_VERSION, LakeError};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::Compression;
use parquet::file::metadata::{KeyValue, ParquetMetaData, RowGroupMetaData};
use parquet::file::properties::WriterProperties;
use std::fs::File;
use std::path::Path;

/// Order of the rows, as the file's metadata state it.
pub(crate) const ROW_ORDER_KEY: &str = "whyroad.row_order";
const VERSION_KEY: &str = "whyroad.lake_version";

/// Writes one table: one row group (so that any engine hands it out whole), Snappy, and the row order in the metadata.
pub(crate) fn write_table(path: &Path, table: TableBuilder, row_order: &str) -> Result<usize, LakeError> {
    let broken = |e: &dyn std::fmt::Display| LakeError::broken(path, e);
    let batch = table.finish().map_err(|e| broken(&e))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_max_row_group_row_count(None)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![
            KeyValue::new(VERSION_KEY.to_owned(), LAKE_VERSION.to_string()),
            KeyValue::new(ROW_ORDER_KEY.to_owned(), row_order.to_owned()),
        ]))
        .build();
    let file = File::create(path).map_err(LakeError::io(path))?;
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).map_err(|e| broken(&e))?;
    writer.write(&batch).map_err(|e| broken(&e))?;
    let file = writer.into_inner().map_err(|e| broken(&e))?;
    file.sync_all().map_err(LakeError::io(path))?;
    Ok(batch.num_rows())
}

/// Refuses metadata of a damaged file on which the Parquet reader would panic: columns that begin before the file or
/// have a negative length.
///
/// # Errors
/// Where a column chunk states a negative offset or length.
pub fn check_columns(metadata: &ParquetMetaData) -> Result<(), &'static str> {
    let damaged = metadata.row_groups().iter().flat_map(RowGroupMetaData::columns).any(|column| {
        let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
        start < 0 || column.compressed_size() < 0
    });
    if damaged { Err("a column has a negative offset or length") } else { Ok(()) }
}

/// Reads one table whole; `None` when the file does not exist (the log has no such table).
pub(crate) fn read_table(path: &Path, row_order: &str) -> Result<Option<Table>, LakeError> {
    let file = match File::open(path) {
        Ok(f) => f,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(LakeError::io(path)(e)),
    };
    let broken = |e: &dyn std::fmt::Display| LakeError::broken(path, e);
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| broken(&e))?;
    check_columns(builder.metadata()).map_err(|e| broken(&e))?;
    let metadata = builder.metadata().file_metadata();
    let value = |key: &str| {
        let found = metadata.key_value_metadata()?.iter().find(|kv| kv.key == key)?;
        found.value.clone()
    };
    match value(VERSION_KEY).and_then(|v| v.parse::<u32>().ok()) {
        Some(LAKE_VERSION) => {}
        Some(found) => return Err(LakeError::version(path, found, Vec::new())),
        None => return Err(broken(&"the file does not state its lake version")),
    }
    match value(ROW_ORDER_KEY) {
        Some(order) if order == row_order => {}
        other => return Err(broken(&format!("row order is {other:?}, expected '{row_order}'"))),
    }
    if builder.metadata().num_row_groups() > 1 {
        return Err(broken(&"more than one row group: the rows of a drive must be one"));
    }
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(0);
    let schema = builder.schema().clone();
    let mut reader = builder.with_batch_size(rows.max(1)).build().map_err(|e| broken(&e))?;
    let batch = match reader.next() {
        Some(batch) => batch.map_err(|e| broken(&e))?,
        None => arrow_array::RecordBatch::new_empty(schema),
    };
    if batch.num_rows() != rows {
        return Err(broken(&format!("{} of {rows} rows can be read", batch.num_rows())));
    }
    Ok(Some(Table { path: path.to_owned(), batch }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::frames;

    #[test]
    fn a_column_with_a_negative_offset_is_refused() {
        // Found by the fuzz target `lake-frames`; the Parquet reader panics on it.
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), include_bytes!("../tests/fixtures/negative_offset.parquet")).unwrap();
        let Err(e) = read_table(file.path(), frames::ROW_ORDER) else { panic!("it was read") };
        assert_eq!(e.code(), "lake.table_broken");
    }
}
