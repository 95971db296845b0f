//! Exceptions with the words of Rust's errors.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// Returns a `ValueError` with the words of an error, and of its causes if the error prints them.
pub(crate) fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(format!("{error:#}"))
}
