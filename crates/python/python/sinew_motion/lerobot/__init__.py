"""LeRobot's interfaces ``Robot`` and ``Teleoperator`` for rigs of Sinew.

This package needs LeRobot 0.6, and so Python 3.12: ``pip install "lerobot[dataset]==0.6.1"``. The rest of
``sinew_motion`` needs neither.

Keys are ``JOINT.pos``, with the names of the rig's dofs. Positions are in degrees, and in millimetres for slides, also
those of a gripper; zero is the zero of the rig file. LeRobot's own SO-100 class reads its gripper in percent, and
counts degrees from the middle of the calibrated range.

The types ``sinew`` and ``sinew_leader`` are registered for LeRobot's commands::

    lerobot-record --robot.discover_packages_path=sinew_motion.lerobot --robot.type=sinew --robot.target=sim:arm.toml \\
        --teleop.type=sinew_leader --teleop.target=sim:arm.toml --teleop.show=wave.show ..
"""

try:
    import lerobot  # noqa: F401
except ImportError as error:
    raise ImportError(
        'sinew_motion.lerobot needs Python 3.12 and LeRobot: pip install "lerobot[dataset]==0.6.1"'
    ) from error

from .config import SinewLeaderConfig, SinewRobotConfig
from .leader import SinewLeader
from .robot import SinewRobot

__all__ = ["SinewLeader", "SinewLeaderConfig", "SinewRobot", "SinewRobotConfig"]
