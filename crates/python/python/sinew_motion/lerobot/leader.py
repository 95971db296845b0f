"""A leader for LeRobot: a show, or a rig that a hand leads."""

from __future__ import annotations

import time
from typing import Any

from lerobot.teleoperators import Teleoperator
from lerobot.utils.decorators import check_if_already_connected, check_if_not_connected

from .._arrays import Array
from .._board import Board
from .._show import Show
from .config import SinewLeaderConfig
from .joints import Joints


class SinewLeader(Teleoperator):
    """A leader: a show that plays, or the measured joints of a rig. The rig of a leader is limp, so that a hand moves
    it.

    >>> import pathlib, tempfile
    >>> from sinew_motion import Rig, bake
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> Rig.arm(2).save(folder / "arm.toml")
    >>> bake([[0.0, 0.5], [0.0, 0.5]], Rig.arm(2), rate_hz=2).save(folder / "still.show")
    >>> config = SinewLeaderConfig(
    ...     target=f"sim:{folder}/arm.toml", show=f"{folder}/still.show", calibration_dir=folder
    ... )
    >>> with SinewLeader(config) as leader:
    ...     {key: round(degrees, 1) for key, degrees in leader.get_action().items()}
    {'turn1.pos': 0.0, 'bend2.pos': 28.6}
    """

    config_class = SinewLeaderConfig
    name = "sinew_leader"

    def __init__(self, config: SinewLeaderConfig) -> None:
        super().__init__(config)
        self.config = config
        self.joints = Joints(config)
        self.show = None if config.show is None else Show.open(config.show)
        rig, show = self.joints.rig, self.show
        # Rigs that fit no board have the checksum 0, so their coordinates are counted, too.
        if show is not None and (show.rig_crc != rig.crc or show.sample(0.0)[0].size != rig.nq):
            raise ValueError(f"{config.show}: the show is of another rig")
        self.board: Board | None = None
        """The board of the leading rig while it is connected; ``None`` with a show."""
        self._is_connected = False
        self._begun: float | None = None

    @property
    def action_features(self) -> dict[str, type]:
        """The positions of the leader."""
        return self.joints.features

    @property
    def feedback_features(self) -> dict[str, type]:
        """Nothing: a leader gives no feedback of forces."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether the leader leads."""
        return self._is_connected

    @check_if_already_connected
    def connect(self, calibrate: bool = True) -> None:
        """Opens the board of the leading rig. A show begins at the first ``get_action``.

        Raises
        ------
        BoardError
            If nothing answers, or the board has another rig.
        """
        if self.show is None:
            self.board = self.joints.open()
        self._is_connected = True
        self.restart()

    @property
    def is_calibrated(self) -> bool:
        """True: the rig file contains the zeros of the joints."""
        return True

    def calibrate(self) -> None:
        """Does nothing: see ``is_calibrated``."""

    def configure(self) -> None:
        """Does nothing: a board configures its servos by itself."""

    def restart(self) -> None:
        """Lets the show begin again at the next ``get_action``, for example for the next episode."""
        self._begun = None

    @check_if_not_connected
    def get_action(self) -> dict[str, Any]:
        """Returns the positions of the leader now. After its end a loop begins again; any other show stays at its last
        pose.
        """
        return dict(self.joints.named(self._pose()))

    def _pose(self) -> Array:
        if self.board is not None:
            return self.board.state().q
        assert self.show is not None
        now = time.monotonic()
        if self._begun is None:
            self._begun = now
        return self.show.sample(now - self._begun)[0]

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Accepts no feedback: see ``feedback_features``.

        Raises
        ------
        ValueError
            For any feedback.
        """
        if feedback:
            raise ValueError(f"feedback: expected none, found {', '.join(feedback)}")

    def disconnect(self) -> None:
        """Closes the board of the leading rig."""
        board, self.board = self.board, None
        self._is_connected = False
        if board is not None:
            board.close()
