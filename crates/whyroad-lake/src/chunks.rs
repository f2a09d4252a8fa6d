//! Values to the column chunks of Parquet files: those of the known rows, and which rows these are. Signals are not
//! made Arrow arrays for it; the Arrow schema only says what the columns are.
//!
//! Flags, texts, numbers and nulls are made pages here (`encoded`), integers by Parquet's own column writers.
//!
//! Columns of a row group with equal values are stored once: the footer names the same pages for each of them. That is
//! plain Parquet, where the footer states the position of a column, so readers need no special support.

mod encoded;

use crate::LakeError;
use crate::signals::bitmap::low;
use crate::signals::pages::Chunk;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt32Type};
use arrow_array::{Array, StringArray};
use arrow_schema::Schema;
use encoded::Encoded;
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::basic::Type;
use parquet::column::writer::{ColumnCloseResult, ColumnWriter};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{
    ColumnChunkMetaData, FileMetaData, ParquetMetaData, ParquetMetaDataWriter, RowGroupMetaData,
};
use parquet::file::properties::{WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedColumnWriter, SerializedRowGroupWriter, TrackedWrite};
use parquet::schema::types::{ColumnDescPtr, SchemaDescPtr, SchemaDescriptor};
use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_model::{Column, Tri};

/// The bytes at the beginning and end of a file of this format.
const MAGIC: &[u8] = b"PAR1";

/// Where a column of a row group comes from.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    /// Values.
    Cells(Cells<'a>),
    /// A column of another file, unchanged.
    Copied(&'a Chunk, &'a ColumnChunkMetaData),
    /// The same values as the column of this index, which comes before.
    SameAs(usize),
}

