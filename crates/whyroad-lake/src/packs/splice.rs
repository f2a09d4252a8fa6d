//! Row groups of several files as the row groups of one: the encoded columns are copied as they are, with their
//! statistics. Only what a file lacks is written: the id of the drive, and nulls for a signal that it does not have.

use crate::LakeError;
use crate::chunks::{self, Buffers, Cells};
use crate::file;
use crate::signals::pages::Chunk;
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::parquet_to_arrow_schema;
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::{KeyValue, ParquetMetaData, RowGroupMetaData};
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
    let mut writer = chunks::create(path, schema, file::properties(row_order, more).build())?;
    let columns = writer.schema_descr().columns().to_vec();
    let mut buffers = Buffers::default();
    for (id, part) in parts {
        let Some(from) = part.row_group() else { continue };
        let chunk = bytes_of(part, from)?;
        let mut copy = || -> ParquetResult<()> {
            let sources: HashMap<&ColumnPath, usize> =
                from.columns().iter().enumerate().map(|(i, c)| (c.column_path(), i)).collect();
            let rows = u64::try_from(from.num_rows()).unwrap_or(0);
            let mut group = writer.next_row_group()?;
            for column in &columns {
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
                let drive = [(id.as_str(), rows)];
                let is_id = column.path().parts() == [DRIVE_ID];
                let cells = if is_id { Cells::Runs(&drive) } else { Cells::Nulls(rows) };
                chunks::write(&mut new, cells, &mut buffers)?;
                new.close()?;
            }
            group.close().map(drop)
        };
        copy().map_err(|e| LakeError::broken(&part.path, e))?;
    }
    chunks::finish(path, writer)
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
