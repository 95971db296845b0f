"""State errors of poses."""

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
    """Their rates, rad/s; zero without velocities."""
    linear_rate: Array
    """Their rates, m/s; zero without velocities."""


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
    ``egocentric``            relative to body 0; of body 0 in the world
    ``heading``               in the world, after the desired figure was moved to the measured body 0: its place on the
                              ground and its heading about ``y``, but not its height
    ``linear_compensation``   in the world, with the desired body turned so that its heaviest child reaches its place
    ``projection``            in the world, against the nearest pose of the rig; the frames are one performance
    ========================  ==========================================================================================

    Parameters
    ----------
    desired, measured : (B, 7) or (T, B, 7)
    parents : index of each body's parent, -1 for body 0; ``world`` and ``heading`` do without
    rig : the rig instead of ``parents``; ``projection`` needs it
    desired_velocity, measured_velocity : (B, 6) or (T, B, 6), linear then angular, in world axes; default: zeros
    beta : weight of the linear compensation, 0 to 2

    Raises
    ------
    ValueError
        For shapes that do not fit, NaN, quaternions that are not unit, or a method without the tree it needs.

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
