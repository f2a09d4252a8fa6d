//! Signal tables to Parquet.

use super::{Contents, FRAME, KEY, ROW_ORDER, StoredDrive, TIME, digest};
use crate::file::{ROW_ORDER_KEY, repeats};
use crate::{LAKE_VERSION, LakeError};
use arrow_array::types::UInt16Type;
use arrow_array::{
    ArrayRef, BooleanArray, DictionaryArray, Float64Array, Int64Array, RecordBatch, StringArray, UInt16Array,
    UInt32Array,
};
use arrow_buffer::{BooleanBuffer, NullBuffer};
use arrow_schema::{Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, Encoding};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::schema::types::ColumnPath;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, SignalTable, Tri};

/// Writes the signals of these drives into a folder: `frames.parquet` and `targets.parquet`. Each drive comes with its
/// content hash. A signal that some of the drives lack is null in these.
pub fn write_signals(dir: &Path, version: &str, drives: &[(String, &SignalTable)]) -> Result<(), LakeError> {
    let contents = Contents {
        version: version.to_owned(),
        drives: drives.iter().map(|(hash, table)| stored(hash, table)).collect(),
    };
    let text = serde_json::to_string(&contents).map_err(|e| LakeError::broken(dir, e))?;
    let frames = |t: &SignalTable| {
        let frame: Vec<u32> = (0..).take(t.times.len()).collect();
        let time = t.times.iter().map(|t| t.0).collect();
        (vec![], frame, time)
    };
    write_file(&dir.join("frames.parquet"), &text, drives, |t| &t.frame_columns, frames)?;
    let targets = |t: &SignalTable| {
        let rows = || t.targets.iter().flat_map(|s| (s.frames.start..s.frames.end).map(move |f| (s, f)));
        let ids = StringArray::from_iter_values(rows().map(|(s, _)| s.id.as_str()));
        let time = rows().map(|(_, f)| t.times[f].0).collect();
        (vec![ids], rows().map(|(_, f)| u32::try_from(f).unwrap_or(u32::MAX)).collect(), time)
    };
    write_file(&dir.join("targets.parquet"), &digest(&text), drives, |t| &t.target_columns, targets)
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
        words: words.collect(),
        ..StoredDrive::default()
    }
}

/// Ids of targets, frames and times of the rows.
type Keys = (Vec<StringArray>, Vec<u32>, Vec<i64>);

