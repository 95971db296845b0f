"""A clip on a rig: mapping, motion, show."""

from __future__ import annotations

import builtins
import os
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, rows
from ._clip import Clip
from ._rig import Rig


def map(clip: Clip, rig: Rig) -> str:
    """Proposes which joint of a rig follows which joint of a clip.

    Returns
    -------
    TOML to edit, as ``sinew clip map --rig`` prints it: each pair with its confidence and its reason.

    Raises
    ------
    ValueError
        If the rig has no arm, leg or head.

    >>> text = map(read_clip("punches_01", seconds=0.5), Rig.arm(6))
    >>> "[[landmark]]" in text
    True
    """
    return _native.map(clip._native, rig._native)


class Retargeted(NamedTuple):
    """A motion of a rig that follows a clip, frame by frame."""

    q: Array
    """Positions of the rig, ``(T, nq)``."""
    rate_hz: float
    """Frames a second."""
    limbs_mean: float
    """Mean angle between corresponding limbs of performer and rig, rad; NaN if no limbs are compared."""
    limbs_max: float
    """Largest of these angles, rad."""


def retarget(
    clip: Clip, rig: Rig, *, mapping: str | os.PathLike[str] | None = None, mirror: bool = False
) -> Retargeted:
    """Computes the motion of a rig that follows a clip, within the rig's ranges.

    Parameters
    ----------
    mapping : text of TOML as ``map`` returns it, or a file; default: by names and geometry
    mirror : whether left and right are swapped

    Raises
    ------
    ValueError
        If the rig or the clip has no limb, or the mapping does not fit them.

    >>> clip, arm = read_clip("punches_01", seconds=0.5), Rig.arm(6)
    >>> retarget(clip, arm).q.shape == (len(clip), arm.nq)
    True
    """
    q, mean, most = _native.retarget(clip._native, rig._native, _text(mapping), mirror)
    return Retargeted(q, clip.rate_hz, mean, most)


class Show:
    """A show: the motion of a rig as splines, the file that a board plays.

    ``bake`` creates a show; ``Show.open`` reads a file of ``sinew bake``.
    """

    def __init__(self, native: _native.NativeShow) -> None:
        self._native = native

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Show:
        """Reads a show.

        Raises
        ------
        ValueError
            If the file is damaged or not a show.

        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "nod.show"
        ...     bake([[0.0, 0.0], [0.1, 0.0], [0.0, 0.0]], Rig.arm(2), rate_hz=2).save(path)
        ...     Show.open(path).duration
        1.0
        """
        with builtins.open(path, "rb") as file:
            return cls(_native.open_show(file.read()))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the show as a file.

        >>> import os, tempfile
        >>> show = bake([[0.0, 0.0], [0.1, 0.0], [0.0, 0.0]], Rig.arm(2), rate_hz=2)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     show.save(os.path.join(folder, "nod.show"))
        """
        with builtins.open(path, "wb") as file:
            file.write(self.bytes)

    def __repr__(self) -> str:
        return f"Show(duration={self.duration:g}, bytes={len(self.bytes)})"

    @property
    def bytes(self) -> builtins.bytes:
        """The content of the file."""
        return self._native.bytes

    @property
    def duration(self) -> float:
        """The duration, s."""
        return self._native.duration_s

    @property
    def rate_hz(self) -> float:
        """The rate of the samples that the splines follow, Hz."""
        return self._native.rate_hz

    @property
    def is_loop(self) -> bool:
        """Whether the end continues at the start."""
        return self._native.is_loop

    @property
    def rig_crc(self) -> int:
        """The checksum of the rig for which the show was baked; 0 if no board can hold the rig."""
        return self._native.rig_crc

    @property
    def cues(self) -> list[tuple[str, float]]:
        """Cues: name, and time in s."""
        return self._native.cues

    @property
    def fitted(self) -> str | None:
        """The changes by a fit, in words; ``None`` without a fit, and for a show from a file."""
        return self._native.fitted

    @property
    def report(self) -> dict[str, npt.NDArray[np.float64] | list[str]]:
        """Places where the show exceeds a limit of its rig, as columns for a data frame.

        ``joint``, ``kind`` (range, speed, acceleration, effort, heat), ``from_s``, ``to_s``, ``worst_s``, ``value``,
        ``limit``. The columns are empty if the show exceeds no limit, and for a show from a file.

        >>> show = bake([[0.0, 0.0], [3.0, 0.0], [0.0, 0.0]], Rig.arm(2), rate_hz=20)
        >>> "speed" in show.report["kind"]
        True
        """
        names = ("joint", "kind", "from_s", "to_s", "worst_s", "value", "limit")
        columns = list(zip(*self._native.excesses)) or [()] * len(names)
        return {
            name: list(column) if name in ("joint", "kind") else np.array(column, dtype=np.float64)
            for name, column in zip(names, columns)
        }

    def sample(self, t: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Returns positions, speeds and accelerations at times. They are exact derivatives of the splines.

        After the end a loop starts its next round; any other show stays at its last pose.

        Parameters
        ----------
        t : a time, or (T,) times, s, from 0 to 1e9

        Returns
        -------
        ``q`` (nq,) or (T, nq), ``qd`` and ``qdd`` (nv,) or (T, nv).

        Raises
        ------
        ValueError
            For a time that is negative, too large or NaN.

        >>> show = bake([[0.0, 0.0], [0.1, 0.0], [0.0, 0.0]], Rig.arm(2), rate_hz=2)
        >>> q, qd, qdd = show.sample(0.5)
        >>> abs(float(q[0]) - 0.1) < 5e-3
        True
        >>> [part.shape for part in show.sample([0.0, 0.25, 0.5])]
        [(3, 2), (3, 2), (3, 2)]
        """
        times = np.asarray(t, dtype=np.float64)
        if times.ndim > 1:
            raise ValueError(f"t: expected a time or a row of times, found shape {times.shape}")
        q, qd, qdd = self._native.sample(np.atleast_1d(times).tolist())
        return (q[0], qd[0], qdd[0]) if times.ndim == 0 else (q, qd, qdd)


