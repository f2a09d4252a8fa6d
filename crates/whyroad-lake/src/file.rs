//! One table, one Parquet file: how it is written, and what is checked when it is read.

use crate::chunks::{Cells, ChunkWriter, Source, runs_of};
use crate::columns::{Stored, Table, TableBuilder};
use crate::{LAKE_VERSION, LakeError};
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, RecordBatch};
use arrow_schema::{DataType, SchemaRef};
use bytes::Bytes;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::Compression;
use parquet::file::metadata::{KeyValue, ParquetMetaData, RowGroupMetaData};
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::file::reader::ChunkReader;
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnPath;
use std::collections::HashSet;
use std::fs::File;
use std::hash::{BuildHasherDefault, Hasher};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use whyroad_model::Nanos;

/// Order of the rows, as the file's metadata state it.
pub(crate) const ROW_ORDER_KEY: &str = "whyroad.row_order";
const VERSION_KEY: &str = "whyroad.lake_version";

/// Minimum average number of consecutive rows with the same text for a column to be written as runs.
const LEAST_RUN_ROWS: usize = 4;

/// How tables are written; `more` is metadata beside the version and the order of the rows.
pub(crate) fn properties(row_order: &str, more: Vec<KeyValue>) -> WriterPropertiesBuilder {
    let stated = [
        KeyValue::new(VERSION_KEY.to_owned(), LAKE_VERSION.to_string()),
        KeyValue::new(ROW_ORDER_KEY.to_owned(), row_order.to_owned()),
    ];
    WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_max_row_group_row_count(None)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(stated.into_iter().chain(more).collect()))
}

/// Writes one table: one row group (so that any engine returns it whole), Snappy, and the row order in the metadata.
pub(crate) fn write_table(path: &Path, table: TableBuilder, row_order: &str) -> Result<usize, LakeError> {
    let mut properties = properties(row_order, vec![]);
    if let Some(rows) = flat_rows(&table) {
        let properties = properties.set_statistics_enabled(EnabledStatistics::Chunk);
        let mut writer = ChunkWriter::create(path, &table.schema(), properties.build())?;
        let runs: Vec<Vec<(&str, usize)>> =
            table.columns().map(|(_, column)| borrowed_runs(column)).collect();
        let cells = table.columns().zip(&runs).map(|((_, column), runs)| match column {
            Stored::Array(array) => Cells::Array(array),
            Stored::Runs(_) => Cells::Runs(runs),
        });
        writer.row_group(rows, &cells.map(Source::Cells).collect::<Vec<_>>())?;
        writer.finish()?;
        return Ok(rows);
    }
    let batch = table.finish().map_err(|e| LakeError::broken(path, e))?;
    for (field, column) in batch.schema().fields().iter().zip(batch.columns()) {
        if column.as_primitive_opt::<Float64Type>().is_some_and(|numbers| !repeats(numbers.values())) {
            let path = ColumnPath::from(field.name().as_str());
            properties = properties.set_column_dictionary_enabled(path, false);
        }
    }
    write_batches(path, &batch.schema(), [&batch], properties.build())?;
    Ok(batch.num_rows())
}

/// The number of rows of a table that can be written without Arrow's writer. `None` for other tables, which mostly have
/// few rows.
fn flat_rows(table: &TableBuilder) -> Option<usize> {
    table.rows().filter(|rows| *rows > 0 && table.columns().all(|(_, column)| is_flat(column)))
}

/// True for a column that can be written without Arrow's writer: it is not nested, and texts hardly change from row to
/// row.
fn is_flat(column: &Stored) -> bool {
    match column {
        Stored::Array(array) => match array.data_type() {
            DataType::Float64 | DataType::Int64 | DataType::UInt32 | DataType::Boolean => true,
            DataType::Utf8 if array.null_count() == array.len() => array.len() >= LEAST_RUN_ROWS,
            DataType::Utf8 => runs_of(array.as_string()).count() * LEAST_RUN_ROWS <= array.len(),
            _ => false,
        },
        Stored::Runs(runs) => runs.len() * LEAST_RUN_ROWS <= column.rows(),
    }
}

fn borrowed_runs(column: &Stored) -> Vec<(&str, usize)> {
    match column {
        Stored::Array(_) => Vec::new(),
        Stored::Runs(runs) => runs.iter().map(|(text, rows)| (text.as_str(), *rows)).collect(),
    }
}

/// True where values repeat often enough that a dictionary is shorter than the values, and faster to read.
pub(crate) fn repeats(values: &[f64]) -> bool {
    let sample = &values[..values.len().min(8192)];
    // Capacity for the maximum number of distinct values here.
    let room = sample.len() / 8 + 1;
    let (mut distinct, mut last) = (HashSet::with_capacity_and_hasher(room, Mixing::default()), None);
    // For most columns the first few rows decide.
    !sample.is_empty()
        && sample.iter().map(|x| x.to_bits()).all(|bits| {
            // Mostly it is the value of the row before.
            if last.replace(bits) != Some(bits) {
                distinct.insert(bits);
            }
            distinct.len() * 8 < sample.len()
        })
}

