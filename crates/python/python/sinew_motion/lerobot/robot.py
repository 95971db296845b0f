"""A rig as a robot of LeRobot."""

from __future__ import annotations

from typing import Any

from lerobot.robots import Robot
from lerobot.utils.decorators import check_if_already_connected, check_if_not_connected

from .._board import Board, BoardError
from .config import SinewRobotConfig
from .joints import Joints


class SinewRobot(Robot):
    """A board with its rig as a robot of LeRobot.

    ``connect`` arms the rig: torque comes on at the measured pose. ``disconnect`` stops it: the rig goes to its rest
    pose and is lowered, and torque is switched off. The end of a ``with`` block, or of the program, stops it, too.

    >>> import pathlib, tempfile
    >>> from sinew_motion import Rig
    >>> folder = tempfile.TemporaryDirectory()
    >>> arm = pathlib.Path(folder.name) / "arm.toml"
    >>> Rig.arm(2).save(arm)
    >>> config = SinewRobotConfig(target=f"sim:{arm}", calibration_dir=pathlib.Path(folder.name))
    >>> with SinewRobot(config) as robot:
    ...     observation = robot.get_observation()
    ...     sent = robot.send_action({**observation, "bend2.pos": 1000.0})
    >>> list(observation), sent["bend2.pos"] < 180.0
    (['turn1.pos', 'bend2.pos'], True)
    """

    config_class = SinewRobotConfig
    name = "sinew"

    def __init__(self, config: SinewRobotConfig) -> None:
        super().__init__(config)
        self.config = config
        self.joints = Joints(config)
        self.board: Board | None = None
        """The board while it is connected, for example for ``goto``."""

    @property
    def observation_features(self) -> dict[str, type]:
        """The measured positions."""
        return self.joints.features

    @property
    def action_features(self) -> dict[str, type]:
        """The wanted positions."""
        return self.joints.features

    @property
    def is_connected(self) -> bool:
        """Whether the board is open."""
        return self.board is not None

    @check_if_already_connected
    def connect(self, calibrate: bool = True) -> None:
        """Opens the board, and arms the rig.

        Raises
        ------
        BoardError
            If nothing answers, or the controller refuses to arm; the message contains the reason.
        """
        self.board = self.joints.open()
        try:
            self.configure()
            self.board.arm()
        except BaseException:
            self.disconnect()
            raise

    @property
    def is_calibrated(self) -> bool:
        """True: the rig file contains the zeros of the joints (``sinew servo calibrate``)."""
        return True

    def calibrate(self) -> None:
        """Does nothing: see ``is_calibrated``."""

    def configure(self) -> None:
        """Does nothing: a board configures its servos by itself."""

    @check_if_not_connected
    def get_observation(self) -> dict[str, Any]:
        """Returns the measured positions, from the newest telemetry of 30 a second."""
        assert self.board is not None
        return dict(self.joints.named(self.board.state().q))

    @check_if_not_connected
    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Sends a pose that the rig shall follow, at least ten times a second; otherwise the rig holds.

        Returns
        -------
        The pose that was sent: within the ranges of the joints, and with tied joints where their leaders put them. The
        board limits speeds, so a far pose is reached later.

        Raises
        ------
        ValueError
            If a joint is missing or unknown, or a number is not finite.
        BoardError
            If a fault or another terminal has stopped the rig.
        """
        assert self.board is not None
        q = self.joints.pose(action)
        try:
            sent = self.board.live(q)
        except BoardError:
            # After a pause between two actions the rig holds, and follows again. After a fault it does not.
            if self.board.state().state != "holding":
                raise
            sent = self.board.live(q)
        return dict(self.joints.named(sent))

    def disconnect(self) -> None:
        """Stops the rig, waits until torque is off, and closes the board."""
        board, self.board = self.board, None
        if board is not None:
            board.close()
