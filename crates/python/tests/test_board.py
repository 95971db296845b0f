"""Boards: a simulated rig is armed, moved and stopped, also after exceptions and Ctrl-C."""

from __future__ import annotations

import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import sinew_motion as sm

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the simulated board needs Unix")


def test_a_rig_is_armed_moved_and_stopped(tmp_path: pathlib.Path) -> None:
    sm.Rig.arm(3).save(tmp_path / "arm.toml")
    with sm.Board.open(f"sim:{tmp_path / 'arm.toml'}") as board:
        assert board.state().state in ("off", "limp")
        with pytest.raises(sm.BoardError, match="arm"):
            board.goto(board.rig.home)
        show = sm.bake([board.rig.home] * 6, board.rig, rate_hz=10)
        board.load(show)
        board.arm()
        at = board.state()
        assert at.state == "holding" and at.q.shape == at.effort.shape == (3,)
        goal = np.clip(at.q + 0.1, board.rig.lower, board.rig.upper)
        board.goto(goal)
        reached = board.state()
        assert np.abs(reached.q - goal).max() < 0.05 and reached.state == "holding"
        for _ in range(40):
            board.live(goal)
            time.sleep(0.01)
        assert board.state().state == "playing"
        board.hold()
        board.play(show)
        assert board.state().state == "holding"
        with pytest.raises(sm.BoardError, match="before `arm`"):
            board.play(sm.bake([goal] * 6, board.rig, rate_hz=10))
        board.stop()
        assert board.state().state == "limp"
        assert all(fault.is_warning for fault in board.faults())
    with pytest.raises(sm.BoardError, match="closed"):
        board.state()


def test_wrong_input_moves_nothing() -> None:
    rig = sm.Rig.arm(2)
    with sm.Board.open("sim", rig) as board:
        board.arm()
        before = board.state().q
        for bad, error in (
            ([0.0], ValueError),
            ([np.nan, 0.0], ValueError),
            ([50.0, 0.0], sm.BoardError),
        ):
            with pytest.raises(error):
                board.goto(bad)
            with pytest.raises(error):
                board.live(bad)
        with pytest.raises(ValueError, match="duration"):
            board.goto(before, duration=-1.0)
        other = sm.bake([[0.0] * 3] * 3, sm.Rig.arm(3), rate_hz=10)
        with pytest.raises(sm.BoardError, match="rig"):
            board.play(other)
        assert board.state().state == "holding"


def test_an_exception_stops_the_rig() -> None:
    seen = []
    board = sm.Board.open("sim", sm.Rig.arm(2))
    close = board.close
    board.close = lambda: (board.stop(), seen.append(board.state().state), close())  # type: ignore[method-assign]
    with pytest.raises(RuntimeError, match="a fault of the program"), board:
        board.arm()
        raise RuntimeError("a fault of the program")
    assert seen == ["limp"]


def test_ctrl_c_in_a_motion_stops_the_rig() -> None:
    code = """
import numpy as np, sinew_motion as sm
arm = sm.Rig.arm(2)
board = sm.Board.open("sim", arm)
try:
    with board:
        close = board.close
        def stop():
            board.stop()
            print(board.state().state, flush=True)
            close()
        board.close = stop
        board.arm()
        q = board.state().q
        print("ready", flush=True)
        board.goto(np.clip(q + 0.3, arm.lower, arm.upper), duration=60.0)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout and child.stdout.readline() == "ready\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    output, _ = child.communicate(timeout=90)
    assert output == "limp\ninterrupted\n"


def test_a_port_without_a_board(tmp_path: pathlib.Path) -> None:
    with pytest.raises(sm.BoardError):
        sm.Board.open(tmp_path / "no-port", sm.Rig.arm(2))
    with pytest.raises(ValueError, match='"sim:FILE"'):
        sm.Board.open("sim")
    with pytest.raises(ValueError, match="no.toml"):
        sm.Board.open("sim:no.toml")
