"""Boards: a simulated rig is armed, moved and stopped, also after exceptions and Ctrl-C."""

from __future__ import annotations

import pathlib
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType

import numpy as np
import pytest

import sinew_motion as sm

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the simulated board needs Unix")


def test_a_rig_is_armed_moved_and_stopped(tmp_path: pathlib.Path) -> None:
    sm.Rig.arm(3).save(tmp_path / "arm.toml")
    with sm.Board.open(f"sim:{tmp_path / 'arm.toml'}") as board:
        at = board.state()
        assert at.state in ("off", "limp")
        goal = np.clip(at.q + 0.1, board.rig.lower, board.rig.upper)
        show = sm.bake(np.tile(goal, (11, 1)), board.rig, rate_hz=10)
        board.upload(show)
        with pytest.raises(sm.BoardError, match="arm"):
            board.goto(board.rig.home)
        board.arm()
        at = board.state()
        assert at.state == "holding" and at.q.shape == at.effort.shape == (3,)
        board.goto(goal)
        reached = board.state()
        assert np.abs(reached.q - goal).max() < 0.05 and reached.state == "holding"
        for _ in range(40):
            board.live(goal)
            time.sleep(0.01)
        assert board.state().state == "playing"
        board.hold()
        board.play(show)
        with pytest.raises(sm.BoardError, match="`upload`"):
            board.play(sm.bake(np.tile(goal, (12, 1)), board.rig, rate_hz=10))
        assert board.state().state == "holding"
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


def in_thread(order: Callable[[], None]) -> tuple[threading.Thread, list[str]]:
    """Begins an order in a thread. The list gets the words of its error."""
    errors: list[str] = []

    def run() -> None:
        try:
            order()
        except sm.BoardError as error:
            errors.append(str(error))

    thread = threading.Thread(target=run)
    thread.start()
    return thread, errors


def test_an_interrupted_upload_plays_nothing() -> None:
    """Ctrl-C ends an upload for good, so the board does not have the show later."""

    def interrupt(signal_number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    rig = sm.Rig.arm(6)
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        with sm.Board.open("sim", rig) as board:
            times = np.arange(0.0, 60.0, 0.02)[:, None]
            waves = 0.2 * np.sin(times * np.arange(3.0, 9.0))
            show = sm.bake(np.clip(board.state().q + waves, rig.lower, rig.upper), rig, rate_hz=50)
            with pytest.raises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, 0.001)
                board.upload(show)
            # The board does not have the show: the upload has ended, and plays nothing.
            board.arm()
            with pytest.raises(sm.BoardError, match="`upload`"):
                board.play(show)
            assert board.state().state == "holding"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_urgent_orders_end_a_motion_of_another_thread() -> None:
    rig = sm.Rig.arm(2)
    for name, states in (("hold", ["holding"]), ("stop", ["limp"]), ("estop", ["limp", "faulted", "off"])):
        with sm.Board.open("sim", rig) as board:
            board.arm()
            q = board.state().q
            goal = np.clip(q + 0.3, rig.lower, rig.upper)
            moving, moved = in_thread(lambda: board.goto(goal, duration=60.0))
            time.sleep(0.5)
            waiting, waited = in_thread(lambda: board.goto(q, duration=60.0))
            time.sleep(0.5)
            begun = time.monotonic()
            getattr(board, name)()
            taken = time.monotonic() - begun
            moving.join(5.0)
            waiting.join(5.0)
            assert moved == [f"ended by `{name}`"] and waited == [f"ended by `{name}`"]
            assert taken < (20.0 if name == "stop" else 1.0)
            assert board.state().state in states


def test_an_emergency_stop_ends_a_stop() -> None:
    rig = sm.Rig.arm(2)
    with sm.Board.open("sim", rig) as board:
        board.arm()
        board.goto(np.clip(board.state().q + 0.3, rig.lower, rig.upper))
        stopping, errors = in_thread(board.stop)
        time.sleep(0.2)
        begun = time.monotonic()
        board.estop()
        assert time.monotonic() - begun < 1.0
        stopping.join(5.0)
        assert errors == ["ended by `estop`"]


def test_closing_ends_a_motion() -> None:
    board = sm.Board.open("sim", sm.Rig.arm(2))
    board.arm()
    q = board.state().q
    moving, errors = in_thread(lambda: board.goto(q, duration=60.0))
    time.sleep(0.5)
    begun = time.monotonic()
    board.close()
    assert time.monotonic() - begun < 20.0
    moving.join(5.0)
    assert errors == ["ended by `close`"]


def test_another_terminal_stops_the_rig() -> None:
    with sm.Board.open("sim", sm.Rig.arm(2)) as board:
        board.arm()
        q = board.state().q
        moving, errors = in_thread(lambda: board.goto(q, duration=60.0))
        time.sleep(0.5)
        terminal = sm.Console.open()
        with pytest.raises(sm.BoardError, match="a program of Python has the board"):
            terminal.home()
        assert "rest pose" in terminal.stop()
        moving.join(5.0)
        assert len(errors) == 1 and "another terminal has stopped the rig" in errors[0]
        with pytest.raises(sm.BoardError, match="`clear`"):
            board.arm()
        board.stop()
        board.clear()
        board.arm()
        assert board.state().state == "holding"
    with pytest.raises(sm.BoardError, match="no console"):
        sm.Console.open()


