//! Signal tables to Parquet.

use super::equal::earlier_equals;
use super::{Contents, FRAME, KEY, ROW_ORDER, StoredDrive, TIME, digest};
use crate::LakeError;
use crate::chunks::{Cells, ChunkWriter, Source};
use crate::file::properties;
use arrow_schema::{DataType, Field, Schema};
use parquet::basic::Encoding;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::schema::types::ColumnPath;
use std::collections::{BTreeMap, BTreeSet};
use std::mem::discriminant;
use std::path::Path;
use whyroad_model::{Column, SignalTable};

/// Rows that go to a column writer at once: as many as a page has.
const BATCH_ROWS: usize = 20_000;

/// Writes the signals of these drives into a folder: `frames.parquet` and `targets.parquet`. Each drive comes with its
/// content hash. A signal that some of the drives lack is null in these.
pub fn write_signals(dir: &Path, version: &str, drives: &[(String, &SignalTable)]) -> Result<(), LakeError> {
    let contents = Contents {
        version: version.to_owned(),
        drives: drives.iter().map(|(hash, table)| stored(hash, table)).collect(),
    };
    let text = serde_json::to_string(&contents).map_err(|e| LakeError::broken(dir, e))?;
    write_file(&dir.join("frames.parquet"), &text, drives, |t| &t.frame_columns, frame_keys)?;
    let contents = digest(&text);
    write_file(&dir.join("targets.parquet"), &contents, drives, |t| &t.target_columns, target_keys)
}

fn stored(hash: &str, table: &SignalTable) -> StoredDrive {
    let words = table.frame_columns.iter().chain(&table.target_columns).filter_map(|(name, c)| match c {
        Column::Category { names, .. } => Some((name.clone(), names.to_vec())),
        _ => None,
    });
    StoredDrive {
        drive_id: table.drive_id.clone(),
        content_hash: hash.to_owned(),
        frames: table.times.len(),
        targets: table.targets.clone(),
        unavailable: table.unavailable.clone(),
        partial: table.partial.clone(),
        without_boxes: table.without_boxes.clone(),
        words: words.collect(),
        ..StoredDrive::default()
    }
}

/// Object and time of the rows.
struct Keys<'a> {
    /// The targets, each with the number of its rows; `None` in a table of frames.
    targets: Option<Vec<(&'a str, usize)>>,
    frames: Vec<u32>,
    times: Vec<i64>,
}

fn frame_keys(table: &SignalTable) -> Keys<'_> {
    keys(table, None, 0..table.times.len())
}

fn target_keys(table: &SignalTable) -> Keys<'_> {
    let targets = table.targets.iter().map(|t| (t.id.as_str(), t.frames.len())).collect();
    keys(table, Some(targets), table.targets.iter().flat_map(|t| t.frames.start..t.frames.end))
}

fn keys<'a>(
    table: &SignalTable,
    targets: Option<Vec<(&'a str, usize)>>,
    rows: impl Iterator<Item = usize> + Clone,
) -> Keys<'a> {
    let times = rows.clone().map(|f| table.times[f].0).collect();
    Keys { targets, frames: rows.map(|f| u32::try_from(f).unwrap_or(u32::MAX)).collect(), times }
}

/// The columns of a file: keys, then signals, whose type is that of a sample.
fn schema(has_targets: bool, signals: &[(&String, &Column)]) -> Schema {
    let text = || DataType::Dictionary(Box::new(DataType::UInt16), Box::new(DataType::Utf8));
    let mut fields = vec![Field::new("drive_id", text(), false)];
    if has_targets {
        fields.push(Field::new("target_id", text(), false));
    }
    fields.push(Field::new(FRAME, DataType::UInt32, false));
    fields.push(Field::new(TIME, DataType::Int64, false));
    fields.extend(signals.iter().map(|(name, sample)| {
        let kind = match sample {
            Column::Number(_) => DataType::Float64,
            Column::Flag(_) => DataType::Boolean,
            Column::Category { .. } => text(),
        };
        Field::new(name.as_str(), kind, true)
    }));
    Schema::new(fields)
}

fn writer_properties(contents: &str) -> WriterProperties {
    let mut out = properties(ROW_ORDER, vec![KeyValue::new(KEY.to_owned(), contents.to_owned())])
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_write_batch_size(BATCH_ROWS);
    for key in [FRAME, TIME] {
        out = out
            .set_column_encoding(ColumnPath::from(key), Encoding::DELTA_BINARY_PACKED)
            .set_column_dictionary_enabled(ColumnPath::from(key), false);
    }
    out.build()
}

fn write_file(
    path: &Path,
    contents: &str,
    drives: &[(String, &SignalTable)],
    columns: fn(&SignalTable) -> &BTreeMap<String, Column>,
    keys: fn(&SignalTable) -> Keys<'_>,
) -> Result<(), LakeError> {
    let Some((_, first)) = drives.first() else { return Ok(()) };
    let names: BTreeSet<&String> = drives.iter().flat_map(|(_, t)| columns(t).keys()).collect();
    let sample = |name: &'_ String| drives.iter().find_map(|(_, t)| columns(t).get(name));
    let signals: Vec<(&String, &Column)> =
        names.into_iter().filter_map(|name| Some((name, sample(name)?))).collect();
    let schema = schema(keys(first).targets.is_some(), &signals);
    let mut writer = ChunkWriter::create(path, &schema, writer_properties(contents))?;
    for (_, table) in drives {
        let Keys { targets, frames, times } = keys(table);
        let drive = [(table.drive_id.as_str(), frames.len())];
        let mut sources = vec![Source::Cells(Cells::Runs(&drive))];
        sources.extend(targets.as_deref().map(|runs| Source::Cells(Cells::Runs(runs))));
        sources.extend([Cells::Indices(&frames), Cells::Integers(&times)].map(Source::Cells));
        // Null where the drive has no such column, or has it of another type.
        let own: Vec<Option<&Column>> = signals
            .iter()
            .map(|(name, sample)| {
                columns(table).get(*name).filter(|c| discriminant(*c) == discriminant(sample))
            })
            .collect();
        let before = sources.len();
        sources.extend(own.iter().zip(earlier_equals(&own)).map(|(column, same)| match (same, column) {
            (Some(of), _) => Source::SameAs(before + of),
            (None, Some(column)) => Source::Cells(Cells::Signal(column)),
            (None, None) => Source::Cells(Cells::Nulls(frames.len())),
        }));
        writer.row_group(frames.len(), &sources)?;
    }
    writer.finish()
}
