//! Rows of other people's Parquet files as JSON objects: for tables whose cells are texts and lists, such as causal
//! texts. Numbers, texts, truth values, lists and structs; any other type is null. Not for recorded signals.

use crate::encodings::cells;
use crate::encodings::columns::{Columns, read_parquet};
use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, OffsetSizeTrait};
use arrow_schema::DataType;
use serde_json::{Map, Number, Value};
use std::ops::Range;
use std::path::Path;

/// How deep lists and structs may be nested.
const MAX_DEPTH: usize = 16;

/// The rows of a Parquet file; of all columns, or only those named in `columns` that the file has.
pub fn read_rows(path: &Path, columns: Option<&[&str]>) -> Result<Vec<Map<String, Value>>, String> {
    Ok(of_columns(&read_parquet(path)?, columns))
}

/// The rows of a table that was read.
pub(crate) fn of_columns(table: &Columns, columns: Option<&[&str]>) -> Vec<Map<String, Value>> {
    let mut out = Vec::new();
    for batch in &table.0 {
        let schema = batch.schema();
        let wanted = |name: &str| columns.is_none_or(|c| c.contains(&name));
        let taken: Vec<(&str, Vec<Value>)> = schema
            .fields()
            .iter()
            .zip(batch.columns())
            .filter(|(field, _)| wanted(field.name()))
            .map(|(field, column)| (field.name().as_str(), values(column, MAX_DEPTH)))
            .collect();
        for row in 0..batch.num_rows() {
            let cell = |(name, values): &(&str, Vec<Value>)| ((*name).to_owned(), values[row].clone());
            out.push(taken.iter().map(cell).collect());
        }
    }
    out
}

/// One value per row; null where the type is not one of those above or is nested too deeply.
fn values(array: &ArrayRef, depth: usize) -> Vec<Value> {
    let nulls = || vec![Value::Null; array.len()];
    let Some(depth) = depth.checked_sub(1) else { return nulls() };
    let present = |i: usize, value: Value| if array.is_null(i) { Value::Null } else { value };
    match array.data_type() {
        DataType::Boolean => {
            let cells = array.as_boolean();
            (0..array.len()).map(|i| present(i, Value::Bool(cells.value(i)))).collect()
        }
        DataType::Struct(fields) => {
            let parts: Vec<(String, Vec<Value>)> = fields
                .iter()
                .zip(array.as_struct().columns())
                .map(|(field, column)| (field.name().clone(), values(column, depth)))
                .collect();
            let row = |i: usize| parts.iter().map(|(name, cells)| (name.clone(), cells[i].clone())).collect();
            (0..array.len()).map(|i| present(i, Value::Object(row(i)))).collect()
        }
        DataType::List(_) | DataType::LargeList(_) | DataType::FixedSizeList(_, _) => {
            let (items, range) = lists(array);
            let items = values(&items, depth);
            (0..array.len())
                .map(|i| present(i, Value::Array(items.get(range[i].clone()).unwrap_or_default().to_vec())))
                .collect()
        }
        kind if kind.is_integer() => filled(cells::integers(array), Value::from).unwrap_or_else(nulls),
        kind if kind.is_floating() => {
            filled(cells::numbers(array), |v| Number::from_f64(v).map_or(Value::Null, Value::Number))
                .unwrap_or_else(nulls)
        }
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View | DataType::Dictionary(_, _) => {
            filled(cells::texts(array, &mut { cells::FREE_TEXT }), Value::from).unwrap_or_else(nulls)
        }
        _ => nulls(),
    }
}

/// One value per cell.
fn filled<T>(cells: Result<Vec<Option<T>>, String>, value: impl Fn(T) -> Value) -> Option<Vec<Value>> {
    Some(cells.ok()?.into_iter().map(|cell| cell.map_or(Value::Null, &value)).collect())
}

/// The items of all lists of a list array, and the range of each row in them.
fn lists(array: &ArrayRef) -> (ArrayRef, Vec<Range<usize>>) {
    fn offsets<O: OffsetSizeTrait>(array: &ArrayRef) -> (ArrayRef, Vec<Range<usize>>) {
        let lists = array.as_list::<O>();
        let range = |pair: &[O]| pair[0].as_usize()..pair[1].as_usize();
        (lists.values().clone(), lists.value_offsets().windows(2).map(range).collect())
    }
    match array.data_type() {
        DataType::List(_) => offsets::<i32>(array),
        DataType::LargeList(_) => offsets::<i64>(array),
        _ => {
            let lists = array.as_fixed_size_list();
            let size = usize::try_from(lists.value_length()).unwrap_or(0);
            (lists.values().clone(), (0..array.len()).map(|row| row * size..(row + 1) * size).collect())
        }
    }
}
