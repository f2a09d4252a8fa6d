//! Rows of other people's Parquet files as JSON objects: for tables whose cells are texts and lists, such as causal
//! texts. Numbers, texts, truth values, lists and structs; any other type is null. Not for recorded signals.

use crate::encodings::columns::read_parquet;
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef};
use arrow_schema::DataType;
use serde_json::{Map, Number, Value};
use std::path::Path;

/// How deep lists and structs may be nested.
const MAX_DEPTH: usize = 16;

/// The rows of a Parquet file; of all columns, or only those named in `columns` that the file has.
pub fn read_rows(path: &Path, columns: Option<&[&str]>) -> Result<Vec<Map<String, Value>>, String> {
    let table = read_parquet(path)?;
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
    Ok(out)
}

/// One value per row; null where the type is none of those above or nested too deep.
fn values(array: &ArrayRef, depth: usize) -> Vec<Value> {
    let nulls = || vec![Value::Null; array.len()];
    let Some(depth) = depth.checked_sub(1) else { return nulls() };
    let as_type = |to: DataType| arrow_cast::cast(array, &to).ok();
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
            let item = match array.data_type() {
                DataType::List(f) | DataType::LargeList(f) | DataType::FixedSizeList(f, _) => f.clone(),
                _ => return nulls(),
            };
            let Some(lists) = as_type(DataType::LargeList(item)) else { return nulls() };
            let lists = lists.as_list::<i64>();
            let items = values(lists.values(), depth);
            let range = |i: usize| {
                let (from, to) = (lists.value_offsets()[i], lists.value_offsets()[i + 1]);
                usize::try_from(from).unwrap_or(0)..usize::try_from(to).unwrap_or(0)
            };
            (0..array.len())
                .map(|i| present(i, Value::Array(items.get(range(i)).unwrap_or_default().to_vec())))
                .collect()
        }
        kind if kind.is_integer() => match as_type(DataType::Int64) {
            Some(cells) => {
                let cells = cells.as_primitive::<arrow_array::types::Int64Type>();
                (0..array.len())
                    .map(|i| if cells.is_null(i) { Value::Null } else { cells.value(i).into() })
                    .collect()
            }
            None => nulls(),
        },
        kind if kind.is_floating() => match as_type(DataType::Float64) {
            Some(cells) => {
                let number = |v: Option<f64>| v.and_then(Number::from_f64).map_or(Value::Null, Value::Number);
                cells.as_primitive::<Float64Type>().iter().map(number).collect()
            }
            None => nulls(),
        },
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View | DataType::Dictionary(_, _) => {
            match as_type(DataType::Utf8) {
                Some(cells) => {
                    let cells = cells.as_string::<i32>();
                    (0..array.len())
                        .map(|i| if cells.is_null(i) { Value::Null } else { cells.value(i).into() })
                        .collect()
                }
                None => nulls(),
            }
        }
        _ => nulls(),
    }
}
