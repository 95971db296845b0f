"""Positions of a rig as LeRobot's flat dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .._arrays import Array
from .._board import Board
from .._rig import Rig
from .config import SinewLeaderConfig, SinewRobotConfig

_DOFS = {"fixed": 0, "revolute": 1, "prismatic": 1, "universal": 2}
_UNITS = {"prismatic": 1e-3}


class Joints:
    """The dofs of a rig with the unit of each, and the rig's board, which is not opened yet."""

    def __init__(self, config: SinewRobotConfig | SinewLeaderConfig) -> None:
        kind, _, file = config.target.partition(":")
        is_file = kind == "sim" and bool(file)
        if is_file == (config.rig is not None):
            raise ValueError(f'rig: expected the file of the rig of {config.target}, or "sim:FILE" without it')
        self._target, self._servos = "sim" if is_file else config.target, config.servos
        self.rig = Rig.load(file if is_file else str(config.rig))
        kinds = self.rig.joint_kinds
        for name, kind in zip(self.rig.joint_names, kinds):
            if kind not in _DOFS:
                raise ValueError(f"`{name}`: expected a joint with angles or distances, found a {kind} joint")
        self._unit = np.repeat([_UNITS.get(kind, np.pi / 180.0) for kind in kinds], [_DOFS[kind] for kind in kinds])
        self.keys = [f"{name}.pos" for name in self.rig.dof_names]

    def open(self) -> Board:
        """Opens the board of the rig."""
        return Board.open(self._target, self.rig, servos=self._servos)

    @property
    def features(self) -> dict[str, type]:
        return dict.fromkeys(self.keys, float)

    def named(self, q: Array) -> dict[str, float]:
        """Returns a pose with names, in degrees and millimetres."""
        return dict(zip(self.keys, (q / self._unit).tolist()))

    def pose(self, action: Mapping[str, Any]) -> Array:
        """Returns the pose of an action, with each position within its range."""
        wrong = set(self.keys).symmetric_difference(action)
        if wrong:
            raise ValueError(f"action: expected the keys {', '.join(self.keys)}; missing or unknown: {sorted(wrong)}")
        q = np.array([float(action[key]) for key in self.keys]) * self._unit
        for key, number in zip(self.keys, q):
            if not np.isfinite(number):
                raise ValueError(f"action: `{key}` is {action[key]}; it must be a finite number")
        within: Array = np.clip(q, self.rig.lower, self.rig.upper)
        return within
