"""Boards: at a port, simulated, or driven by a console."""

from __future__ import annotations

import atexit
import os
import weakref
from collections.abc import Sequence
from types import TracebackType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _sinew_motion as _native
from ._arrays import Array, row
from ._rig import Rig
from ._show import Show

BoardError = _native.BoardError


class BoardState(NamedTuple):
    """The state of a rig, from the newest telemetry."""

    state: str
    """The state's name: off, limp, arming, holding, playing, stopping, lowering, faulted, ..."""
    q: Array
    """The measured pose, ``(nq,)``."""
    effort: Array
    """The commanded efforts, ``(nv,)``, N m or N."""
    supply_v: float
    """The supply of the servos, V; 0 if it is not measured."""
    show_s: float
    """The time in the show, s."""
    error: float
    """The largest angle between pose and target, rad; NaN without a target."""
    temperature: Array
    """The temperatures of the servos, degC; NaN for servos that do not report it."""
    heat: Array
    """The heat of each servo's windings, as the board's model computes it; 1 is the maximum."""


class BoardFault(NamedTuple):
    """A fault in the log of a board."""

    name: str
    state: str
    """The board's state when the fault occurred."""
    servo: int | None
    time_s: float
    """The time from the board's start to the fault, s."""
    times: int
    is_warning: bool
    when: str
    """The condition that causes the fault."""
    remedy: str


_open: weakref.WeakSet[Board] = weakref.WeakSet()


