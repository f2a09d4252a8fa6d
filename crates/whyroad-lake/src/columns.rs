//! Columns in memory to Arrow arrays and back, with the one convention of the lake: unknown is null on disk,
//! NaN or `None` in memory.

use arrow_array::builder::{Float64Builder, ListBuilder, StringBuilder, StructBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt32Type};
use arrow_array::{
    Array, ArrayRef, BinaryArray, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray,
    UInt32Array,
};
use arrow_buffer::BooleanBuffer;
use arrow_schema::{ArrowError, DataType, Field, Fields, Schema, SchemaRef};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::Arc;
use whyroad_model::road_map::Point3;

use crate::LakeError;

/// A table on its way to disk: named columns of one length.
#[derive(Default)]
pub(crate) struct TableBuilder {
    fields: Vec<Field>,
    columns: Vec<Stored>,
}

/// The values of a column of a [`TableBuilder`].
pub(crate) enum Stored {
    /// One per row.
    Array(ArrayRef),
    /// Texts, each with the number of rows in which it is there; the next one is another.
    Runs(Vec<(String, usize)>),
}

impl Stored {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        match self {
            Self::Array(array) => array.len(),
            Self::Runs(runs) => runs.iter().map(|(_, rows)| rows).sum(),
        }
    }

    fn array(self) -> ArrayRef {
        match self {
            Self::Array(array) => array,
            Self::Runs(runs) => {
                let texts = runs.iter().flat_map(|(text, rows)| std::iter::repeat_n(text, *rows));
                Arc::new(StringArray::from_iter_values(texts))
            }
        }
    }
}

impl TableBuilder {
    fn push(mut self, name: &str, nullable: bool, array: ArrayRef) -> Self {
        self.fields.push(Field::new(name, array.data_type().clone(), nullable));
        self.columns.push(Stored::Array(array));
        self
    }

