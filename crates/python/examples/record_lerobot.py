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
# Longest delay of a measured position behind its action: the board's limit of acceleration, the servo, and two
# telemetry frames. The measured delay is about 0.2 s.
MOST_LAG_S = 0.5
# Largest distance from the delayed action. Of it, 1.7 degrees are a frame's motion at the highest speed of 52 deg/s,
# since actions and measurements have no common clock; the rest is the servos' error under their load.
MOST_ERROR_DEG = 6.0


class Episode(NamedTuple):
    """Columns of an episode: time in s, (T,); actions and measured positions in degrees, (T, joints)."""

    time: Array
    action: Array
    state: Array


def reach(rig: sm.Rig, number: int) -> sm.Show:
    """Returns the motion of an episode: from the home pose to another pose, and back."""
    towards = np.random.default_rng(number).uniform(-MOST, MOST, rig.nq)
    t = np.linspace(0.0, 1.0, 61)[:, None]
    rows = rig.home + towards * (1.0 - np.cos(2.0 * np.pi * t)) / 2.0
    return sm.bake(np.clip(rows, rig.lower, rig.upper), rig, rate_hz=60 / SECONDS)


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


def followed(episode: Episode) -> tuple[float, float]:
    """Returns by which delay, s, the measured positions follow the actions best, and their largest distance then."""

    def distance(lag_s: float) -> float:
        delayed = [np.interp(episode.time - lag_s, episode.time, joint) for joint in episode.action.T]
        return float(np.abs(np.stack(delayed, axis=1) - episode.state).max())

    lags_s = np.arange(0.0, MOST_LAG_S + 0.3, 0.01)
    return min(((float(lag_s), distance(lag_s)) for lag_s in lags_s), key=lambda of: of[1])


def check(episodes: list[Episode]) -> list[tuple[float, float]]:
    """Returns the delay and the distance of each episode. Fails if the dataset is not what was recorded."""
    if len(episodes) != EPISODES:
        raise ValueError(f"expected {EPISODES} episodes, found {len(episodes)}")
    results = []
    for number, episode in enumerate(episodes):
        expected_s = np.arange(round(FPS * SECONDS)) / FPS
        if episode.time.shape != expected_s.shape or np.abs(episode.time - expected_s).max() > 1e-4:
            raise ValueError(f"episode {number}: expected {len(expected_s)} frames, {FPS} a second")
        if np.ptp(episode.action, axis=0).max() < 2.0 * MOST_ERROR_DEG:
            raise ValueError(f"episode {number}: the motion is too small to tell whether the arm followed")
        lag_s, error_deg = followed(episode)
        if lag_s > MOST_LAG_S or error_deg > MOST_ERROR_DEG:
            raise ValueError(f"episode {number}: the arm was {lag_s:.2f} s late, and {error_deg:.1f} degrees off")
        results.append((lag_s, error_deg))
    return results


def main(folder: str, rig: str | None = None, *servos: str) -> None:
    new = pathlib.Path(folder)
    new.mkdir(parents=True)
    if rig is None:
        rig = str(new / "arm.toml")
        sm.Rig.arm(6).save(rig)
    record(new, rig, list(servos))
    for number, (lag_s, error_deg) in enumerate(check(read(new))):
        print(f"episode {number}: {lag_s:.2f} s late, at most {error_deg:.1f} degrees off")


if __name__ == "__main__":
    main(*sys.argv[1:])
