//! Conversion between arrays of NumPy and rows of numbers.

use numpy::ndarray::{Array, Dimension, IntoDimension};
use numpy::{IntoPyArray as _, PyArray, PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::error::value;

/// Rows of numbers. They are copied from an array, so that other threads of Python cannot change them.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    pub(crate) count: usize,
    pub(crate) width: usize,
    pub(crate) numbers: Vec<f64>,
}

impl Rows {
    /// Copies an array whose rows must have `width` numbers.
    pub(crate) fn of(
        name: &str,
        array: &PyReadonlyArray2<'_, f64>,
        width: usize,
    ) -> PyResult<Self> {
        let count = count_rows(name, array, width)?;
        Ok(Self { count, width, numbers: array.as_array().iter().copied().collect() })
    }

    /// Returns an error unless the number of rows is `count`.
    pub(crate) fn expect(&self, name: &str, count: usize) -> PyResult<()> {
        expect_rows(name, self.count, count)
    }

    /// Returns a row.
    pub(crate) fn row(&self, index: usize) -> &[f64] {
        &self.numbers[index * self.width..][..self.width]
    }

    /// Returns all rows in f32, the core's precision.
    pub(crate) fn single(&self) -> SingleRows {
        SingleRows {
            width: self.width,
            numbers: self.numbers.iter().copied().map(single).collect(),
        }
    }
}

/// Rows of numbers in f32, the core's precision.
#[derive(Debug, Clone)]
pub(crate) struct SingleRows {
    width: usize,
    numbers: Vec<f32>,
}

impl SingleRows {
    /// Returns a row.
    pub(crate) fn row(&self, index: usize) -> &[f32] {
        &self.numbers[index * self.width..][..self.width]
    }
}

/// Returns the number of rows of an array, and an error unless each row has `width` numbers.
pub(crate) fn count_rows(
    name: &str,
    array: &PyReadonlyArray2<'_, f64>,
    width: usize,
) -> PyResult<usize> {
    let &[count, found] = array.shape() else { return Err(value("an array of rows")) };
    check_width(name, found, width).map(|()| count)
}

/// Returns an error unless a row has `width` numbers.
pub(crate) fn check_width(name: &str, found: usize, width: usize) -> PyResult<()> {
    if found == width {
        return Ok(());
    }
    Err(value(format!("{name}: expected {width} numbers in a row, found {found}")))
}

/// Returns an error unless an array has `count` rows.
pub(crate) fn expect_rows(name: &str, found: usize, count: usize) -> PyResult<()> {
    if found == count {
        return Ok(());
    }
    Err(value(format!(
        "{name}: expected {count} rows, as many as the first array has, found {found}"
    )))
}

/// Converts a number to f32, the core's precision. NaN stays NaN, and a number that is too large becomes infinite; the
/// core refuses both.
#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
pub(crate) fn single(number: f64) -> f32 {
    number as f32
}

/// Makes an array of NumPy from numbers in the order of its memory.
pub(crate) fn array<D: Dimension>(
    py: Python<'_>,
    shape: impl IntoDimension<Dim = D>,
    numbers: Vec<f64>,
) -> PyResult<Bound<'_, PyArray<f64, D>>> {
    let shape = shape.into_dimension();
    Ok(Array::from_shape_vec(shape, numbers).map_err(value)?.into_pyarray(py))
}