def bake(
    motion: Clip | str | os.PathLike[str] | npt.ArrayLike,
    rig: Rig,
    *,
    rate_hz: float | None = None,
    mapping: str | os.PathLike[str] | None = None,
    mirror: bool = False,
    fit: bool = False,
    keep_time: bool = False,
    loop_blend_s: float | None = None,
    tolerance: float = np.deg2rad(0.25),
    cues: Sequence[tuple[str, float]] = (),
) -> Show:
    """Bakes a motion into a show for a rig, as ``sinew bake`` does. ``Show.report`` lists the exceeded limits.

    Parameters
    ----------
    motion : a clip; or rows of positions (T, nq) with ``rate_hz``; or a CSV, JSON or show with a motion of the rig
    rate_hz : rate of rows, Hz
    mapping, mirror : as in ``retarget``, for a clip
    fit : whether the motion is brought within all limits of the rig
    keep_time : whether a fit keeps the time: motions become smaller or rounder, none becomes slower; implies ``fit``
    loop_blend_s : length of the blend of the end into the start, s, for a loop; default: no loop
    tolerance : largest error of angles, rad; by default 0.25 degrees
    cues : names, and times in the motion, s

    Raises
    ------
    ValueError
        If the motion exceeds the bounds of the format, or cannot be fitted or looped.

    >>> clip = read_clip("punches_01", seconds=1.0, cutoff_hz=6)
    >>> show = bake(clip, Rig.arm(6), cues=[("bow", 0.5)])
    >>> show.cues
    [('bow', 0.5)]
    >>> bake([[0.0, 0.0]] * 3, Rig.arm(2))
    Traceback (most recent call last):
        ...
    ValueError: rate_hz: expected the rate of the rows of q, in Hz from 1 to 10000
    """
    source: _native.NativeClip | str | Array
    if isinstance(motion, Clip):
        source = motion._native
    elif isinstance(motion, (str, os.PathLike)):
        source = os.fspath(motion)
    else:
        source, single = rows("q", motion)
        if single:
            raise ValueError("q: expected at least two rows")
    marks = [(str(name), float(time_s)) for name, time_s in cues]
    return Show(
        _native.bake(
            source,
            rig._native,
            rate_hz,
            _text(mapping),
            mirror,
            fit,
            keep_time,
            loop_blend_s,
            float(tolerance),
            marks,
        )
    )


def _text(mapping: str | os.PathLike[str] | None) -> str | None:
    return None if mapping is None else os.fspath(mapping)
