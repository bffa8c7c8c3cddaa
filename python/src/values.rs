//! Values as Python objects: records as dictionaries, tables as columns.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use pythonize::pythonize;
use serde::Serialize;

use crate::error::wrong;

/// A value as Python has it: structures as dictionaries, lists as lists, nothing as `None`.
///
/// # Errors
/// If it has no such form.
pub fn object<'py, T: Serialize>(py: Python<'py>, value: &T) -> PyResult<Bound<'py, PyAny>> {
    pythonize(py, value).map_err(|e| wrong(e.to_string()))
}

/// A record as a dictionary.
///
/// # Errors
/// If it is no structure.
pub fn record<'py, T: Serialize>(py: Python<'py>, value: &T) -> PyResult<Bound<'py, PyDict>> {
    Ok(object(py, value)?.cast_into::<PyDict>()?)
}

/// Rows as columns: a dictionary of lists, in the order of the fields.
///
/// # Errors
/// If a row is no structure.
pub fn columns<'py, T: Serialize>(py: Python<'py>, rows: &[T]) -> PyResult<Bound<'py, PyDict>> {
    let table = PyDict::new(py);
    for row in rows {
        for (key, value) in record(py, row)? {
            match table.get_item(&key)? {
                Some(column) => column.cast::<PyList>()?.append(value)?,
                None => table.set_item(key, PyList::new(py, [value])?)?,
            }
        }
    }
    Ok(table)
}
