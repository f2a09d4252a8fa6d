//! Record batches across the border to Python: the Arrow PyCapsule interface (C data interface streams), both ways.

use crate::error::of_arrow;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::{RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_schema::SchemaRef;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

/// Name that the interface prescribes for the capsule of a stream.
const STREAM: &std::ffi::CStr = c"arrow_array_stream";

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

/// Takes over the Arrow stream of any object that has `__arrow_c_stream__`.
pub fn stream_of(object: &Bound<'_, PyAny>) -> PyResult<RecordBatchStreamReader> {
    let capsule = object.call_method0("__arrow_c_stream__").map_err(|_| {
        PyTypeError::new_err(
            "an Arrow table is needed: an object with __arrow_c_stream__ (pyarrow, Polars, pandas 3)",
        )
    })?;
    let capsule = capsule.cast_into::<PyCapsule>()?;
    let pointer = capsule.pointer_checked(Some(STREAM))?.cast::<FFI_ArrowArrayStream>();
    // SAFETY: the capsule has the name that the Arrow PyCapsule interface prescribes, so it holds a valid
    // `ArrowArrayStream`. `from_raw` moves it out and leaves a released stream, which the capsule's destructor accepts.
    #[allow(unsafe_code)]
    let reader = unsafe { RecordBatchStreamReader::from_raw(pointer.as_ptr()) };
    reader.map_err(of_arrow)
}

/// All batches of a stream.
pub fn read_all(reader: RecordBatchStreamReader) -> PyResult<(SchemaRef, Vec<RecordBatch>)> {
    let schema = reader.schema();
    let batches = reader.collect::<Result<_, _>>().map_err(of_arrow)?;
    Ok((schema, batches))
}
