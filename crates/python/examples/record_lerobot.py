"""Records ten episodes of a simulated arm as a LeRobot dataset, reads them back, and prints how the arm followed.

``record_lerobot.py FOLDER [RIG [SERVOS]]``: a new folder for the dataset; a file of a rig, such as the URDF of an
SO-100, and the kind of its servos, such as ``sts3215``. Without a rig, it records the desk arm.
"""

import pathlib
import sys
import time
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import sinew_motion as sm

Array = npt.NDArray[np.float64]

EPISODES = 10
FPS = 30
SECONDS = 3.0
# An episode goes from the home pose by up to 25 degrees in each joint, and back.
MOST = np.deg2rad(25.0)
# Largest median of the episodes' delays of the measured positions. It contains the board's limit of acceleration, the
# servo, and the interval of the telemetry.
MOST_LAG_S = 0.5
# A measured position is between the actions of this last time, since a busy machine simulates with pauses, ..
LAST_S = 1.0
# .. up to the error of the servos, which stand off by friction and load, and one interval of the telemetry at 26 deg/s.
MOST_ERROR_DEG = 3.0


class Episode(NamedTuple):
    """Columns of an episode: time in s, (T,); actions and measured positions in degrees, (T, joints)."""

    time: Array
    action: Array
    state: Array


def reach(rig: sm.Rig, number: int) -> sm.Show:
    """Returns the motion of an episode: from the home pose to another pose, and back."""
    goal = np.random.default_rng(number).uniform(
        np.maximum(rig.home - MOST, rig.lower), np.minimum(rig.home + MOST, rig.upper)
    )
    t = np.linspace(0.0, 1.0, 61)[:, None]
    rows = rig.home + (goal - rig.home) * (1.0 - np.cos(2.0 * np.pi * t)) / 2.0
    return sm.bake(rows, rig, rate_hz=60 / SECONDS)


def record(folder: pathlib.Path, rig: str, servos: list[str]) -> None:
    """Records the episodes into a new folder."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from lerobot.utils.feature_utils import build_dataset_frame, hw_to_dataset_features

    from sinew_motion.lerobot import SinewLeader, SinewLeaderConfig, SinewRobot, SinewRobotConfig

    robot = SinewRobot(SinewRobotConfig(target=f"sim:{rig}", servos=servos))
    features = {
        **hw_to_dataset_features(robot.action_features, "action"),
        **hw_to_dataset_features(robot.observation_features, "observation"),
    }
    dataset = LeRobotDataset.create(
        "sinew/reach", fps=FPS, features=features, root=folder / "dataset", robot_type=robot.name, use_videos=False
    )
    with robot:
        assert robot.board is not None
        robot.board.goto(robot.joints.rig.home)
        for number in range(EPISODES):
            show = folder / f"reach-{number}.show"
            reach(robot.joints.rig, number).save(show)
            with SinewLeader(SinewLeaderConfig(target=f"sim:{rig}", show=str(show))) as leader:
                begun = time.perf_counter()
                for frame in range(round(FPS * SECONDS)):
                    time.sleep(max(0.0, begun + frame / FPS - time.perf_counter()))
                    observation = robot.get_observation()
                    sent = robot.send_action(leader.get_action())
                    dataset.add_frame(
                        {
                            **build_dataset_frame(features, observation, "observation"),
                            **build_dataset_frame(features, sent, "action"),
                            "task": "reach a pose and return",
                        }
                    )
            dataset.save_episode()
    dataset.finalize()


def read(folder: pathlib.Path) -> list[Episode]:
    """Reads the episodes back."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    dataset = LeRobotDataset("sinew/reach", root=folder / "dataset")
    frames = dataset.hf_dataset.with_format("numpy")
    number, time_s, action, state = (
        np.asarray(frames[key][:], dtype=np.float64)
        for key in ("episode_index", "timestamp", "action", "observation.state")
    )
    of = [number == episode for episode in range(dataset.num_episodes)]
    return [Episode(time_s[own], action[own], state[own]) for own in of]


def lag_s(episode: Episode) -> float:
    """Returns by which delay the measured positions follow the actions best."""

    def error(lag: float) -> float:
        delayed = [np.interp(episode.time - lag, episode.time, joint) for joint in episode.action.T]
        return float(np.square(np.stack(delayed, axis=1) - episode.state).sum())

    return float(min(np.arange(0.0, 2.0 * LAST_S, 0.01), key=error))


def error_deg(episode: Episode) -> float:
    """Returns the largest distance of a measured position from the actions of the last time."""
    count = round(LAST_S * FPS)
    padded = np.concatenate([np.repeat(episode.action[:1], count, axis=0), episode.action])
    last = np.lib.stride_tricks.sliding_window_view(padded, count + 1, axis=0)
    beyond = np.maximum(episode.state - last.max(axis=2), last.min(axis=2) - episode.state)
    return float(beyond.max())


def check(episodes: list[Episode]) -> None:
    """Fails if the dataset is not what was recorded, or the arm did not follow."""
    if len(episodes) != EPISODES:
        raise ValueError(f"expected {EPISODES} episodes, found {len(episodes)}")
    expected_s = np.arange(round(FPS * SECONDS)) / FPS
    for number, episode in enumerate(episodes):
        if episode.time.shape != expected_s.shape or np.abs(episode.time - expected_s).max() > 1e-4:
            raise ValueError(f"episode {number}: expected {len(expected_s)} frames, {FPS} a second")
        if np.ptp(episode.action, axis=0).max() < 2.0 * MOST_ERROR_DEG:
            raise ValueError(f"episode {number}: the motion is too small to tell whether the arm followed")
        if error_deg(episode) > MOST_ERROR_DEG:
            raise ValueError(f"episode {number}: the arm was {error_deg(episode):.1f} degrees off")
    late_s = float(np.median([lag_s(episode) for episode in episodes]))
    if late_s > MOST_LAG_S:
        raise ValueError(f"the arm was {late_s:.2f} s late")


def main(folder: str, rig: str | None = None, *servos: str) -> None:
    new = pathlib.Path(folder)
    new.mkdir(parents=True)
    if rig is None:
        rig = str(new / "arm.toml")
        sm.Rig.arm(6).save(rig)
    record(new, rig, list(servos))
    episodes = read(new)
    check(episodes)
    for number, episode in enumerate(episodes):
        late_s, off_deg = lag_s(episode), error_deg(episode)
        print(f"episode {number}: {len(episode.time)} frames, {late_s:.2f} s late, {off_deg:.1f} degrees off")


if __name__ == "__main__":
    main(*sys.argv[1:])
