//! The extension module behind the Python package `whyroad` (python/whyroad): arguments in, Arrow tables out.
//!
//! Tables cross the border through the Arrow PyCapsule interface, without copies of their columns. Every error is a
//! `whyroad.WhyroadError` with the code, message and hint of its diagnostic. What a call computes is in the crate of
//! that step; nothing is decided here.

mod error;
mod lake;
mod signals;
mod table;
mod validate;

use pyo3::prelude::*;

/// Native part of the package `whyroad`.
#[pymodule]
fn _whyroad(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<table::Table>()?;
    module.add_class::<lake::Lake>()?;
    module.add_function(wrap_pyfunction!(lake::open_lake, module)?)?;
    module.add_function(wrap_pyfunction!(lake::read_parquet, module)?)?;
    module.add_function(wrap_pyfunction!(validate::validate_text, module)?)?;
    module.add_function(wrap_pyfunction!(validate::validate_table, module)?)?;
    Ok(())
}