fn write_file(
    path: &Path,
    contents: &str,
    drives: &[(String, &SignalTable)],
    columns: fn(&SignalTable) -> &BTreeMap<String, Column>,
    keys: impl Fn(&SignalTable) -> Keys,
) -> Result<(), LakeError> {
    let broken = |e: &dyn std::fmt::Display| LakeError::broken(path, e);
    let names: BTreeSet<&String> = drives.iter().flat_map(|(_, t)| columns(t).keys()).collect();
    let sample = |name: &String| drives.iter().find_map(|(_, t)| columns(t).get(name));
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_max_row_group_row_count(None)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_created_by(format!("whyroad {}", env!("CARGO_PKG_VERSION")))
        .set_column_encoding(ColumnPath::from(FRAME), Encoding::DELTA_BINARY_PACKED)
        .set_column_encoding(ColumnPath::from(TIME), Encoding::DELTA_BINARY_PACKED)
        .set_column_dictionary_enabled(ColumnPath::from(FRAME), false)
        .set_column_dictionary_enabled(ColumnPath::from(TIME), false)
        .set_key_value_metadata(Some(vec![
            KeyValue::new("whyroad.lake_version".to_owned(), LAKE_VERSION.to_string()),
            KeyValue::new(ROW_ORDER_KEY.to_owned(), ROW_ORDER.to_owned()),
            KeyValue::new(KEY.to_owned(), contents.to_owned()),
        ]));
    for name in &names {
        if sample(name).is_some_and(|c| matches!(c, Column::Number(values) if !repeats(values))) {
            // Names have dots, and are one part of a path all the same.
            let path = ColumnPath::new(vec![(*name).clone()]);
            properties = properties.set_column_dictionary_enabled(path, false);
        }
    }
    let mut writer: Option<ArrowWriter<File>> = None;
    let properties = properties.build();
    for (_, table) in drives {
        let (ids, frames, times) = keys(table);
        let n = frames.len();
        let mut fields = vec![];
        let mut arrays: Vec<ArrayRef> = vec![];
        let mut push = |name: &str, nullable: bool, array: ArrayRef| {
            fields.push(Field::new(name, array.data_type().clone(), nullable));
            arrays.push(array);
        };
        push("drive_id", false, repeated(table.drive_id.as_str(), n));
        for ids in ids {
            let ids: DictionaryArray<UInt16Type> = ids.iter().collect();
            push("target_id", false, Arc::new(ids));
        }
        push(FRAME, false, Arc::new(UInt32Array::from(frames)));
        push(TIME, false, Arc::new(Int64Array::from(times)));
        for name in &names {
            if let Some(kind) = sample(name) {
                push(name, true, array(columns(table).get(*name), kind, n));
            }
        }
        let schema = Arc::new(Schema::new(fields));
        let batch = RecordBatch::try_new(schema.clone(), arrays).map_err(|e| broken(&e))?;
        let writer = match &mut writer {
            Some(w) => w,
            None => {
                let file = File::create(path).map_err(LakeError::io(path))?;
                writer.insert(
                    ArrowWriter::try_new(file, schema, Some(properties.clone())).map_err(|e| broken(&e))?,
                )
            }
        };
        writer.write(&batch).and_then(|()| writer.flush()).map_err(|e| broken(&e))?;
    }
    let Some(writer) = writer else { return Ok(()) };
    let file = writer.into_inner().map_err(|e| broken(&e))?;
    file.sync_all().map_err(LakeError::io(path))
}

fn repeated(text: &str, n: usize) -> ArrayRef {
    let keys = UInt16Array::from(vec![0; n]);
    let words = StringArray::from_iter_values([text]);
    Arc::new(DictionaryArray::new(keys, Arc::new(words)))
}

/// A column as an array of the type that `kind` has; null where the drive has no such column.
fn array(column: Option<&Column>, kind: &Column, n: usize) -> ArrayRef {
    match (kind, column) {
        (Column::Number(_), Some(Column::Number(v))) => {
            let known = v
                .iter()
                .any(|x| x.is_nan())
                .then(|| NullBuffer::new(BooleanBuffer::collect_bool(v.len(), |i| !v[i].is_nan())));
            Arc::new(Float64Array::new(v.clone().into(), known))
        }
        (Column::Number(_), _) => Arc::new(Float64Array::new_null(n)),
        (Column::Flag(_), Some(Column::Flag(v))) => {
            let bits = |of: fn(&Tri) -> bool| BooleanBuffer::collect_bool(v.len(), |i| of(&v[i]));
            let known = NullBuffer::new(bits(|t| *t != Tri::Unknown));
            Arc::new(BooleanArray::new(bits(|t| *t == Tri::True), Some(known)))
        }
        (Column::Flag(_), _) => Arc::new(BooleanArray::new_null(n)),
        (Column::Category { .. }, Some(Column::Category { codes, names })) => {
            let known = |c: &u16| *c != UNKNOWN_CODE && usize::from(*c) < names.len();
            let nulls = NullBuffer::new(BooleanBuffer::collect_bool(codes.len(), |i| known(&codes[i])));
            let keys: Vec<u16> = codes.iter().map(|c| if known(c) { *c } else { 0 }).collect();
            let keys = UInt16Array::new(keys.into(), Some(nulls));
            Arc::new(DictionaryArray::new(keys, Arc::new(StringArray::from_iter_values(names.iter()))))
        }
        (Column::Category { .. }, _) => {
            let keys = UInt16Array::new_null(n);
            Arc::new(DictionaryArray::new(keys, Arc::new(StringArray::from_iter_values([""]))))
        }
    }
}
