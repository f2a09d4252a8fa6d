//! Values to Parquet's own column writers: those of the known rows, and which rows these are. Nothing is made an Arrow
//! array for it; the Arrow schema only says what the columns are.

use crate::LakeError;
use arrow_schema::Schema;
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, Tri};

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
    /// Nulls in this number of rows.
    Nulls(usize),
}

/// What a column is prepared in, kept for the next one.
#[derive(Default)]
pub(crate) struct Buffers {
    levels: Vec<i16>,
    numbers: Vec<f64>,
    flags: Vec<bool>,
    texts: Vec<ByteArray>,
}

/// A file with the columns of `schema`.
pub(crate) fn create(
    path: &Path,
    schema: &Schema,
    mut properties: WriterProperties,
) -> Result<SerializedFileWriter<File>, LakeError> {
    let broken = |e: ParquetError| LakeError::broken(path, e);
    add_encoded_arrow_schema_to_metadata(schema, &mut properties);
    let columns = ArrowSchemaConverter::new().convert(schema).map_err(broken)?;
    let file = File::create(path).map_err(LakeError::io(path))?;
    SerializedFileWriter::new(file, columns.root_schema_ptr(), Arc::new(properties)).map_err(broken)
}

/// Ends a file; it is on the disk when this returns.
pub(crate) fn finish(path: &Path, writer: SerializedFileWriter<File>) -> Result<(), LakeError> {
    let file = writer.into_inner().map_err(|e| LakeError::broken(path, e))?;
    file.sync_all().map_err(LakeError::io(path))
}

/// Writes the values of a column; fails where they are not of its type.
pub(crate) fn write(
    column: &mut SerializedColumnWriter<'_>,
    cells: Cells<'_>,
    buffers: &mut Buffers,
) -> ParquetResult<()> {
    let Buffers { levels, numbers, flags, texts } = buffers;
    let written = match (column.untyped(), cells) {
        (ColumnWriter::ByteArrayColumnWriter(to), Cells::Runs(runs)) => {
            texts.clear();
            for (text, rows) in runs {
                texts.extend(std::iter::repeat_n(ByteArray::from(*text), *rows));
            }
            to.write_batch(texts, None, None)
        }
        (ColumnWriter::Int32ColumnWriter(to), Cells::Indices(values)) => {
            let values: Vec<i32> = values.iter().map(|v| v.cast_signed()).collect();
            to.write_batch(&values, None, None)
        }
        (ColumnWriter::Int64ColumnWriter(to), Cells::Integers(values)) => to.write_batch(values, None, None),
        (ColumnWriter::DoubleColumnWriter(to), Cells::Signal(Column::Number(values))) => {
            if values.iter().any(|x| x.is_nan()) {
                divide_copied(values, |x| (!x.is_nan(), *x), levels, numbers);
                to.write_batch(numbers, Some(levels), None)
            } else {
                levels.clear();
                levels.resize(values.len(), 1);
                to.write_batch(values, Some(levels), None)
            }
        }
        (ColumnWriter::BoolColumnWriter(to), Cells::Signal(Column::Flag(values))) => {
            divide_copied(values, |flag| (*flag != Tri::Unknown, *flag == Tri::True), levels, flags);
            to.write_batch(flags, Some(levels), None)
        }
        (ColumnWriter::ByteArrayColumnWriter(to), Cells::Signal(Column::Category { codes, names })) => {
            let words: Vec<ByteArray> = names.iter().map(|w| ByteArray::from(w.as_str())).collect();
            let word = |c: &u16| words.get(usize::from(*c)).filter(|_| *c != UNKNOWN_CODE).cloned();
            divide(codes, word, levels, texts);
            to.write_batch(texts, Some(levels), None)
        }
        (to, Cells::Nulls(rows)) => {
            levels.clear();
            levels.resize(rows, 0);
            match to {
                ColumnWriter::BoolColumnWriter(to) => to.write_batch(&[], Some(levels), None),
                ColumnWriter::DoubleColumnWriter(to) => to.write_batch(&[], Some(levels), None),
                ColumnWriter::ByteArrayColumnWriter(to) => to.write_batch(&[], Some(levels), None),
                _ => return Err(ParquetError::General("a column is missing and has no nulls".into())),
            }
        }
        _ => return Err(ParquetError::General("the values are not of the column's type".into())),
    };
    written.map(drop)
}

/// Divides values into definition levels (1: known, 0: null) and those that are known.
fn divide<T, U>(all: &[T], known: impl Fn(&T) -> Option<U>, levels: &mut Vec<i16>, values: &mut Vec<U>) {
    levels.clear();
    values.clear();
    values.reserve(all.len());
    levels.extend(all.iter().map(|value| {
        let value = known(value);
        let level = i16::from(value.is_some());
        values.extend(value);
        level
    }));
}

/// [`divide`] of what costs nothing to copy, without a branch per value; what is unknown has any value.
fn divide_copied<T, U: Copy + Default>(
    all: &[T],
    known: impl Fn(&T) -> (bool, U),
    levels: &mut Vec<i16>,
    values: &mut Vec<U>,
) {
    levels.clear();
    values.clear();
    values.resize(all.len(), U::default());
    let mut count = 0;
    levels.extend(all.iter().map(|value| {
        let (known, value) = known(value);
        values[count] = value;
        count += usize::from(known);
        i16::from(known)
    }));
    values.truncate(count);
}
