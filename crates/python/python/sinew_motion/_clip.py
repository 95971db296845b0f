"""Recorded clips."""

from __future__ import annotations

import os
from typing import Literal

import numpy as np

from . import _sinew_motion as _native
from ._arrays import Array


class Clip:
    """A clip of motion capture in metres, ``y`` up, without gaps: a skeleton of J joints in T frames.

    ``read_clip`` creates it.
    """

    def __init__(self, native: _native.NativeClip) -> None:
        self._native = native

    def __repr__(self) -> str:
        return f"Clip({self.name!r}, frames={len(self)}, joints={len(self.joint_names)}, rate_hz={self.rate_hz:g})"

    def __len__(self) -> int:
        return self._native.frame_count

    @property
    def name(self) -> str:
        """The stem of the file."""
        return self._native.name

    @property
    def notes(self) -> list[str]:
        """Sentences about everything that was measured, skipped, filled or changed."""
        return self._native.notes

    @property
    def joint_names(self) -> list[str]:
        """The names of the joints, parents first."""
        return self._native.joint_names

    @property
    def parents(self) -> list[int]:
        """The index of each joint's parent; -1 for the root."""
        return [-1 if parent is None else parent for parent in self._native.parents]

    @property
    def rate_hz(self) -> float:
        """The number of frames a second."""
        return self._native.rate_hz

    @property
    def start_s(self) -> float:
        """The time of the first frame in the file, s; above 0 if an inserted T-pose was skipped."""
        return self._native.start_s

    @property
    def times(self) -> Array:
        """The times of the frames since the first frame, ``(T,)``, s."""
        return np.arange(len(self)) / self.rate_hz

    @property
    def offsets(self) -> Array:
        """The positions of the joints relative to their parents at rest, ``(J, 3)``, m."""
        return self._native.offsets()

    @property
    def local(self) -> Array:
        """The poses of the joints relative to their parents, ``(T, J, 7)``; the root's pose is in the world."""
        return self._native.local()

    @property
    def rotations(self) -> Array:
        """The rotations of the joints relative to their parents, ``(T, J, 4)``: ``x y z w``."""
        return np.ascontiguousarray(self.local[..., 3:])

    @property
    def world(self) -> Array:
        """The poses of the joints in the world, ``(T, J, 7)``."""
        return self._native.world()


def read_clip(
    path: str | os.PathLike[str],
    *,
    cutoff_hz: float | None = None,
    seconds: float | None = None,
    metres_per_unit: float | None = None,
    up: Literal["x", "y", "z"] | None = None,
) -> Clip:
    """Reads a clip: BVH, AMC with its ASF beside it, humanoid3d text, or a built-in clip by name.

    The clip is rotated upright and converted to metres, gaps of up to 0.5 s are filled, and an inserted T-pose is
    skipped. ``Clip.notes`` reports these changes.

    Parameters
    ----------
    path : file, or the name of a built-in clip such as ``punches_01``
    cutoff_hz : cutoff of a low-pass filter, Hz; default: no filter
    seconds : use only the first seconds
    metres_per_unit, up : unit of length and up axis; default: found from the file

    Raises
    ------
    ValueError
        If the file cannot be read; the message contains the file and the expected content.

    >>> clip = read_clip("punches_01", seconds=0.5)
    >>> clip.world.shape == (len(clip), len(clip.joint_names), 7)
    True
    """
    return Clip(_native.read_clip(os.fspath(path), cutoff_hz, seconds, metres_per_unit, up))
