//! Row groups of several files as the row groups of one: the encoded columns are copied unchanged, with their
//! statistics. Only missing columns are written: the id of the drive, and nulls for a signal that it does not have.

use crate::LakeError;
use crate::chunks::{Cells, ChunkWriter, Source};
use crate::file;
use crate::signals::pages::Chunk;
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::parquet_to_arrow_schema;
use parquet::file::metadata::{ColumnChunkMetaData, KeyValue, ParquetMetaData, RowGroupMetaData};
use parquet::schema::types::ColumnPath;
use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};
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

    /// Bytes of its columns; shared columns count once.
    pub fn bytes(&self) -> u64 {
        let columns = self.row_group().map_or(&[][..], RowGroupMetaData::columns);
        columns.iter().map(|c| c.byte_range()).collect::<BTreeSet<_>>().iter().map(|(_, length)| length).sum()
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
    let mut writer = ChunkWriter::create(path, schema, file::properties(row_order, more).build())?;
    let columns = writer.columns().to_vec();
    for (id, part) in parts {
        let Some(from) = part.row_group() else { continue };
        let chunk = bytes_of(part, from)?;
        let own: HashMap<&ColumnPath, &ColumnChunkMetaData> =
            from.columns().iter().map(|c| (c.column_path(), c)).collect();
        let rows = usize::try_from(from.num_rows()).unwrap_or(0);
        let drive = [(id.as_str(), rows)];
        // Columns that share pages in the file share them in the pack.
        let mut places = HashMap::new();
        let sources = columns.iter().enumerate().map(|(at, column)| match own.get(column.path()) {
            Some(source) => match places.entry((source.byte_range(), source.column_type())) {
                Entry::Occupied(first) => Source::SameAs(*first.get()),
                Entry::Vacant(first) => {
                    first.insert(at);
                    Source::Copied(&chunk, source)
                }
            },
            None if column.path().parts() == [DRIVE_ID] => Source::Cells(Cells::Runs(&drive)),
            None => Source::Cells(Cells::Nulls(rows)),
        });
        let sources: Vec<Source<'_>> = sources.collect();
        writer.row_group(rows, &sources)?;
    }
    writer.finish()
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
