//! Row groups of several files as the row groups of one: the encoded columns are copied as they are, with their
//! statistics. Only what a file lacks is written: the id of the drive, and nulls for a signal that it does not have.

use crate::LakeError;
use crate::file;
use crate::signals::pages::Chunk;
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata, parquet_to_arrow_schema};
use parquet::column::writer::{ColumnCloseResult, ColumnWriter};
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{KeyValue, ParquetMetaData, RowGroupMetaData};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::ColumnPath;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use whyroad_model::DriveId;

pub(super) const DRIVE_ID: &str = "drive_id";

/// The rows of one drive in one file.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub path: PathBuf,
    pub metadata: Arc<ParquetMetaData>,
    /// `None` without rows.
    pub group: Option<usize>,
}

impl Part {
    fn row_group(&self) -> Option<&RowGroupMetaData> {
        self.metadata.row_groups().get(self.group?)
    }

    /// Bytes of its columns.
    pub fn bytes(&self) -> u64 {
        let size = self.row_group().map_or(0, RowGroupMetaData::compressed_size);
        u64::try_from(size).unwrap_or(0)
    }
}

/// Schemas of files, each decoded once.
#[derive(Default)]
pub(super) struct Schemas(HashMap<String, SchemaRef>);

impl Schemas {
    /// The columns of a file.
    pub fn of(&mut self, part: &Part) -> Result<SchemaRef, LakeError> {
        let file = part.metadata.file_metadata();
        let stated = file.key_value_metadata();
        let text = stated.and_then(|all| all.iter().find(|kv| kv.key == "ARROW:schema")?.value.clone());
        if let Some(known) = text.as_ref().and_then(|t| self.0.get(t)) {
            return Ok(Arc::clone(known));
        }
        let schema = parquet_to_arrow_schema(file.schema_descr(), stated)
            .map_err(|e| LakeError::broken(&part.path, e))?;
        // Metadata of the file are not columns.
        let schema = Arc::new(Schema::new(schema.fields().clone()));
        if let Some(text) = text {
            self.0.insert(text, Arc::clone(&schema));
        }
        Ok(schema)
    }
}

/// The columns of a scene table in a pack: those of the file, with the id of the drive in front where it has none.
pub(super) fn with_drive_id(schema: &Schema) -> Schema {
    if schema.field_with_name(DRIVE_ID).is_ok() {
        return schema.clone();
    }
    let id = Arc::new(Field::new(DRIVE_ID, DataType::Utf8, false));
    Schema::new(std::iter::once(id).chain(schema.fields().iter().cloned()).collect::<Vec<_>>())
}

/// Writes the drives' rows, a row group each; the file is on the disk when this returns.
pub(super) fn write(
    path: &Path,
    schema: &Schema,
    row_order: &str,
    more: Vec<KeyValue>,
    parts: &[(&DriveId, &Part)],
) -> Result<(), LakeError> {
    let broken = |e: ParquetError| LakeError::broken(path, e);
    let mut properties = file::properties(row_order, more).build();
    add_encoded_arrow_schema_to_metadata(schema, &mut properties);
    let columns = ArrowSchemaConverter::new().convert(schema).map_err(broken)?;
    let file = File::create(path).map_err(LakeError::io(path))?;
    let mut writer =
        SerializedFileWriter::new(file, columns.root_schema_ptr(), Arc::new(properties)).map_err(broken)?;
    for (id, part) in parts {
        let Some(from) = part.row_group() else { continue };
        let chunk = bytes_of(part, from)?;
        let mut copy = || -> ParquetResult<()> {
            let sources: HashMap<&ColumnPath, usize> =
                from.columns().iter().enumerate().map(|(i, c)| (c.column_path(), i)).collect();
            let rows = u64::try_from(from.num_rows()).unwrap_or(0);
            let mut group = writer.next_row_group()?;
            for column in columns.columns() {
                if let Some(&source) = sources.get(column.path()) {
                    let metadata = from.column(source).clone();
                    let close = ColumnCloseResult {
                        bytes_written: u64::try_from(metadata.compressed_size()).unwrap_or(0),
                        rows_written: rows,
                        metadata,
                        bloom_filter: None,
                        column_index: None,
                        offset_index: None,
                    };
                    group.append_column(&chunk, close)?;
                    continue;
                }
                let rows = usize::try_from(rows).unwrap_or(0);
                let missing = || ParquetError::General("the file has fewer columns than its schema".into());
                let mut new = group.next_column()?.ok_or_else(missing)?;
                if column.path().parts() == [DRIVE_ID] {
                    repeat(&mut new, id.as_str(), rows)?;
                } else {
                    nulls(&mut new, rows)?;
                }
                new.close()?;
            }
            group.close().map(drop)
        };
        copy().map_err(|e| LakeError::broken(&part.path, e))?;
    }
    let file = writer.into_inner().map_err(broken)?;
    file.sync_all().map_err(LakeError::io(path))
}

/// The bytes of a row group, read at once.
fn bytes_of(part: &Part, group: &RowGroupMetaData) -> Result<Chunk, LakeError> {
    let io = || LakeError::io(&part.path);
    let ranges = group.columns().iter().map(|c| c.byte_range());
    let (start, end) =
        ranges.fold((u64::MAX, 0), |(a, b), (at, len)| (a.min(at), b.max(at.saturating_add(len))));
    let mut file = File::open(&part.path).map_err(io())?;
    let length = file.metadata().map_err(io())?.len();
    if start > end || end > length {
        return Err(LakeError::broken(&part.path, "a column ends behind the end of the file"));
    }
    let mut bytes = vec![0; usize::try_from(end - start).unwrap_or(0)];
    file.seek(SeekFrom::Start(start)).map_err(io())?;
    file.read_exact(&mut bytes).map_err(io())?;
    Ok(Chunk { start, bytes: bytes.into() })
}

/// One text in all rows, which are never null.
fn repeat(column: &mut SerializedColumnWriter<'_>, text: &str, rows: usize) -> ParquetResult<()> {
    match column.untyped() {
        ColumnWriter::ByteArrayColumnWriter(to) => {
            to.write_batch(&vec![ByteArray::from(text.as_bytes().to_vec()); rows], None, None).map(drop)
        }
        _ => Err(ParquetError::General("the id of the drive is not text".into())),
    }
}

fn nulls(column: &mut SerializedColumnWriter<'_>, rows: usize) -> ParquetResult<()> {
    let levels = vec![0; rows];
    match column.untyped() {
        ColumnWriter::BoolColumnWriter(to) => to.write_batch(&[], Some(&levels), None),
        ColumnWriter::DoubleColumnWriter(to) => to.write_batch(&[], Some(&levels), None),
        ColumnWriter::ByteArrayColumnWriter(to) => to.write_batch(&[], Some(&levels), None),
        _ => return Err(ParquetError::General("a column is missing and has no nulls".into())),
    }
    .map(drop)
}
