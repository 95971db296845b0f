"""The classes for LeRobot, with its real package: a simulated rig is connected, moved, recorded and led.

``cargo xtask python`` runs this file in an environment with LeRobot. Elsewhere it is skipped.
"""

from __future__ import annotations

import doctest
import importlib.util
import inspect
import os
import pathlib
import subprocess
import sys
import time
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest

import sinew_motion as sm

pytest.importorskip("lerobot", reason="needs LeRobot")

import draccus  # noqa: E402
from lerobot.configs import parser  # noqa: E402
from lerobot.robots import RobotConfig, make_robot_from_config  # noqa: E402
from lerobot.teleoperators import TeleoperatorConfig, make_teleoperator_from_config  # noqa: E402
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError  # noqa: E402

import sinew_motion.lerobot as of_lerobot  # noqa: E402
from sinew_motion.lerobot import SinewLeader, SinewLeaderConfig, SinewRobot, SinewRobotConfig  # noqa: E402

EXAMPLE = pathlib.Path(__file__).resolve().parents[1] / "examples/record_lerobot.py"


@dataclass
class Command:
    """The options of LeRobot's commands that name devices."""

    robot: RobotConfig
    teleop: TeleoperatorConfig


@pytest.fixture
def file(tmp_path: pathlib.Path) -> str:
    path = tmp_path / "arm.toml"
    sm.Rig.arm(2).save(path)
    return str(path)


@pytest.fixture
def robot(file: str, tmp_path: pathlib.Path) -> SinewRobot:
    return SinewRobot(SinewRobotConfig(target=f"sim:{file}", calibration_dir=tmp_path))


def test_commands_of_lerobot_find_the_classes(file: str, tmp_path: pathlib.Path) -> None:
    """LeRobot reads types and options from its command line, and finds the class of a configuration by its name."""
    parser.load_plugin("sinew_motion.lerobot")
    words = ["--robot.type=sinew", f"--robot.target=sim:{file}", "--robot.servos=[sts3215]"]
    words += ["--teleop.type=sinew_leader", f"--teleop.target=sim:{file}"]
    words += [f"--{of}.calibration_dir={tmp_path}" for of in ("robot", "teleop")]
    command = draccus.parse(Command, None, words)
    assert isinstance(command.robot, SinewRobotConfig) and command.robot.servos == ["sts3215"]
    assert isinstance(make_robot_from_config(command.robot), SinewRobot)
    assert isinstance(make_teleoperator_from_config(command.teleop), SinewLeader)


def test_a_robot_goes_where_it_is_sent(robot: SinewRobot) -> None:
    keys = ["turn1.pos", "bend2.pos"]
    assert list(robot.observation_features) == list(robot.action_features) == keys
    assert robot.is_calibrated and not robot.is_connected
    with pytest.raises(DeviceNotConnectedError):
        robot.get_observation()
    robot.connect()
    with pytest.raises(DeviceAlreadyConnectedError):
        robot.connect()
    at = robot.get_observation()
    upper = np.rad2deg(robot.joints.rig.upper)
    goal = {"turn1.pos": min(at["turn1.pos"] + 10.0, upper[0]), "bend2.pos": 1e4}
    end = time.monotonic() + 60.0
    while abs(robot.get_observation()["turn1.pos"] - goal["turn1.pos"]) > 2.0 and time.monotonic() < end:
        sent = robot.send_action(goal)
        time.sleep(0.02)
    assert abs(sent["turn1.pos"] - goal["turn1.pos"]) < 1e-4 and abs(sent["bend2.pos"] - upper[1]) < 1e-4
    assert abs(robot.get_observation()["turn1.pos"] - goal["turn1.pos"]) <= 2.0
    robot.disconnect()
    robot.disconnect()
    assert not robot.is_connected
    with pytest.raises(DeviceNotConnectedError):
        robot.send_action(goal)


def test_a_rig_is_limp_after_its_robot_is_disconnected(console: sm.Rig, tmp_path: pathlib.Path) -> None:
    file = str(tmp_path / "arm.toml")
    robot = SinewRobot(SinewRobotConfig(target="console", rig=file, calibration_dir=tmp_path))
    robot.connect()
    # The robot has the wheel, so this program only watches.
    with sm.Board.open("console", console) as watcher:
        assert watcher.state().state == "holding"
        robot.disconnect()
        assert watcher.state().state == "limp"


def test_a_robot_follows_again_after_a_pause_but_not_after_a_stop(robot: SinewRobot) -> None:
    with robot:
        assert robot.board is not None
        at = robot.get_observation()
        robot.send_action(at)
        for _ in range(2):
            end = time.monotonic() + 30.0
            while robot.board.state().state != "holding" and time.monotonic() < end:
                time.sleep(0.02)
            for _ in range(20):
                robot.send_action(at)
                time.sleep(0.02)
            assert robot.board.state().state == "playing"
        robot.board.estop()
        with pytest.raises(sm.BoardError):
            robot.send_action(at)