/// Hashes the bits of numbers, which nobody chooses to collide: this only determines how a column is stored.
type Mixing = BuildHasherDefault<Mixed>;

#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, bits: u64) {
        // The high bits of a product depend on all bits; the table reads both ends.
        let product = (self.0 ^ bits ^ bits >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ product >> 32;
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// Writes a file that is on disk when this returns; every batch begins a row group.
pub(crate) fn write_batches<'a>(
    path: &Path,
    schema: &SchemaRef,
    batches: impl IntoIterator<Item = &'a RecordBatch>,
    properties: WriterProperties,
) -> Result<(), LakeError> {
    let file = File::create(path).map_err(LakeError::io(path))?;
    let unwritten = || LakeError::unwritten(path);
    let mut writer = ArrowWriter::try_new(file, schema.clone(), Some(properties)).map_err(unwritten())?;
    for batch in batches {
        writer.write(batch).and_then(|()| writer.flush()).map_err(unwritten())?;
    }
    let file = writer.into_inner().map_err(unwritten())?;
    file.sync_all().map_err(LakeError::io(path))
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

/// The next rows of a Parquet file; `None` at its end. A reader that failed would fail again: it must not be used
/// again.
///
/// # Errors
/// Where the file is damaged, including damage on which the Parquet library panics: pages that contradict each other.
pub fn next_batch(reader: &mut ParquetRecordBatchReader) -> Result<Option<RecordBatch>, String> {
    match catch_unwind(AssertUnwindSafe(|| reader.next().transpose())) {
        Ok(batch) => batch.map_err(|e| e.to_string()),
        Err(_) => Err("its pages contradict each other".to_owned()),
    }
}

/// The footer of a file, checked; `None` when the file does not exist.
pub(crate) fn open(path: &Path, row_order: &str) -> Result<Option<(File, ArrowReaderMetadata)>, LakeError> {
    let file = match File::open(path) {
        Ok(f) => f,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(LakeError::io(path)(e)),
    };
    let footer = checked_footer(path, &file, row_order)?;
    Ok(Some((file, footer)))
}

/// The footer of a table from any source, checked; `path` is its name.
fn checked_footer(
    path: &Path,
    source: &impl ChunkReader,
    row_order: &str,
) -> Result<ArrowReaderMetadata, LakeError> {
    let broken = |e: &dyn std::fmt::Display| LakeError::broken(path, e);
    let footer = ArrowReaderMetadata::load(source, ArrowReaderOptions::new()).map_err(|e| broken(&e))?;
    check_columns(footer.metadata()).map_err(|e| broken(&e))?;
    match stated(&footer, VERSION_KEY).and_then(|v| v.parse::<u32>().ok()) {
        Some(LAKE_VERSION) => {}
        Some(found) => return Err(LakeError::version(path, found, Vec::new())),
        None => return Err(broken(&"the file does not state its lake version")),
    }
    match stated(&footer, ROW_ORDER_KEY) {
        Some(order) if order == row_order => {}
        other => return Err(broken(&format!("row order is {other:?}, expected '{row_order}'"))),
    }
    Ok(footer)
}

/// A value of the file's metadata.
pub(crate) fn stated(footer: &ArrowReaderMetadata, key: &str) -> Option<String> {
    let all = footer.metadata().file_metadata().key_value_metadata()?;
    all.iter().find(|kv| kv.key == key)?.value.clone()
}

/// Reads one table whole; `None` when the file does not exist (the log has no such table).
pub(crate) fn read_table(path: &Path, row_order: &str) -> Result<Option<Table>, LakeError> {
    let Some((file, footer)) = open(path, row_order)? else { return Ok(None) };
    read_whole(path, file, footer).map(Some)
}

/// [`read_table`] of bytes in memory.
pub(crate) fn read_table_bytes(bytes: &[u8], row_order: &str) -> Result<Table, LakeError> {
    let (path, source) = (Path::new("memory"), Bytes::copy_from_slice(bytes));
    let footer = checked_footer(path, &source, row_order)?;
    read_whole(path, source, footer)
}

/// All rows of a file of which a footer was read.
fn read_whole(
    path: &Path,
    source: impl ChunkReader + 'static,
    footer: ArrowReaderMetadata,
) -> Result<Table, LakeError> {
    if footer.metadata().num_row_groups() > 1 {
        let reason = "more than one row group: the rows of a drive must be one";
        return Err(LakeError::broken(path, reason));
    }
    let groups = (0..footer.metadata().num_row_groups()).collect();
    read_groups(path, source, footer, groups)
}

/// Reads these row groups of an opened file as one table.
pub(crate) fn read_groups(
    path: &Path,
    source: impl ChunkReader + 'static,
    footer: ArrowReaderMetadata,
    groups: Vec<usize>,
) -> Result<Table, LakeError> {
    let broken = |e: &dyn std::fmt::Display| LakeError::broken(path, e);
    let stated: i64 = groups.iter().map(|g| footer.metadata().row_group(*g).num_rows()).sum();
    let rows = usize::try_from(stated).unwrap_or(0);
    let schema = footer.schema().clone();
    let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(source, footer).with_row_groups(groups);
    let mut reader = builder.with_batch_size(rows.max(1)).build().map_err(|e| broken(&e))?;
    let batch = next_batch(&mut reader).map_err(|e| broken(&e))?;
    let batch = batch.unwrap_or_else(|| RecordBatch::new_empty(schema));
    if batch.num_rows() != rows {
        return Err(broken(&format!("{} of {rows} rows can be read", batch.num_rows())));
    }
    Ok(Table { path: path.to_owned(), batch })
}

/// Least and greatest time in a row group of frames, by its statistics.
pub(crate) fn span(
    path: &Path,
    metadata: &ParquetMetaData,
    group: Option<usize>,
) -> Result<(Nanos, Nanos), LakeError> {
    let group = group.and_then(|g| metadata.row_groups().get(g));
    let times = group.and_then(|g| g.columns().iter().find(|c| c.column_path().parts() == ["time_ns"]));
    match times.and_then(|t| t.statistics()) {
        Some(Statistics::Int64(s)) => {
            let known = s.min_opt().copied().zip(s.max_opt().copied());
            known.map(|(a, b)| (Nanos(a), Nanos(b)))
        }
        _ => None,
    }
    .ok_or_else(|| LakeError::broken(path, "the file does not state the range of its times"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::frames;

    /// A table of all types of columns, with missing values where they can have them.
    fn table(rows: usize, texts: bool) -> TableBuilder {
        let word =
            move |i: usize| if texts { format!("row {i}") } else { ["near", "far"][i / 50 % 2].to_owned() };
        TableBuilder::default()
            .texts("always", (0..rows).map(word))
            .texts_or_null(
                "sometimes",
                (0..rows).map(|i| (i / 40 % 3 > 0).then(|| format!("part {}", i / 1000))),
            )
            .texts_or_null("never", (0..rows).map(|_| None::<&str>))
            .text_runs(
                "run",
                (0..rows).step_by(30).map(|i| (["one", "one", "two"][i / 30 % 3], 30.min(rows - i))),
            )
            .indices("index", (0..rows).map(|i| i as u32 % 1000))
            .integers("time", (0..rows).map(|i| i as i64 * 100_000_000 - 5))
            .integers_or_null("later", (0..rows).map(|i| (i % 7 == 0).then_some(i as i64)))
            .integers_or_null("no_later", (0..rows).map(|_| None))
            .numbers("number", (0..rows).map(|i| (i as f64 * 0.37).sin()))
            .numbers("known_at_times", (0..rows).map(|i| if i % 3 == 0 { f64::NAN } else { i as f64 }))
            .numbers("repeated", (0..rows).map(|i| f64::from(u8::try_from(i % 4).unwrap())))
            .numbers("unknown", (0..rows).map(|_| f64::NAN))
            .flags("flag", (0..rows).map(|i| [Some(true), None, Some(false)][i / 5 % 3]))
            .flags("no_flag", (0..rows).map(|_| None))
    }

    #[test]
    fn what_is_written_without_arrows_writer_is_what_it_would_have_written() {
        for (rows, texts) in [(1, false), (300, false), (150_000, false), (300, true)] {
            let written = table(rows, texts).finish().unwrap();
            let is_flat = flat_rows(&table(rows, texts)).is_some();
            assert_eq!(is_flat, rows >= 300 && !texts, "{rows} rows");
            let file = tempfile::NamedTempFile::new().unwrap();
            write_table(file.path(), table(rows, texts), frames::ROW_ORDER).unwrap();
            let read = read_table(file.path(), frames::ROW_ORDER).unwrap().unwrap().batch;
            assert_eq!(read, written, "{rows} rows");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_of_the_file_system() {
        // `/dev/full` refuses every write as a full disk does.
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("frames.parquet");
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        for texts in [false, true] {
            let e = write_table(&path, table(100_000, texts), frames::ROW_ORDER).unwrap_err();
            assert!(e.code() == "lake.io" && e.to_string().contains("No space left"), "{e}");
        }
    }

    #[test]
    fn a_column_with_a_negative_offset_is_refused() {
        // Found by the fuzz target `lake-frames`; the Parquet reader panics on it.
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), include_bytes!("../tests/fixtures/negative_offset.parquet")).unwrap();
        let Err(e) = read_table(file.path(), frames::ROW_ORDER) else { panic!("it was read") };
        assert_eq!(e.code(), "lake.table_broken");
    }

    #[test]
    fn pages_that_contradict_each_other_are_refused() {
        // Found by the fuzz targets `lake-ego` and `lake-frames`; the Parquet reader panics on them.
        let files: [&[u8]; 3] = [
            include_bytes!("../tests/fixtures/no_dictionary.parquet"),
            include_bytes!("../tests/fixtures/short_bitmap.parquet"),
            include_bytes!("../tests/fixtures/zero_divisor.parquet"),
        ];
        for (n, content) in files.into_iter().enumerate() {
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), content).unwrap();
            let Err(e) = read_table(file.path(), frames::ROW_ORDER) else { panic!("file {n} was read") };
            assert_eq!(e.code(), "lake.table_broken", "file {n}");
        }
    }
}
