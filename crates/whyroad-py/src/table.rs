//! Record batches across the border to Python: the Arrow PyCapsule interface (C data interface streams), both ways.

use crate::error::of_arrow;
use arrow_array::ffi::{FFI_ArrowArray, FFI_ArrowSchema, from_ffi};
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::{Array as _, RecordBatch, RecordBatchIterator, RecordBatchReader, StructArray};
use arrow_schema::SchemaRef;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::ffi::CStr;

/// Names that the interface prescribes for capsules.
const STREAM: &CStr = c"arrow_array_stream";
const SCHEMA: &CStr = c"arrow_schema";
const ARRAY: &CStr = c"arrow_array";

/// A table: record batches of one schema. pandas, Polars, pyarrow and DuckDB read it through `__arrow_c_stream__`.
#[pyclass(frozen, module = "whyroad")]
pub struct Table {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Table {
    /// A table of these batches, which all have `schema`.
    pub fn new(schema: SchemaRef, batches: Vec<RecordBatch>) -> Self {
        Self { schema, batches }
    }
}

#[pymethods]
impl Table {
    /// The same data as a table of this package; columns are shared, not copied. `data` is any object with
    /// `__arrow_c_stream__` or `__arrow_c_array__`.
    #[staticmethod]
    fn from_arrow(data: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (schema, batches) = batches_of(data)?;
        Ok(Self::new(schema, batches))
    }

    /// The schema of the table.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema.as_ref()).map_err(of_arrow)?;
        PyCapsule::new_with_value(py, schema, SCHEMA)
    }

    /// The Arrow C stream of the table. The batches are shared, not copied; `requested_schema` is not supported and
    /// ignored, as the interface allows.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let batches = self.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, self.schema.clone());
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), STREAM)
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    /// Names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|f| f.name().clone()).collect()
    }

    /// As a `pyarrow.Table` (needs pyarrow).
    fn to_arrow<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py().import("pyarrow")?.call_method1("table", (this,))
    }

    /// As a `pandas.DataFrame` (needs pyarrow and pandas).
    fn to_pandas<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::to_arrow(this)?.call_method0("to_pandas")
    }

    /// As a `polars.DataFrame` (needs Polars).
    fn to_polars<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py().import("polars")?.call_method1("DataFrame", (this,))
    }

    fn __repr__(&self) -> String {
        format!("whyroad.Table({} rows, {} columns)", self.__len__(), self.schema.fields().len())
    }
}

/// Schema and batches of any object of the Arrow PyCapsule interface: a table (`__arrow_c_stream__`) or a record batch
/// (`__arrow_c_array__`).
pub fn batches_of(object: &Bound<'_, PyAny>) -> PyResult<(SchemaRef, Vec<RecordBatch>)> {
    if object.hasattr("__arrow_c_stream__")? {
        let capsule = object.call_method0("__arrow_c_stream__")?.cast_into::<PyCapsule>()?;
        let pointer = capsule.pointer_checked(Some(STREAM))?.cast::<FFI_ArrowArrayStream>();
        // SAFETY: the capsule has the name that the Arrow PyCapsule interface prescribes, so it holds a valid
        // `ArrowArrayStream`. `from_raw` moves it out and leaves a released stream, which the capsule's destructor
        // accepts.
        #[allow(unsafe_code)]
        let reader = unsafe { RecordBatchStreamReader::from_raw(pointer.as_ptr()) };
        let reader = reader.map_err(of_arrow)?;
        let schema = reader.schema();
        return Ok((schema, reader.collect::<Result<_, _>>().map_err(of_arrow)?));
    }
    if object.hasattr("__arrow_c_array__")? {
        let (schema, array): (Bound<'_, PyCapsule>, Bound<'_, PyCapsule>) =
            object.call_method0("__arrow_c_array__")?.extract()?;
        let schema = schema.pointer_checked(Some(SCHEMA))?.cast::<FFI_ArrowSchema>();
        let array = array.pointer_checked(Some(ARRAY))?.cast::<FFI_ArrowArray>();
        // SAFETY: as above; `from_raw` moves the array out, the schema is only read while its capsule lives.
        #[allow(unsafe_code)]
        let data = unsafe { from_ffi(FFI_ArrowArray::from_raw(array.as_ptr()), schema.as_ref()) };
        let rows = StructArray::from(data.map_err(of_arrow)?);
        if rows.null_count() > 0 {
            return Err(PyTypeError::new_err("a record batch is needed: this array of structs has nulls"));
        }
        let batch = RecordBatch::from(rows);
        return Ok((batch.schema(), vec![batch]));
    }
    Err(PyTypeError::new_err(
        "an Arrow table is needed: an object with __arrow_c_stream__ or __arrow_c_array__ (pyarrow, Polars, pandas 3)",
    ))
}
