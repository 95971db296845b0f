"""Conversion of input to arrays of rows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def rows(name: str, numbers: npt.ArrayLike, inner: int = 1, last: int | None = None) -> tuple[Array, bool]:
    """Returns numbers as rows, and whether they were a single row.

    ``inner`` is the number of axes of a row; a row with several axes is flattened. ``last`` is the required length of
    the last axis.
    """
    try:
        array = np.asarray(numbers, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers in rows of equal length: {error}") from None
    if last is not None and array.ndim and array.shape[-1] != last:
        raise ValueError(f"{name}: expected {last} numbers in the last axis, found {array.shape[-1]}")
    if array.ndim == inner:
        return np.ascontiguousarray(array.reshape(1, -1)), True
    if array.ndim == inner + 1:
        return np.ascontiguousarray(array.reshape(array.shape[0], -1 if array.size else _width(array))), False
    raise ValueError(
        f"{name}: expected an array of {inner} axes, or of {inner + 1} with time first, found shape {array.shape}"
    )


def _width(array: Array) -> int:
    return int(np.prod(array.shape[1:]))


def same_rows(name: str, numbers: npt.ArrayLike | None, count: int, width: int) -> Array:
    """Returns numbers as ``count`` rows; a single row is repeated, and ``None`` stands for zeros."""
    if numbers is None:
        return np.zeros((count, width))
    array, single = rows(name, numbers)
    if single and count != 1:
        return np.repeat(array, count, axis=0)
    return array


def row(name: str, numbers: npt.ArrayLike) -> Array:
    """Returns a single row of numbers."""
    array, single = rows(name, numbers)
    if not single:
        raise ValueError(f"{name}: expected a single row, found shape {np.shape(numbers)}")
    first: Array = array[0]
    return first
