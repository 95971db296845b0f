"""Configurations, which LeRobot's command line reads. LeRobot finds the class of a configuration by its name."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.robots import RobotConfig
from lerobot.teleoperators import TeleoperatorConfig


@RobotConfig.register_subclass("sinew")
@dataclass(kw_only=True)
class SinewRobotConfig(RobotConfig):
    """A board and its rig, as for ``Board.open``."""

    target: str
    """``"sim:arm.toml"``, ``"sim"``, the port of a board, or ``"console"``."""
    rig: str | None = None
    """The file of the rig; omitted for ``"sim:FILE"``."""
    servos: list[str] = field(default_factory=list)
    """Kinds of servos for joints without servos, such as those of a URDF."""


@TeleoperatorConfig.register_subclass("sinew_leader")
@dataclass(kw_only=True)
class SinewLeaderConfig(TeleoperatorConfig):
    """A leader: a show, or a rig that a hand leads."""

    target: str
    """The board of the leading rig, as for a robot. With a show, only its rig is used."""
    rig: str | None = None
    servos: list[str] = field(default_factory=list)
    show: str | None = None
    """The file of a show, which leads in place of a board."""
