"""The controller's tick."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, row
from ._rig import Rig


class Step(NamedTuple):
    """The result of a tick, for each dof."""

    effort: Array
    """Efforts to apply, after all limits, ``(nv,)``, N m or N."""
    feedforward: Array
    """The part of the efforts that gravity and the desired acceleration need, ``(nv,)``, N m or N."""
    limited: list[str | None]
    """Limit that acted on each effort: ``torque``, ``force``, ``not_finite``, ``supply``; ``None`` without one."""


class Tracker:
    """A controller that makes a rig follow targets: the same code as on a board, in float32.

    Parameters
    ----------
    rig : a rig of at most 64 bodies; its effort limits are those of the controller
    method : ``recommended``, or another name of ``methods()``
    rate_hz : ticks a second
    latency_ticks : number of ticks from a measurement to the tick in which the computed effort acts
    settings : other settings, by the names of ``[controller]`` in ``sinew evaluate --format json``, such as
        ``{"kp": 200}``

    Raises
    ------
    ValueError
        If a setting is unknown, invalid, or invalid for this rig.

    >>> arm = Rig.arm(6)
    >>> tracker = Tracker(arm, rate_hz=500)
    >>> step = tracker.step(arm.home, arm.home)
    >>> step.effort.shape, step.limited
    ((6,), [None, None, None, None, None, None])
    >>> Tracker(arm, settings={"kp": -1.0})
    Traceback (most recent call last):
        ...
    ValueError: kp: expected a finite number above 0, found -1
    """

    def __init__(
        self,
        rig: Rig,
        method: str = "recommended",
        *,
        rate_hz: float = 500.0,
        latency_ticks: int = 0,
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        self._nv = rig.nv
        text = json.dumps({"method": method, **(settings or {})}, allow_nan=True)
        self._native = _native.NativeTracker(rig._native, text, rate_hz, latency_ticks)

    def step(
        self,
        q_desired: npt.ArrayLike,
        q: npt.ArrayLike,
        qd: npt.ArrayLike | None = None,
        *,
        qd_desired: npt.ArrayLike | None = None,
        qdd_desired: npt.ArrayLike | None = None,
    ) -> Step:
        """Computes the efforts of a tick from its targets and the measurement.

        Parameters
        ----------
        q_desired : (nq,), for the time at which the efforts act
        q : (nq,), as measured
        qd : (nv,), as measured; default: differences of the measured positions
        qd_desired, qdd_desired : (nv,); default: zeros

        Raises
        ------
        ValueError
            For a wrong length, NaN, or a quaternion that is not unit. There is no effort then: the caller must keep the
            servos safe.

        >>> import numpy as np
        >>> arm = Rig.arm(2)
        >>> tracker = Tracker(arm, "local", rate_hz=500, settings={"kp": 1e5})
        >>> lifted = tracker.step(arm.home + [0.0, 1.0], arm.home, np.zeros(2))
        >>> lifted.limited[1]
        'torque'
        """
        zeros = np.zeros(self._nv)
        effort, feedforward, limited = self._native.step(
            row("q_desired", q_desired),
            zeros if qd_desired is None else row("qd_desired", qd_desired),
            zeros if qdd_desired is None else row("qdd_desired", qdd_desired),
            row("q", q),
            None if qd is None else row("qd", qd),
        )
        return Step(np.array(effort), np.array(feedforward), limited)

    def skip(self, ticks: int) -> None:
        """Tells the tracker that ticks were missed, so that it computes the next speeds over the elapsed time.

        >>> arm = Rig.arm(2)
        >>> tracker = Tracker(arm, rate_hz=500)
        >>> _ = tracker.step(arm.home, arm.home)
        >>> tracker.skip(3)
        """
        self._native.skip(ticks)
