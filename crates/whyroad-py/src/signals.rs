//! Signal tables as record batches: numbers keep their buffers; unknown becomes null.

use arrow_array::types::UInt16Type;
use arrow_array::{
    ArrayRef, BooleanArray, DictionaryArray, Float64Array, RecordBatch, StringArray,
    TimestampNanosecondArray, UInt16Array, UInt32Array,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef, TimeUnit};
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::{Column, SignalTable};
use whyroad_signals::catalog::{Catalog, SignalKind};

/// What the rows of a table are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// One per frame.
    Frames,
    /// One per target and frame.
    Targets,
}

/// The schema of these signals: the same for every drive, whatever it lacks.
pub fn schema(catalog: &Catalog, rows: Rows, names: &[String]) -> SchemaRef {
    let mut fields = vec![Field::new("drive_id", DataType::Utf8, false)];
    if rows == Rows::Targets {
        fields.push(Field::new("target_id", DataType::Utf8, false));
        fields.push(Field::new("class", DataType::Utf8, false));
    }
    fields.push(Field::new("frame", DataType::UInt32, false));
    fields.push(Field::new("time", DataType::Timestamp(TimeUnit::Nanosecond, None), false));
    for name in names {
        let kind = match catalog.get(name).map(|d| &d.kind) {
            Some(SignalKind::Flag) => DataType::Boolean,
            Some(SignalKind::Category(_)) => {
                DataType::Dictionary(Box::new(DataType::UInt16), Box::new(DataType::Utf8))
            }
            _ => DataType::Float64,
        };
        fields.push(Field::new(name, kind, true));
    }
    Arc::new(Schema::new(fields))
}

/// The signals of one drive in `schema`; a signal that the drive cannot support is null throughout.
pub fn batch(
    table: SignalTable,
    rows: Rows,
    names: &[String],
    schema: &SchemaRef,
) -> Result<RecordBatch, ArrowError> {
    let SignalTable { drive_id, times, targets, mut frame_columns, mut target_columns, .. } = table;
    let mut columns: Vec<ArrayRef> = Vec::new();
    let at = |frames: Vec<usize>, columns: &mut Vec<ArrayRef>| {
        let time: Vec<i64> = frames.iter().map(|f| times[*f].0).collect();
        let frame: Vec<u32> = frames.into_iter().map(|f| u32::try_from(f).unwrap_or(u32::MAX)).collect();
        columns.push(Arc::new(UInt32Array::from(frame)));
        columns.push(Arc::new(TimestampNanosecondArray::from(time)));
    };
    let count = match rows {
        Rows::Frames => times.len(),
        Rows::Targets => targets.iter().map(|t| t.frames.len()).sum(),
    };
    columns.push(Arc::new(StringArray::from_iter_values(std::iter::repeat_n(drive_id.as_str(), count))));
    match rows {
        Rows::Frames => at((0..count).collect(), &mut columns),
        Rows::Targets => {
            let spans = || targets.iter().flat_map(|t| (t.frames.start..t.frames.end).map(move |f| (t, f)));
            columns.push(Arc::new(StringArray::from_iter_values(spans().map(|(t, _)| t.id.as_str()))));
            columns.push(Arc::new(StringArray::from_iter_values(spans().map(|(t, _)| t.class.id()))));
            at(spans().map(|(_, f)| f).collect(), &mut columns);
        }
    }
    let held = if rows == Rows::Frames { &mut frame_columns } else { &mut target_columns };
    let first = columns.len();
    for (i, name) in names.iter().enumerate() {
        columns.push(match held.remove(name.as_str()) {
            Some(column) => array(column),
            None => arrow_array::new_null_array(schema.field(first + i).data_type(), count),
        });
    }
    RecordBatch::try_new(schema.clone(), columns)
}

fn array(column: Column) -> ArrayRef {
    match column {
        Column::Number(values) => {
            let known = values.iter().map(|v| !v.is_nan()).collect::<Vec<bool>>();
            let nulls = known.contains(&false).then(|| known.into());
            Arc::new(Float64Array::new(values.into(), nulls))
        }
        Column::Flag(values) => {
            Arc::new(values.into_iter().map(whyroad_model::Tri::known).collect::<BooleanArray>())
        }
        Column::Category { codes, names } => {
            let keys: UInt16Array = codes.into_iter().map(|c| (c != UNKNOWN_CODE).then_some(c)).collect();
            let words = StringArray::from_iter_values(names.iter());
            // Codes come from the catalog; one beyond the words cannot be stored, and would be null here.
            match DictionaryArray::<UInt16Type>::try_new(keys, Arc::new(words)) {
                Ok(array) => Arc::new(array),
                Err(_) => arrow_array::new_null_array(
                    &DataType::Dictionary(Box::new(DataType::UInt16), Box::new(DataType::Utf8)),
                    0,
                ),
            }
        }
    }
}