class Board:
    """A board with its rig, for use in a ``with`` block. At its end, also after an exception or Ctrl-C, the rig goes to
    its rest pose and is lowered, and torque is switched off. A second Ctrl-C ends the block at once; the
    board then lowers the rig by itself.

    Nothing moves before ``arm``. Errors of the board raise ``BoardError``, wrong input raises ``ValueError``. If Ctrl-C
    ends a motion, the rig holds until the block ends.

    A console's board is moved by the rules for its pages: only who has the wheel arms and moves the rig. ``open`` takes
    the wheel if nobody drives; ``take`` and ``release`` take and release it. If this process dies or is halted, the rig
    holds, at the latest after 2 s. After a hold of somebody else, ``live`` is refused until this program calls
    ``hold``, ``goto``, ``play`` or ``arm``. At the end of the block, the rig is stopped only if this program has the
    wheel, and has armed or moved the rig.

    Methods can be called from several threads. ``hold``, ``stop``, ``estop`` and ``close`` end what runs, and refuse
    the motions that wait. Other terminals stop the rig, too: ``sinew stop``, ``sinew estop``, ``Console``. Then the
    rig moves again only after ``clear`` and ``arm``.

    >>> with Board.open("sim", Rig.arm(2)) as board:
    ...     board.state().state
    'limp'
    """

    def __init__(self, native: _native.NativeBoard, rig: Rig) -> None:
        self._native = native
        self.rig = rig
        _open.add(self)

    @classmethod
    def open(
        cls, target: str | os.PathLike[str], rig: Rig | None = None, *, servos: Sequence[str] = ()
    ) -> Board:
        """Opens a board.

        Parameters
        ----------
        target : ``"sim"`` for a simulated board with ``rig``, ``"sim:arm.toml"`` for a simulated board with the rig in
            this file; the serial port of a board that has ``rig``; ``"console"`` for the board of this user's only
            running console, or ``"console:NAME"``
        rig : the rig of the board; omitted for ``"sim:FILE"``
        servos : kinds of servos for joints without servos, as for ``sinew play --servo``

        Raises
        ------
        ValueError
            If there is no rig, or the file is not a rig.
        BoardError
            If nothing answers, or the board has another rig.

        >>> Board.open("sim")
        Traceback (most recent call last):
            ...
        ValueError: rig: expected the rig of the board, or "sim:FILE"
        >>> Board.open("console:no-port", Rig.arm(2))  # doctest: +ELLIPSIS
        Traceback (most recent call last):
            ...
        sinew_motion.BoardError: there is no console `no-port`: ...
        """
        text = os.fspath(target)
        kind, _, file = text.partition(":")
        if kind == "sim" and file:
            if rig is not None:
                raise ValueError('rig: expected none beside "sim:FILE"')
            rig = Rig.load(file)
        if rig is None:
            raise ValueError('rig: expected the rig of the board, or "sim:FILE"')
        console = file if kind == "console" else None
        port = None if kind in ("sim", "console") else text
        return cls(_native.open_board(rig._native, port, console, list(servos)), rig)

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stops the rig, waits until torque is off, and ends the session.

        >>> board = Board.open("sim", Rig.arm(2))
        >>> board.close()
        """
        _open.discard(self)
        self._native.close()

    def arm(self) -> None:
        """Switches torque on at the measured pose, and waits until the rig holds.

        Raises
        ------
        BoardError
            If the controller refuses; the message contains the reason.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.arm()
        ...     board.state().state
        'holding'
        """
        self._native.arm()

    def goto(self, q: npt.ArrayLike, duration: float = 0.0) -> None:
        """Moves the armed rig smoothly to a pose, and waits until the rig is there; then the rig holds.

        Parameters
        ----------
        q : (nq,), within the ranges; joints that follow others go where their leaders put them
        duration : shortest time of the motion, s; it takes longer if a joint would exceed 0.7 of ``soft_rad_s``, a
            setting of the board

        Raises
        ------
        ValueError
            For a wrong length or NaN.
        BoardError
            If the pose is out of range, the rig does not hold, a fault ends the motion, or the pose was not reached.

        >>> import numpy as np
        >>> arm = Rig.arm(2)
        >>> with Board.open("sim", arm) as board:
        ...     board.arm()
        ...     goal = board.state().q + [0.05, 0.0]
        ...     board.goto(goal)
        ...     bool(np.abs(board.state().q - goal).max() < 0.05)
        True
        """
        self._native.goto(row("q", q), float(duration))

    def live(self, q: npt.ArrayLike) -> Array:
        """Sends a pose that the rig shall follow. Call it at least ten times a second; otherwise the rig holds.

        The controller limits speeds: a far pose is reached later.

        Returns
        -------
        (nq,): the pose that was sent, in which joints that follow others are where their leaders put them.

        Raises
        ------
        ValueError
            For a wrong length or NaN.
        BoardError
            If the pose is out of range, or the rig is not armed.

        >>> import time
        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.arm()
        ...     q = board.state().q
        ...     for _ in range(20):
        ...         sent = board.live(q)
        ...         time.sleep(0.02)
        ...     board.state().state
        'playing'
        """
        return np.array(self._native.live(row("q", q)))

    def upload(self, show: Show) -> None:
        """Uploads a show if the board does not have it. A board stores shows only while torque is off.

        Raises
        ------
        BoardError
            If the show is of another rig, the rig is armed, or the board has no room.

        >>> arm = Rig.arm(2)
        >>> with Board.open("sim", arm) as board:
        ...     board.upload(bake([board.state().q] * 2, arm, rate_hz=2))
        """
        self._native.upload(show._native)

    def play(self, show: Show, *, rounds: int = 1) -> None:
        """Plays a show that the board has (``upload``) on the armed rig, and waits for its end; then the rig holds.

        Parameters
        ----------
        show : a show of this rig
        rounds : number of rounds of a loop, after the way to its first pose

        Raises
        ------
        ValueError
            For more than one round of a show that is no loop.
        BoardError
            If the show is of another rig, the board does not have it, or a fault ends it.

        >>> arm = Rig.arm(2)
        >>> with Board.open("sim", arm) as board:
        ...     show = bake([board.state().q] * 2, arm, rate_hz=2)
        ...     board.upload(show)
        ...     board.arm()
        ...     board.play(show)
        ...     board.state().state
        'holding'
        """
        self._native.play(show._native, rounds)

    def hold(self) -> None:
        """Ends a motion, also one of another thread: the rig stands where it is.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.arm()
        ...     board.hold()
        """
        self._native.hold()

    def stop(self) -> None:
        """Stops the rig: it goes to its rest pose and is lowered. Waits until torque is off.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.arm()
        ...     board.stop()
        ...     board.state().state
        'limp'
        """
        self._native.stop()

    def estop(self) -> None:
        """Switches torque off at once, also during a motion of another thread: the rig falls.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.estop()
        """
        self._native.estop()

    def clear(self) -> None:
        """Clears latched faults whose cause is removed, and a stop by another terminal.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.estop()
        ...     board.clear()
        """
        self._native.clear()

    def take(self) -> None:
        """Takes the wheel of a console. Does nothing for a board without a console, which this program has alone.

        Raises
        ------
        BoardError
            If a page or another program drives. It is asked to release the wheel, which this program then gets.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.take()
        """
        self._native.wheel(True)

    def release(self) -> None:
        """Releases the wheel of a console, so that a page can drive. The rig holds. Without a console, does nothing.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.release()
        """
        self._native.wheel(False)

    def state(self) -> BoardState:
        """Returns the state of the rig.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.state().q.shape
        (2,)
        """
        name, q, effort, supply_v, show_s, error, servos = self._native.state()
        temperature = [np.nan if celsius is None else float(celsius) for celsius, _ in servos]
        heat = [percent / 100.0 for _, percent in servos]
        return BoardState(
            name, np.array(q), np.array(effort), supply_v, show_s, error, np.array(temperature), np.array(heat)
        )

    def faults(self) -> list[BoardFault]:
        """Returns the board's log of faults, the newest last, with their remedies.

        >>> with Board.open("sim", Rig.arm(2)) as board:
        ...     board.faults()
        []
        """
        return [BoardFault(*fault) for fault in self._native.faults()]


class Console:
    """A running ``sinew console``, which has a board and accepts some commands from other programs.

    ``open`` finds the console. The commands move an armed rig while nothing else moves it, without the wheel.
    ``Board.open("console", rig)`` drives the rig as a page does.
    """

    def __init__(self, native: _native.NativeConsole) -> None:
        self._native = native

    @classmethod
    def open(cls, name: str | None = None) -> Console:
        """Finds a running console of this user by its name; without a name, the only running console.

        Raises
        ------
        BoardError
            If no such console runs, or, without a name, several run.

        >>> Console.open("no-port")  # doctest: +ELLIPSIS
        Traceback (most recent call last):
            ...
        sinew_motion.BoardError: there is no console `no-port`: ...
        """
        return cls(_native.open_console(name))

    @property
    def name(self) -> str:
        """The name of the console, which is made from the board's port."""
        return self._native.name

    def home(self) -> str:
        """Moves the armed rig to its home pose, and waits until it is there.

        >>> board = Console.open("dev-ttyACM0")  # doctest: +SKIP
        >>> board.home()  # doctest: +SKIP
        'the rig is there'
        """
        return self._native.home()

    def jog(self, joint: str, *, angle: float | None = None, distance: float | None = None) -> str:
        """Moves a joint of the armed rig by an angle in rad, or a slide by a distance in m, and waits for the end.

        >>> board = Console.open("dev-ttyACM0")  # doctest: +SKIP
        >>> board.jog("turn1", angle=0.1)  # doctest: +SKIP
        'the rig is there'
        """
        if (angle is None) == (distance is None):
            raise ValueError("expected an angle or a distance")
        # The console expects degrees and millimetres.
        by = np.rad2deg(angle) if angle is not None else 1000.0 * (distance or 0.0)
        return self._native.jog(joint, float(by))

    def stop(self) -> str:
        """Stops the rig: it goes to its rest pose, then torque is off.

        >>> board = Console.open("dev-ttyACM0")  # doctest: +SKIP
        >>> board.stop()  # doctest: +SKIP
        'the rig goes to its rest pose, then torque is off'
        """
        return self._native.stop()

    def estop(self) -> str:
        """Switches torque off at once.

        >>> board = Console.open("dev-ttyACM0")  # doctest: +SKIP
        >>> board.estop()  # doctest: +SKIP
        'torque is off'
        """
        return self._native.estop()


@atexit.register
def _close_all() -> None:
    """Stops the rigs of boards that are still open when the program ends."""
    for board in list(_open):
        board.close()
