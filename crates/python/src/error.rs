//! Exceptions with the messages of Rust's errors.

use std::fmt::Display;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// Returns a `ValueError` with the message of an error, and the messages of its causes if the error displays them.
pub(crate) fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(format!("{error:#}"))
}