/// The values of one column in one row group.
#[derive(Clone, Copy)]
pub(crate) enum Cells<'a> {
    /// Texts that are always known, each with the number of rows in which it is there.
    Runs(&'a [(&'a str, usize)]),
    /// Counts and indices that are always known.
    Indices(&'a [u32]),
    /// Integers that are always known.
    Integers(&'a [i64]),
    /// Values of a signal; what is unknown becomes null.
    Signal(&'a Column),
    /// Values of an Arrow array, nulls included.
    Array(&'a dyn Array),
    /// Nulls in this number of rows.
    Nulls(usize),
}

/// A file on its way to the disk, row group by row group.
pub(crate) struct ChunkWriter {
    path: PathBuf,
    to: TrackedWrite<File>,
    schema: SchemaDescPtr,
    properties: WriterPropertiesPtr,
    groups: Vec<RowGroupMetaData>,
    /// Definition levels of a column, kept for the next one.
    levels: Vec<i16>,
}

impl ChunkWriter {
    /// A file with the columns of `schema`.
    pub fn create(path: &Path, schema: &Schema, mut properties: WriterProperties) -> Result<Self, LakeError> {
        add_encoded_arrow_schema_to_metadata(schema, &mut properties);
        let columns = ArrowSchemaConverter::new().convert(schema).map_err(LakeError::unwritten(path))?;
        let file = File::create(path).map_err(LakeError::io(path))?;
        let mut to = TrackedWrite::new(file);
        to.write_all(MAGIC).map_err(LakeError::io(path))?;
        Ok(Self {
            path: path.to_owned(),
            to,
            schema: Arc::new(SchemaDescriptor::new(columns.root_schema_ptr())),
            properties: Arc::new(properties.into_builder().set_offset_index_disabled(true).build()),
            groups: Vec::new(),
            levels: Vec::new(),
        })
    }

    /// The columns.
    pub fn columns(&self) -> &[ColumnDescPtr] {
        self.schema.columns()
    }

    /// Writes a row group with this number of rows: one source per column.
    pub fn row_group(&mut self, rows: usize, sources: &[Source<'_>]) -> Result<(), LakeError> {
        let group = self.encoded(rows, sources);
        let group = group.map_err(LakeError::unwritten(&self.path))?;
        self.groups.push(group);
        Ok(())
    }

    fn encoded(&mut self, rows: usize, sources: &[Source<'_>]) -> ParquetResult<RowGroupMetaData> {
        let ordinal = i32::try_from(self.groups.len()).map_err(|e| ParquetError::General(e.to_string()))?;
        let (schema, properties) = (Arc::clone(&self.schema), Arc::clone(&self.properties));
        let mut group = SerializedRowGroupWriter::new(schema, properties, &mut self.to, ordinal, None);
        let mut shared = Vec::new();
        for (at, source) in sources.iter().enumerate() {
            match source {
                Source::Cells(cells) => match encoded(*cells, self.schema.columns().get(at))? {
                    Some((bytes, metadata)) => {
                        group.append_column(&Chunk { start: 0, bytes }, closed(metadata, rows))?;
                    }
                    None => {
                        let missing = || ParquetError::General("more columns than the schema has".into());
                        let mut column = group.next_column()?.ok_or_else(missing)?;
                        write(&mut column, *cells, &mut self.levels)?;
                        column.close()?;
                    }
                },
                Source::Copied(chunk, metadata) => {
                    group.append_column(*chunk, closed((*metadata).clone(), rows))?;
                }
                Source::SameAs(of) => {
                    let column = self.schema.column(at);
                    let nothing = Chunk { start: 0, bytes: bytes::Bytes::new() };
                    group.append_column(
                        &nothing,
                        closed(ColumnChunkMetaData::builder(column).build()?, rows),
                    )?;
                    shared.push((at, *of));
                }
            }
        }
        let metadata = group.close()?;
        if shared.is_empty() {
            return Ok((*metadata).clone());
        }
        let mut columns = metadata.columns().to_vec();
        let mut bytes = metadata.total_byte_size();
        for (at, of) in shared {
            columns[at] = at_the_place_of(&columns[of], &columns[at])?;
            bytes += columns[at].uncompressed_size();
        }
        let group = (*metadata).clone().into_builder();
        group.set_column_metadata(columns).set_total_byte_size(bytes).build()
    }

    /// Ends the file; it is on the disk when this returns.
    pub fn finish(self) -> Result<(), LakeError> {
        let Self { path, mut to, schema, properties, groups, .. } = self;
        let rows = groups.iter().map(RowGroupMetaData::num_rows).sum();
        let of_file = FileMetaData::new(
            properties.writer_version().as_num(),
            rows,
            Some(properties.created_by().to_owned()),
            properties.key_value_metadata().cloned(),
            schema,
            None,
        );
        let metadata = ParquetMetaData::new(of_file, groups);
        ParquetMetaDataWriter::new(&mut to, &metadata).finish().map_err(LakeError::unwritten(&path))?;
        let file = to.into_inner().map_err(LakeError::unwritten(&path))?;
        file.sync_all().map_err(LakeError::io(&path))
    }
}

/// A column that is written, with the number of its rows.
fn closed(metadata: ColumnChunkMetaData, rows: usize) -> ColumnCloseResult {
    ColumnCloseResult {
        bytes_written: u64::try_from(metadata.compressed_size()).unwrap_or(0),
        rows_written: rows as u64,
        metadata,
        bloom_filter: None,
        column_index: None,
        offset_index: None,
    }
}

/// The footer entry of a column that shares the pages of another one.
fn at_the_place_of(
    other: &ColumnChunkMetaData,
    column: &ColumnChunkMetaData,
) -> ParquetResult<ColumnChunkMetaData> {
    if other.column_type() != column.column_type() {
        return Err(ParquetError::General("columns of different types have no values in common".into()));
    }
    let mut out = ColumnChunkMetaData::builder(column.column_descr_ptr())
        .set_compression_codec(other.compression_codec())
        .set_encodings_mask(*other.encodings_mask())
        .set_total_compressed_size(other.compressed_size())
        .set_total_uncompressed_size(other.uncompressed_size())
        .set_num_values(other.num_values())
        .set_data_page_offset(other.data_page_offset())
        .set_dictionary_page_offset(other.dictionary_page_offset())
        .set_unencoded_byte_array_data_bytes(other.unencoded_byte_array_data_bytes())
        .set_definition_level_histogram(other.definition_level_histogram().cloned());
    if let Some(statistics) = other.statistics() {
        out = out.set_statistics(statistics.clone());
    }
    if let Some(stats) = other.page_encoding_stats() {
        out = out.set_page_encoding_stats(stats.clone());
    }
    out.build()
}

/// Flags, texts, numbers and nulls as a column of this type; `None` where Parquet's own writer is used.
fn encoded(cells: Cells<'_>, column: Option<&ColumnDescPtr>) -> ParquetResult<Option<Encoded>> {
    let Some(column) = column else { return Ok(None) };
    let (physical, nullable) = (column.physical_type(), column.max_def_level() == 1);
    let column = || Arc::clone(column);
    match cells {
        Cells::Nulls(rows) => encoded::nulls(rows, column()),
        Cells::Array(array) if array.null_count() == array.len() && nullable => {
            encoded::nulls(array.len(), column())
        }
        Cells::Array(array) => match (array.as_string_opt::<i32>(), array.as_boolean_opt()) {
            (Some(texts), _) if physical == Type::BYTE_ARRAY => encoded::runs(runs_of(texts), column()),
            (_, Some(flags)) if physical == Type::BOOLEAN && nullable => {
                let flags: Vec<Tri> = flags.iter().map(Tri::from).collect();
                encoded::flags(&flags, column())
            }
            _ => match array.as_primitive_opt::<Float64Type>() {
                Some(numbers) if physical == Type::DOUBLE => {
                    encoded::numbers(numbers.values(), |rows| valid(array, rows), column())
                }
                _ => return Ok(None),
            },
        },
        Cells::Runs(runs) if physical == Type::BYTE_ARRAY && !nullable => {
            encoded::runs(runs.iter().map(|(text, rows)| (Some(*text), *rows)), column())
        }
        Cells::Signal(Column::Flag(flags)) if physical == Type::BOOLEAN && nullable => {
            encoded::flags(flags, column())
        }
        Cells::Signal(Column::Category { codes, names }) if physical == Type::BYTE_ARRAY && nullable => {
            encoded::words(codes, names, column())
        }
        Cells::Signal(Column::Number(values)) if physical == Type::DOUBLE && nullable => {
            encoded::numbers(values, |rows| encoded::known(&values[rows]), column())
        }
        _ => return Ok(None),
    }
    .map(Some)
}

/// Of up to 64 rows of an array, which have a value.
fn valid(array: &dyn Array, rows: Range<usize>) -> u64 {
    if array.null_count() == 0 {
        return low(rows.len());
    }
    rows.enumerate().fold(0, |word, (i, row)| word | u64::from(array.is_valid(row)) << i)
}

/// Texts that are the same in rows one after another, each with the number of these rows.
pub(crate) fn runs_of(texts: &StringArray) -> impl Iterator<Item = (Option<&str>, usize)> {
    let text = |row: usize| texts.is_valid(row).then(|| texts.value(row));
    let mut next = 0;
    std::iter::from_fn(move || {
        let start = next;
        let first = (start < texts.len()).then(|| text(start))?;
        next += 1;
        while next < texts.len() && text(next) == first {
            next += 1;
        }
        Some((first, next - start))
    })
}

/// Writes the values of a column; fails where they are not of its type.
fn write(
    column: &mut SerializedColumnWriter<'_>,
    cells: Cells<'_>,
    levels: &mut Vec<i16>,
) -> ParquetResult<()> {
    let written = match (column.untyped(), cells) {
        (ColumnWriter::Int32ColumnWriter(to), Cells::Indices(values)) => {
            let values: Vec<i32> = values.iter().map(|v| v.cast_signed()).collect();
            to.write_batch(&values, None, None)
        }
        (ColumnWriter::Int64ColumnWriter(to), Cells::Integers(values)) => to.write_batch(values, None, None),
        (to, Cells::Array(array)) => {
            let is_known = |row: usize| array.is_valid(row);
            let known: Option<&dyn Fn(usize) -> bool> =
                if array.null_count() > 0 { Some(&is_known) } else { None };
            // A column without nulls passes over the levels.
            match to {
                ColumnWriter::Int64ColumnWriter(to) => {
                    let values = array.as_primitive_opt::<Int64Type>().ok_or_else(other_type)?.values();
                    let mut own = Vec::new();
                    let values = divided(values, known, levels, &mut own);
                    to.write_batch(values, Some(levels), None)
                }
                ColumnWriter::Int32ColumnWriter(to) => {
                    let values = array.as_primitive_opt::<UInt32Type>().ok_or_else(other_type)?.values();
                    let values: Vec<i32> = values.iter().map(|v| v.cast_signed()).collect();
                    let mut own = Vec::new();
                    let values = divided(&values, known, levels, &mut own);
                    to.write_batch(values, Some(levels), None)
                }
                _ => return Err(other_type()),
            }
        }
        _ => return Err(other_type()),
    };
    written.map(drop)
}

fn other_type() -> ParquetError {
    ParquetError::General("the values are not of the column's type".into())
}

/// Definition levels (1: known, 0: null) of rows, and the values of those that are known; `None` means that all are
/// known.
fn divided<'v, T: Copy + Default>(
    all: &'v [T],
    known: Option<&(impl Fn(usize) -> bool + ?Sized)>,
    levels: &mut Vec<i16>,
    values: &'v mut Vec<T>,
) -> &'v [T] {
    levels.clear();
    let Some(known) = known else {
        levels.resize(all.len(), 1);
        return all;
    };
    values.clear();
    values.resize(all.len(), T::default());
    let mut count = 0;
    // Without a branch per value.
    levels.extend(all.iter().enumerate().map(|(row, value)| {
        let known = known(row);
        values[count] = *value;
        count += usize::from(known);
        i16::from(known)
    }));
    &values[..count]
}