def test_wrong_actions_and_configurations_are_refused(robot: SinewRobot, file: str, tmp_path: pathlib.Path) -> None:
    with robot:
        at = robot.get_observation()
        for wrong in ({**at, "turn1.pos": float("nan")}, {"turn1.pos": 0.0}, {**at, "turn9.pos": 0.0}):
            with pytest.raises(ValueError, match="turn1.pos|bend2.pos|turn9.pos"):
                robot.send_action(wrong)
    for target, rig in (("sim", None), (f"sim:{file}", file)):
        with pytest.raises(ValueError, match='"sim:FILE"'):
            SinewRobot(SinewRobotConfig(target=target, rig=rig, calibration_dir=tmp_path))
    show, heavier = tmp_path / "other.show", tmp_path / "heavier.toml"
    heavier.write_text(pathlib.Path(file).read_text().replace("mass_kg = ", "mass_kg = 1"))
    # Other joints, and the same joints with other masses.
    for other in (sm.Rig.arm(3), sm.Rig.load(heavier)):
        sm.bake([[0.0] * other.nq] * 3, other, rate_hz=10).save(show)
        with pytest.raises(ValueError, match="another rig"):
            SinewLeader(SinewLeaderConfig(target=f"sim:{file}", show=str(show), calibration_dir=tmp_path))


def test_a_show_leads_in_time_and_again(file: str, tmp_path: pathlib.Path) -> None:
    rig = sm.Rig.arm(2)
    show = sm.bake(np.linspace([0.0, 0.5], [0.5, 0.6], 101), rig, rate_hz=50)
    show.save(tmp_path / "rise.show")
    leader = SinewLeader(
        SinewLeaderConfig(target=f"sim:{file}", show=str(tmp_path / "rise.show"), calibration_dir=tmp_path)
    )
    assert leader.feedback_features == {} and list(leader.action_features) == ["turn1.pos", "bend2.pos"]
    with pytest.raises(DeviceNotConnectedError):
        leader.get_action()
    with leader:
        for _ in range(2):
            before = time.monotonic()
            first = leader.get_action()["turn1.pos"]
            middle = time.monotonic()
            time.sleep(0.5)
            between = time.monotonic()
            then = leader.get_action()["turn1.pos"]
            after = time.monotonic()
            assert abs(first - np.rad2deg(show.sample(0.0)[0][0])) < 1e-6
            least, most = (np.rad2deg(show.sample(s)[0][0]) for s in (between - middle, after - before))
            assert least - 1e-6 <= then <= most + 1e-6 and then > first + 5.0
            leader.restart()
        leader.send_feedback({})
        with pytest.raises(ValueError, match="turn1.force"):
            leader.send_feedback({"turn1.force": 1.0})


def test_another_rig_leads(file: str, robot: SinewRobot, tmp_path: pathlib.Path) -> None:
    leader = SinewLeader(SinewLeaderConfig(target=f"sim:{file}", calibration_dir=tmp_path))
    with leader, robot:
        assert leader.board is not None and leader.board.state().state == "limp"
        leader.board.arm()
        goal = leader.board.state().q + [0.2, 0.0]
        leader.board.goto(goal)
        end = time.monotonic() + 60.0
        measured: dict[str, float] = {}
        while time.monotonic() < end:
            action = leader.get_action()
            robot.send_action(action)
            measured = robot.get_observation()
            if abs(measured["turn1.pos"] - np.rad2deg(goal[0])) < 3.0:
                break
            time.sleep(0.02)
        assert abs(action["turn1.pos"] - np.rad2deg(goal[0])) < 3.0
        assert abs(measured["turn1.pos"] - action["turn1.pos"]) < 4.0


def test_the_examples_of_the_classes_are_true() -> None:
    for name in of_lerobot.__all__:
        part = getattr(of_lerobot, name)
        text = inspect.getdoc(part)
        assert text, name
        test = doctest.DocTestParser().get_doctest(text, dict(vars(of_lerobot)), name, None, None)
        assert test.examples or name.endswith("Config"), name
        out: list[str] = []
        assert not doctest.DocTestRunner().run(test, out=out.append).failed, "".join(out)
        for method, of in vars(part).items():
            assert method.startswith("_") or not inspect.isfunction(of) or of.__doc__, f"{name}.{method}"


def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("record_lerobot", EXAMPLE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_ten_episodes_are_recorded_and_read_back(tmp_path: pathlib.Path) -> None:
    """With SINEW_DATA, the arm is the SO-100; otherwise the desk arm."""
    folder = tmp_path / "recorded"
    data = os.environ.get("SINEW_DATA")
    rig = [str(pathlib.Path(data) / "foreign/urdf/so100.urdf"), "sts3215"] if data else []
    done = subprocess.run(
        [sys.executable, str(EXAMPLE), str(folder), *rig], capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    assert len(done.stdout.splitlines()) == 10
    # The check of the example fails if a part of the dataset is wrong.
    script = example()
    episodes = script.read(folder)
    script.check(episodes)
    first, rest = episodes[0], episodes[1:]
    still = first._replace(state=np.repeat(first.state[:1], len(first.state), axis=0))
    slow = first._replace(time=first.time * 1.01)
    short = script.Episode(first.time[:-1], first.action[:-1], first.state[:-1])
    other = first._replace(state=np.roll(first.state, 45, axis=0))
    late = [one._replace(state=np.roll(one.state, 15, axis=0)) for one in episodes]
    for wrong in (rest, [*rest, still], [*rest, slow], [*rest, short], [*rest, other], late):
        with pytest.raises(ValueError):
            script.check(wrong)
