"""Distances between poses, geodesics, importance of joints."""

from __future__ import annotations

import os
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, rows
from ._clip import Clip
from ._rig import Rig

Metric = Literal["angles", "rotations", "positions", "line", "geodesic"]


def pose_distance(
    clip: Clip,
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    *,
    metric: Metric = "line",
    weighted: bool = False,
    steps: int = 10,
    root: str | None = None,
) -> float | Array:
    """Computes distances between poses of a clip's skeleton, relative to its root.

    Parameters
    ----------
    clip : a clip with the skeleton
    a, b : (J, 4) or (T, J, 4), rotations of the joints relative to their parents, as ``Clip.rotations``. If one
        argument has a single pose, it is compared with each pose of the other.
    metric : ``angles`` in rad; ``rotations`` in m rad; ``positions``, ``line`` and ``geodesic`` in m
    weighted : whether joints are weighted by their importance
    steps : number of steps of a line or a geodesic, 1 to 1000
    root : the joint relative to which poses are compared; default: the skeleton's root

    Returns
    -------
    A number for two poses, otherwise (T,).

    Raises
    ------
    ValueError
        For shapes that do not fit, quaternions that are not unit, or an unknown metric or root.

    >>> clip = read_clip("punches_01", seconds=0.5)
    >>> pose_distance(clip, clip.rotations[0], clip.rotations[0])
    0.0
    >>> pose_distance(clip, clip.rotations[0], clip.rotations).shape == (len(clip),)
    True
    """
    first, single_a = rows("a", a, 2, 4)
    second, single_b = rows("b", b, 2, 4)
    out = _native.pose_distance(clip._native, first, second, metric, weighted, steps, root)
    return float(out[0]) if single_a and single_b else out


class Geodesic(NamedTuple):
    """The shortest path between two poses on which bones keep their lengths."""

    length: float
    """The length of the path, m."""
    line_length: float
    """The length of the straight line between the joint coordinates, m."""
    converged: bool
    """Whether the solver reached its tolerance."""
    rotations: Array
    """The poses on the path, ``(steps + 1, J, 4)``."""


def geodesic(
    clip: Clip, a: npt.ArrayLike, b: npt.ArrayLike, *, weighted: bool = False, steps: int = 10
) -> Geodesic:
    """Finds the shortest path between two poses of a clip's skeleton, in float64.

    Parameters
    ----------
    a, b : (J, 4), rotations of the joints relative to their parents
    weighted, steps : as in ``pose_distance``

    Raises
    ------
    ValueError
        As ``pose_distance``.

    >>> clip = read_clip("punches_01", seconds=0.5)
    >>> path = geodesic(clip, clip.rotations[0], clip.rotations[-1])
    >>> path.converged and 0 < path.length <= path.line_length
    True
    """
    joints = len(clip.joint_names)
    first, second = (np.asarray(pose, dtype=np.float64) for pose in (a, b))
    for name, pose in (("a", first), ("b", second)):
        if pose.shape != (joints, 4):
            raise ValueError(f"{name}: expected shape {(joints, 4)}, found {pose.shape}")
    length, line, converged, rotations = _native.geodesic(
        clip._native, first.reshape(1, -1), second.reshape(1, -1), weighted, steps
    )
    return Geodesic(length, line, converged, rotations.reshape(-1, joints, 4))


def importance(
    source: Rig | Clip | str | os.PathLike[str],
    method: Literal["lengths", "cylinders", "mesh"] = "lengths",
    *,
    base: float | None = None,
    discount: float = 0.9,
) -> dict[str, float]:
    """Computes the importance of joints, which depends on how much of a figure each joint moves, and how far.

    Parameters
    ----------
    source : a rig, a clip, or a file of a character (glTF, BVH, URDF), as for ``sinew clip weights``
    method : by ``lengths`` of bones, by ``cylinders`` around them, or by the ``mesh`` of a file
    base : initial weight of every joint, in m, or m³ for surfaces; default: as ``sinew clip weights``
    discount : factor on a bone's length for each joint between the bone and the joint, 0 to 1; only for ``lengths``

    Returns
    -------
    Weight by joint; the sum is 1.

    Raises
    ------
    ValueError
        For an unknown method, a setting out of range, or a file without a mesh.

    >>> weights = importance(Rig.arm(6))
    >>> round(sum(weights.values()), 6), weights["turn1"] > weights["bend6"]
    (1.0, True)
    """
    of = source._native if isinstance(source, (Rig, Clip)) else os.fspath(source)
    names, weights = _native.importance(of, method, base, discount)
    return dict(zip(names, weights))