def test_joints_that_follow_go_with_their_leaders(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "tied.toml"
    sm.Rig.arm(3).save(file)
    text = file.read_text()
    names = sm.Rig.arm(3).joint_names
    tie = f'joint = "{names[2]}"\nother = "{names[1]}"\nother_factor = -0.5\nleast_deg = 20\nmost_deg = 20\n'
    file.write_text(f"{text}\n[[limit]]\n{tie}")
    with sm.Board.open(f"sim:{file}") as board:
        board.arm()
        goal = board.state().q.copy()
        goal[0] += 0.1
        goal[1] += 0.3
        board.goto(goal)
        q = board.state().q
        assert abs(q[1] - 0.5 * q[0] - np.deg2rad(20.0)) < 0.03 and abs(q[0] - goal[0]) < 0.05


def test_rounds_count_from_the_first_pose() -> None:
    rig = sm.Rig.arm(2)
    with sm.Board.open("sim", rig) as board:
        q = board.state().q
        phase = np.linspace(0.0, 2.0 * np.pi, 101)[:, None]
        rows = np.clip(q + 0.4 + 0.05 * np.sin(phase), rig.lower, rig.upper)
        with pytest.raises(ValueError, match="rounds"):
            board.play(sm.bake(rows, rig, rate_hz=50), rounds=2)
        show = sm.bake(rows, rig, rate_hz=50, loop_blend_s=0.2)
        board.upload(show)
        board.arm()
        playing, errors = in_thread(lambda: board.play(show, rounds=1))
        begun = time.monotonic()
        playing.join(60.0)
        assert not errors and not playing.is_alive()
        assert time.monotonic() - begun > show.duration + 0.5


def test_a_program_drives_a_console(console: sm.Rig) -> None:
    with pytest.raises(sm.BoardError, match="the given one is"):
        sm.Board.open("console", sm.Rig.arm(3))
    with sm.Board.open("console", console) as board, sm.Board.open("console", console) as other:
        at = board.state()
        assert at.state == "limp" and at.temperature.shape == (2,) and board.faults() == []
        goal = np.clip(at.q + 0.1, console.lower, console.upper)
        show = sm.bake(np.tile(goal, (11, 1)), console, rate_hz=10)
        board.upload(show)
        board.upload(show)
        with pytest.raises(sm.BoardError, match="somebody else drives"):
            other.arm()
        with pytest.raises(sm.BoardError, match="somebody else drives"):
            other.take()
        board.arm()
        board.goto(goal, duration=0.5)
        reached = board.state()
        assert np.abs(reached.q - goal).max() < 0.05 and reached.state == "holding"
        board.play(show)
        with pytest.raises(sm.BoardError, match="`upload`"):
            board.play(sm.bake(np.tile(goal, (12, 1)), console, rate_hz=10))
        with pytest.raises(sm.BoardError, match="found 50.0"):
            board.live([50.0, 0.0])
        with pytest.raises(ValueError, match=r"q\[0\]"):
            board.live([np.nan, 0.0])
        for _ in range(40):
            sent = board.live(goal)
            time.sleep(0.01)
        assert board.state().state == "playing" and np.abs(sent - goal).max() < 1e-6
        board.hold()
        moving, errors = in_thread(lambda: board.goto(goal - 0.2, duration=60.0))
        time.sleep(0.5)
        board.hold()
        moving.join(5.0)
        assert errors == ["ended by `hold`"] and board.state().state == "holding"
        # Anybody may hold the rig, which ends a motion.
        moving, errors = in_thread(lambda: board.goto(goal - 0.2, duration=60.0))
        time.sleep(0.5)
        # A refused order of somebody else does not end it.
        with pytest.raises(sm.BoardError, match="somebody else drives"):
            other.goto(goal)
        time.sleep(0.2)
        assert other.state().state == "playing"
        other.hold()
        moving.join(5.0)
        assert len(errors) == 1 and "the motion was ended" in errors[0]
        # The program that has asked for the wheel gets it.
        board.release()
        other.goto(goal, duration=0.5)
        other.stop()
        assert other.state().state == "limp"
        other.estop()
        other.clear()


def test_the_rig_of_a_console_holds_if_its_program_is_killed(console: sm.Rig, tmp_path: pathlib.Path) -> None:
    code = """
import sys, sinew_motion as sm
rig = sm.Rig.load(sys.argv[1])
board = sm.Board.open("console", rig)
board.arm()
print("ready", flush=True)
board.goto(board.state().q - 0.2, duration=600.0)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "arm.toml")], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout and child.stdout.readline() == "ready\n"
    with sm.Board.open("console", console) as board:
        end = time.monotonic() + 30.0
        while board.state().state != "playing":
            assert time.monotonic() < end
        child.kill()
        child.wait()
        while board.state().state != "holding":
            assert time.monotonic() < end
