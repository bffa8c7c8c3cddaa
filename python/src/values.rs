//! Values as Python objects: structures as records or dictionaries, rows as tables.

use numpy::{Element, PyArray1};
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

/// A record as a dictionary, to which more can be added.
///
/// # Errors
/// If it is no structure.
pub fn fields<'py, T: Serialize>(py: Python<'py>, value: &T) -> PyResult<Bound<'py, PyDict>> {
    Ok(object(py, value)?.cast_into::<PyDict>()?)
}

/// A `Record` of the fields.
///
/// # Errors
/// If Python raises one.
pub fn record(fields: Bound<'_, PyDict>) -> PyResult<Bound<'_, PyAny>> {
    class(fields.py(), "Record")?.call1((fields,))
}

fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("vibroimpact._records")?.getattr(name)
}

/// Rows as columns, a `Table`, in the order of the fields.
///
/// # Errors
/// If a row is no structure.
pub fn table<'py, T: Serialize>(py: Python<'py>, rows: &[T]) -> PyResult<Bound<'py, PyAny>> {
    let columns = PyDict::new(py);
    for row in rows {
        for (key, value) in fields(py, row)? {
            match columns.get_item(&key)? {
                Some(column) => column.cast::<PyList>()?.append(value)?,
                None => columns.set_item(key, PyList::new(py, [value])?)?,
            }
        }
    }
    class(py, "Table")?.call1((columns,))
}

/// Puts values into a record, as an array.
pub fn put<'py, T: Element>(
    found: &Bound<'py, PyDict>,
    name: &str,
    values: impl IntoIterator<Item = T>,
) -> PyResult<()> {
    found.set_item(name, PyArray1::from_iter(found.py(), values))
}

/// A number that is not always there: NaN where it is not.
pub fn or_nan(number: Option<impl Into<f64>>) -> f64 {
    number.map_or(f64::NAN, Into::into)
}