    /// Numbers; NaN becomes null.
    pub fn numbers(self, name: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let unknown = values.iter().fold(false, |unknown, v| unknown | v.is_nan());
        let known =
            unknown.then(|| BooleanBuffer::collect_bool(values.len(), |i| !values[i].is_nan()).into());
        self.push(name, true, Arc::new(Float64Array::new(values.into(), known)))
    }
    /// Texts that are always known and mostly that of the row before: each with a number of rows. What has many rows is
    /// built and stored so in a fraction of the time.
    pub fn text_runs<'t>(mut self, name: &str, texts: impl IntoIterator<Item = (&'t str, usize)>) -> Self {
        let mut runs: Vec<(String, usize)> = Vec::new();
        for (text, rows) in texts.into_iter().filter(|(_, rows)| *rows > 0) {
            match runs.last_mut() {
                Some((last, count)) if last == text => *count += rows,
                _ => runs.push((text.to_owned(), rows)),
            }
        }
        self.fields.push(Field::new(name, DataType::Utf8, false));
        self.columns.push(Stored::Runs(runs));
        self
    }
    /// Integers that are always known: times.
    pub fn integers(self, name: &str, values: impl IntoIterator<Item = i64>) -> Self {
        self.push(name, false, Arc::new(Int64Array::from_iter_values(values)))
    }
    /// Integers that may be unknown.
    pub fn integers_or_null(self, name: &str, values: impl IntoIterator<Item = Option<i64>>) -> Self {
        self.push(name, true, Arc::new(values.into_iter().collect::<Int64Array>()))
    }
    /// Counts and indices that are always known.
    pub fn indices(self, name: &str, values: impl IntoIterator<Item = u32>) -> Self {
        self.push(name, false, Arc::new(UInt32Array::from_iter_values(values)))
    }
    /// Texts that are always known.
    pub fn texts<S: AsRef<str>>(self, name: &str, values: impl IntoIterator<Item = S>) -> Self {
        self.push(name, false, Arc::new(StringArray::from_iter_values(values)))
    }
    /// Texts that may be unknown.
    pub fn texts_or_null<S: AsRef<str>>(
        self,
        name: &str,
        values: impl IntoIterator<Item = Option<S>>,
    ) -> Self {
        let array: StringArray = values.into_iter().collect();
        self.push(name, true, Arc::new(array))
    }
    /// Contents of files.
    pub fn bytes<'a>(self, name: &str, values: impl IntoIterator<Item = &'a [u8]>) -> Self {
        self.push(name, false, Arc::new(BinaryArray::from_iter_values(values)))
    }
    /// Truth values that may be unknown.
    pub fn flags(self, name: &str, values: impl IntoIterator<Item = Option<bool>>) -> Self {
        let array: BooleanArray = values.into_iter().collect();
        self.push(name, true, Arc::new(array))
    }
    /// Lists of texts.
    pub fn text_lists<'a>(self, name: &str, rows: impl IntoIterator<Item = &'a [String]>) -> Self {
        let mut b = ListBuilder::new(StringBuilder::new());
        for row in rows {
            for text in row {
                b.values().append_value(text);
            }
            b.append(true);
        }
        self.push(name, false, Arc::new(b.finish()))
    }
    /// Lines and polygons: lists of `{x, y, z}`.
    pub fn points<'a>(self, name: &str, rows: impl IntoIterator<Item = &'a [Point3]>) -> Self {
        let fields: Vec<Field> = ["x", "y", "z"].map(|n| Field::new(n, DataType::Float64, true)).into();
        let mut b = ListBuilder::new(StructBuilder::from_fields(fields, 0));
        for row in rows {
            for p in row {
                for (i, v) in [p.x, p.y, p.z].into_iter().enumerate() {
                    if let Some(c) = b.values().field_builder::<Float64Builder>(i) {
                        c.append_option((!v.is_nan()).then_some(v));
                    }
                }
                b.values().append(true);
            }
            b.append(true);
        }
        self.push(name, false, Arc::new(b.finish()))
    }
    /// A group of columns under one name.
    pub fn group(self, name: &str, inner: TableBuilder) -> Self {
        let arrays = inner.columns.into_iter().map(Stored::array).collect();
        let array = arrow_array::StructArray::new(Fields::from(inner.fields), arrays, None);
        self.push(name, false, Arc::new(array))
    }
    /// All columns; fails when their lengths differ.
    pub fn finish(self) -> Result<RecordBatch, ArrowError> {
        let arrays = self.columns.into_iter().map(Stored::array).collect();
        RecordBatch::try_new(Arc::new(Schema::new(self.fields)), arrays)
    }
    /// The columns with their names and types.
    pub fn columns(&self) -> impl Iterator<Item = (&Field, &Stored)> {
        self.fields.iter().zip(&self.columns)
    }
    /// The number of rows, where it is the same for all columns.
    pub fn rows(&self) -> Option<usize> {
        let rows = self.columns.first()?.rows();
        self.columns.iter().all(|column| column.rows() == rows).then_some(rows)
    }
    /// The columns' names and types.
    pub fn schema(&self) -> SchemaRef {
        Arc::new(Schema::new(self.fields.clone()))
    }
}

/// A table read from disk. Every getter fails with the file's name when the column is missing or of another type.
#[derive(Debug)]
pub(crate) struct Table {
    pub path: PathBuf,
    pub batch: RecordBatch,
}

impl Table {
    pub fn rows(&self) -> usize {
        self.batch.num_rows()
    }

    /// For columns that lakes of earlier builds lack, check this first.
    pub fn has(&self, name: &str) -> bool {
        self.batch.column_by_name(name).is_some()
    }

    fn column(&self, name: &str) -> Result<&ArrayRef, LakeError> {
        self.batch
            .column_by_name(name)
            .ok_or_else(|| LakeError::broken(&self.path, format!("column '{name}' is missing")))
    }

