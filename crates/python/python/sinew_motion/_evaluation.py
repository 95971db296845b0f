"""Evaluations of control methods, and sweeps."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._rig import Rig

Columns = dict[str, "npt.NDArray[np.float64] | list[str]"]
Paths = Sequence["str | os.PathLike[str]"]


def methods() -> dict[str, str]:
    """Returns the names and descriptions of the control methods.

    >>> methods()["world"]
    'World Space Error'
    """
    return dict(_native.methods())


def evaluate(
    clips: Paths = (),
    *,
    rig: Rig | None = None,
    methods: Sequence[str] | None = None,
    scales: Sequence[float] = (1.0, 1.1),
    setup: Mapping[str, Any] | None = None,
    seconds: float | None = None,
    rate_hz: float | None = None,
    mapping: str | os.PathLike[str] | None = None,
    rows: Literal["total", "clip", "time"] = "total",
    progress: Callable[[int, int], object] | None = None,
) -> Columns:
    """Evaluates control methods: a simulated figure or rig tracks clips, and its errors are measured.

    The results and defaults are those of ``sinew evaluate``.

    Parameters
    ----------
    clips : files and folders; default: the built-in clips, or with ``rig`` its built-in motions
    rig : a rig, instead of the figure of 18 bodies
    methods : names of ``methods()``; default: the paper's three methods, or with ``rig`` all methods
    scales : factors on the figure's dimensions, 0.1 to 10
    setup : settings of the runs, nested as in ``sinew evaluate --format json``: ``{"plant": {"kind": "articulated"}}``
    seconds : use only the first seconds of every clip
    rate_hz : rate of control and plant, Hz; default: 100, or with ``rig`` 500
    mapping : name or file of the mapping of the clips' skeleton; default: chosen among the known mappings
    rows : ``total``: a row for each scale, method and group of joints; ``clip``: for each clip, too; ``time``: the mean
        errors over time
    progress : is called with the numbers of finished and of all steps, about 20 times a second

    Returns
    -------
    Columns for ``pandas.DataFrame`` or ``polars.DataFrame``: lists of text, or arrays of float64 with NaN for empty
    fields.

    Raises
    ------
    ValueError
        For wrong settings and files, and if the simulation of a figure becomes unstable.

    >>> table = evaluate(methods=["world"], scales=[1.0], seconds=0.3, setup={"plant": {"kind": "articulated"}})
    >>> table["method"], table["joints"]
    (['world', 'world'], ['all', 'leaf'])
    >>> evaluate(methods=["wrold"])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    ValueError: methods: expected some of local, world, ..., found `wrold`
    """
    tables = _native.evaluate(
        _paths(clips),
        None if rig is None else rig._native,
        None if methods is None else list(methods),
        [float(scale) for scale in scales],
        json.dumps(setup or {}),
        seconds,
        rate_hz,
        None if mapping is None else os.fspath(mapping),
        progress,
    )
    kinds = ("total", "clip", "time")
    if rows not in kinds:
        raise ValueError(f"rows: expected one of {', '.join(kinds)}, found `{rows}`")
    return _columns(tables[kinds.index(rows)])


def sweep(
    file: str | os.PathLike[str],
    clips: Paths = (),
    *,
    rig: Rig | None = None,
    seconds: float | None = None,
    rate_hz: float | None = None,
    mapping: str | os.PathLike[str] | None = None,
    output: str | os.PathLike[str] | None = None,
    rows: Literal["cell", "clip"] = "cell",
    progress: Callable[[int, int], object] | None = None,
) -> Columns:
    """Evaluates all combinations of many settings, as ``sinew evaluate sweep`` does.

    Parameters
    ----------
    file : description of the sweep, TOML
    clips, rig, seconds, rate_hz, mapping, progress : as in ``evaluate``
    output : folder for journal and tables; an interrupted sweep continues from this journal. Default: a temporary
        folder
    rows : a row for each ``cell``, or for each cell and ``clip``

    Returns
    -------
    Columns, as ``evaluate`` returns them.

    Raises
    ------
    ValueError
        For wrong files and settings; then no cell is evaluated.

    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "sweep.toml"
    ...     lines = ['setup.plant.kind = "articulated"', "[[grid]]", 'controller.method = ["local", "world"]']
    ...     _ = path.write_text("\\n".join(lines))
    ...     sweep(path, seconds=0.2)["controller.method"]
    ['local', 'world']
    """
    tables = _native.sweep(
        os.fspath(file),
        _paths(clips),
        None if rig is None else rig._native,
        seconds,
        rate_hz,
        None if mapping is None else os.fspath(mapping),
        None if output is None else os.fspath(output),
        progress,
    )
    kinds = ("cell", "clip")
    if rows not in kinds:
        raise ValueError(f"rows: expected one of {', '.join(kinds)}, found `{rows}`")
    return _columns(tables[kinds.index(rows)])


def _paths(clips: Paths) -> list[str]:
    if isinstance(clips, (str, os.PathLike)):
        clips = [clips]
    return [os.fspath(clip) for clip in clips]


def _columns(text: str) -> Columns:
    """Returns the columns of a CSV: numbers where every field is a number or empty, otherwise text."""
    head, *body = csv.reader(io.StringIO(text))
    columns: Columns = {}
    for place, name in enumerate(head):
        fields = [row[place] for row in body]
        try:
            columns[name] = np.array([float(field) if field else np.nan for field in fields])
        except ValueError:
            columns[name] = fields
    return columns
