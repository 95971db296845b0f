"""State errors between desired and measured poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, rows
from ._rig import Rig

Method = Literal["local", "world", "egocentric", "heading", "linear_compensation", "projection"]


class StateErrors(NamedTuple):
    """Errors of bodies, desired minus measured, in the axes of the method's frame: ``(B, 3)`` or ``(T, B, 3)``."""

    angular: Array
    """Rotation vectors from the measured to the desired orientations, rad."""
    linear: Array
    """Differences of positions, m."""
    angular_rate: Array
    """Rates of ``angular``, rad/s; zero without velocities."""
    linear_rate: Array
    """Rates of ``linear``, m/s; zero without velocities."""


def errors(
    desired: npt.ArrayLike,
    measured: npt.ArrayLike,
    method: Method = "world",
    *,
    parents: Sequence[int] | None = None,
    rig: Rig | None = None,
    desired_velocity: npt.ArrayLike | None = None,
    measured_velocity: npt.ArrayLike | None = None,
    beta: float = 1.0,
) -> StateErrors:
    """Computes the state errors of bodies from their poses in the world.

    ========================  ==========================================================================================
    method                    error of a body
    ========================  ==========================================================================================
    ``world``                 in the world
    ``local``                 relative to its parent
    ``egocentric``            relative to body 0; for body 0 in the world
    ``heading``               in the world, after the desired figure was moved to the horizontal position and the
                              heading (about ``y``) of the measured body 0; its height does not change
    ``linear_compensation``   in the world, after the desired body was turned towards its heaviest child's desired place
    ``projection``            in the world, against the nearest pose of the rig; all frames belong to one motion
    ========================  ==========================================================================================

    Parameters
    ----------
    desired, measured : (B, 7) or (T, B, 7)
    parents : index of each body's parent, -1 for body 0; ``world`` and ``heading`` do not need it
    rig : a rig, instead of ``parents``; ``projection`` needs a rig
    desired_velocity, measured_velocity : (B, 6) or (T, B, 6), linear then angular, in world axes; default: zeros
    beta : weight of the linear compensation, 0 to 2

    Raises
    ------
    ValueError
        For shapes that do not match, NaN, quaternions that are not unit, or if the method needs a tree and has none.

    >>> arm = Rig.arm(6)
    >>> desired, measured = arm.fk(arm.home), arm.fk(arm.home + 0.1)
    >>> errors(desired, measured, "local", rig=arm).angular.shape
    (7, 3)
    >>> errors(desired, measured, "local")
    Traceback (most recent call last):
        ...
    ValueError: parents or rig: this method needs the tree of the bodies
    """
    wanted, single = rows("desired", desired, 2, 7)
    found, _ = rows("measured", measured, 2, 7)
    bodies = wanted.shape[1] // 7
    rates = [
        None if of is None else rows(name, of, 2, 6)[0]
        for name, of in (("desired_velocity", desired_velocity), ("measured_velocity", measured_velocity))
    ]
    tree = None if parents is None else [None if parent < 0 else int(parent) for parent in parents]
    native = None if rig is None else rig._native
    out = _native.errors(method, bodies, wanted, found, rates[0], rates[1], tree, native, float(beta))
    if single:
        out = out[0]
    return StateErrors(out[..., 0:3], out[..., 3:6], out[..., 6:9], out[..., 9:12])