    fn wrong_type(&self, name: &str) -> LakeError {
        LakeError::broken(&self.path, format!("column '{name}' is not of the expected type"))
    }

    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, LakeError> {
        let a = self.column(name)?.as_primitive_opt::<Float64Type>().ok_or_else(|| self.wrong_type(name))?;
        Ok(or_nan(a))
    }
    pub fn integers(&self, name: &str) -> Result<Vec<i64>, LakeError> {
        let a = self.column(name)?.as_primitive_opt::<Int64Type>().ok_or_else(|| self.wrong_type(name))?;
        self.no_null(name, a)?;
        Ok(a.values().to_vec())
    }
    pub fn integers_or_null(&self, name: &str) -> Result<Vec<Option<i64>>, LakeError> {
        let a = self.column(name)?.as_primitive_opt::<Int64Type>().ok_or_else(|| self.wrong_type(name))?;
        Ok(a.iter().collect())
    }
    pub fn indices(&self, name: &str) -> Result<Vec<u32>, LakeError> {
        let a = self.column(name)?.as_primitive_opt::<UInt32Type>().ok_or_else(|| self.wrong_type(name))?;
        self.no_null(name, a)?;
        Ok(a.values().to_vec())
    }
    /// Texts that must all be known.
    pub fn texts(&self, name: &str) -> Result<&StringArray, LakeError> {
        let a = self.texts_or_null(name)?;
        self.no_null(name, a)?;
        Ok(a)
    }
    pub fn texts_or_null(&self, name: &str) -> Result<&StringArray, LakeError> {
        self.column(name)?.as_string_opt::<i32>().ok_or_else(|| self.wrong_type(name))
    }
    /// Contents of files, which are always known.
    pub fn bytes(&self, name: &str) -> Result<Vec<Vec<u8>>, LakeError> {
        let a = self.column(name)?.as_binary_opt::<i32>().ok_or_else(|| self.wrong_type(name))?;
        self.no_null(name, a)?;
        Ok(a.iter().flatten().map(<[u8]>::to_vec).collect())
    }
    pub fn flags(&self, name: &str) -> Result<Vec<Option<bool>>, LakeError> {
        let a = self.column(name)?.as_boolean_opt().ok_or_else(|| self.wrong_type(name))?;
        Ok(a.iter().collect())
    }
    pub fn text_lists(&self, name: &str) -> Result<Vec<Vec<String>>, LakeError> {
        let a = self.column(name)?.as_list_opt::<i32>().ok_or_else(|| self.wrong_type(name))?;
        (0..a.len())
            .map(|i| {
                let row = a.value(i);
                let texts = row.as_string_opt::<i32>().ok_or_else(|| self.wrong_type(name))?;
                Ok(texts.iter().map(|t| t.unwrap_or_default().to_owned()).collect())
            })
            .collect()
    }
    pub fn points(&self, name: &str) -> Result<Vec<Vec<Point3>>, LakeError> {
        let a = self.column(name)?.as_list_opt::<i32>().ok_or_else(|| self.wrong_type(name))?;
        (0..a.len())
            .map(|i| {
                let row = a.value(i);
                let s = row.as_struct_opt().ok_or_else(|| self.wrong_type(name))?;
                let axis = |n: &str| {
                    s.column_by_name(n)
                        .and_then(|c| c.as_primitive_opt::<Float64Type>())
                        .map(or_nan)
                        .ok_or_else(|| self.wrong_type(name))
                };
                let (x, y, z) = (axis("x")?, axis("y")?, axis("z")?);
                Ok((0..s.len()).map(|k| Point3 { x: x[k], y: y[k], z: z[k] }).collect())
            })
            .collect()
    }
    /// Texts of a closed set; fails on a text that is not in it.
    pub fn members<T: DeserializeOwned>(&self, name: &str) -> Result<Vec<Option<T>>, LakeError> {
        let column = self.texts_or_null(name)?;
        column.iter().map(|t| t.map(|t| self.member(name, t)).transpose()).collect()
    }
    /// One text of a closed set.
    pub fn member<T: DeserializeOwned>(&self, name: &str, text: &str) -> Result<T, LakeError> {
        serde_json::from_value(serde_json::Value::String(text.to_owned()))
            .map_err(|_| LakeError::broken(&self.path, format!("'{text}' is not a value of column '{name}'")))
    }

    fn no_null(&self, name: &str, a: &dyn Array) -> Result<(), LakeError> {
        if a.null_count() == 0 {
            return Ok(());
        }
        Err(LakeError::broken(&self.path, format!("column '{name}' has nulls")))
    }
}

fn or_nan(a: &Float64Array) -> Vec<f64> {
    if a.null_count() == 0 {
        return a.values().to_vec();
    }
    if a.null_count() == a.len() {
        return vec![f64::NAN; a.len()];
    }
    a.iter().map(|v| v.unwrap_or(f64::NAN)).collect()
}

/// The name of a unit variant as serde writes it: the one spelling of closed sets in all of Whyroad's files.
pub(crate) fn member_name<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(s)) => s,
        // Only unit variants of plain enums are passed here; they always become a string.
        _ => String::new(),
    }
}

/// An all-unknown column in memory is an empty vector ("the log has none").
pub(crate) fn empty_if_unknown<T>(values: Vec<T>, is_known: impl Fn(&T) -> bool) -> Vec<T> {
    if values.iter().any(is_known) { values } else { Vec::new() }
}
