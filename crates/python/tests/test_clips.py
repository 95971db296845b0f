"""Clips, shows, distances and importance."""

from __future__ import annotations

import pathlib
import subprocess

import numpy as np
import pytest

import sinew_motion as sm


def test_a_clip_has_poses(clip: sm.Clip) -> None:
    frames, joints = len(clip), len(clip.joint_names)
    assert clip.local.shape == clip.world.shape == (frames, joints, 7)
    assert clip.rotations.shape == (frames, joints, 4) and clip.offsets.shape == (joints, 3)
    assert np.allclose(np.linalg.norm(clip.rotations, axis=-1), 1)
    assert clip.parents[0] == -1 and clip.times[-1] == pytest.approx((frames - 1) / clip.rate_hz)
    # The world pose of a child follows from its parent's pose and its local pose.
    child = next(joint for joint, parent in enumerate(clip.parents) if parent == 0)
    x, y, z, w = clip.world[5, 0, 3:]
    v = clip.local[5, child, :3]
    t = 2 * np.cross([x, y, z], v)
    assert np.allclose(clip.world[5, 0, :3] + v + w * t + np.cross([x, y, z], t), clip.world[5, child, :3])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"path": "punches_99"}, "no such file, and no built-in clip"),
        ({"path": "punches_01", "seconds": -1.0}, "seconds"),
        ({"path": "punches_01", "cutoff_hz": float("nan")}, "cutoff_hz"),
        ({"path": "punches_01", "up": "w"}, "x, y or z"),
        ({"path": "punches_01", "metres_per_unit": 0.0}, "metres_per_unit"),
    ],
)
def test_clips_that_cannot_be_read(arguments: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        sm.read_clip(**arguments)


def test_a_file_is_read(data: pathlib.Path) -> None:
    path = next((data / "cmu").glob("**/*.bvh"), None) or next(data.glob("**/*.bvh"))
    clip = sm.read_clip(path, seconds=0.5)
    assert len(clip) > 10 and 0.5 < np.ptp(clip.world[0, :, 1]) < 2.5


def test_derivatives_of_a_show_are_those_of_its_positions(arm: sm.Rig, clip: sm.Clip) -> None:
    show = sm.bake(clip, arm)
    assert show.duration == pytest.approx(clip.times[-1])
    t, step = np.linspace(0.2, 0.8, 20), 1e-3
    q, qd, qdd = show.sample(t)
    after, before = show.sample(t + step)[0], show.sample(t - step)[0]
    assert np.abs((after - before) / (2 * step) - qd).max() < 0.05 * max(1.0, np.abs(qd).max())
    assert qdd.shape == (20, 6)
    # The show is nearer to the motion than the permitted error.
    given = sm.retarget(clip, arm).q
    ours = show.sample(clip.times)[0]
    assert np.abs(ours - given).max() <= np.deg2rad(0.26)
    # After the end, the show stays at its last pose.
    assert np.array_equal(show.sample(100.0)[0], show.sample(show.duration)[0])
    for bad in (-1.0, np.nan, 1e12):
        with pytest.raises(ValueError, match="t: expected times"):
            show.sample(bad)


def test_a_show_survives_its_file(arm: sm.Rig, clip: sm.Clip, tmp_path: pathlib.Path) -> None:
    show = sm.bake(clip, arm, cues=[("light", 0.5)])
    show.save(tmp_path / "a.show")
    again = sm.Show.open(tmp_path / "a.show")
    assert again.bytes == show.bytes and again.cues == [("light", pytest.approx(0.5, abs=0.01))]
    assert again.rig_crc == show.rig_crc != 0 and not again.is_loop and again.fitted is None
    damaged = bytearray(show.bytes)
    damaged[len(damaged) // 2] ^= 0x40
    (tmp_path / "b.show").write_bytes(bytes(damaged))
    with pytest.raises(ValueError):
        sm.Show.open(tmp_path / "b.show")


def test_a_fit_leaves_no_excess(arm: sm.Rig) -> None:
    t = np.arange(0, 2, 0.02)
    motion = np.zeros((len(t), 6))
    motion[:, 0] = 0.8 * np.sin(9 * t)
    given, fitted = sm.bake(motion, arm, rate_hz=50), sm.bake(motion, arm, rate_hz=50, fit=True)
    assert set(given.report) == {"joint", "kind", "from_s", "to_s", "worst_s", "value", "limit"}
    assert len(given.report["joint"]) > 0 and len(fitted.report["joint"]) == 0
    assert fitted.fitted


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"tolerance": 0.0}, "tolerance"),
        ({"loop_blend_s": float("nan")}, "loop_blend_s"),
        ({"cues": [("a", -1.0)]}, "cues"),
        ({"motion": [[0.0] * 5] * 3}, "expected 6 numbers"),
        ({"motion": [[0.0] * 6, [np.nan] + [0.0] * 5]}, r"q\[1, 0\]"),
        ({"motion": [0.0] * 6}, "at least two rows"),
        ({"motion": "walk.bvh"}, "read_clip"),
        ({"motion": "no.csv"}, "no.csv"),
        ({"rate_hz": 0.0}, "rate_hz"),
    ],
)
def test_motions_that_cannot_be_baked(arm: sm.Rig, arguments: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        sm.bake(**{"motion": [[0.0] * 6] * 3, "rig": arm, "rate_hz": 10, **arguments})


def test_a_mapping_is_used(arm: sm.Rig, clip: sm.Clip, tmp_path: pathlib.Path) -> None:
    text = sm.map(clip, arm)
    (tmp_path / "map.toml").write_text(text)
    by_text, by_file = sm.retarget(clip, arm, mapping=text), sm.retarget(clip, arm, mapping=tmp_path / "map.toml")
    assert np.array_equal(by_text.q, by_file.q)
    with pytest.raises(ValueError, match="no.toml"):
        sm.retarget(clip, arm, mapping="no.toml")


def test_the_show_is_that_of_the_command(program: str, arm: sm.Rig, tmp_path: pathlib.Path) -> None:
    arm.save(tmp_path / "arm.toml")
    command = [program, "bake", "punches_01", "--rig", "arm.toml", "--seconds", "2", "--output", "a.show"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    clip = sm.read_clip("punches_01", seconds=2, cutoff_hz=6)
    assert sm.bake(clip, arm).bytes == (tmp_path / "a.show").read_bytes()


def test_distances_of_poses(clip: sm.Clip) -> None:
    first, rest = clip.rotations[0], clip.rotations[10:60:10]
    by_metric = {
        metric: sm.pose_distance(clip, first, rest, metric=metric)  # type: ignore[arg-type]
        for metric in ("angles", "rotations", "positions", "line", "geodesic")
    }
    assert all(distance.shape == (5,) and np.all(distance > 0) for distance in by_metric.values())
    # A straight line in space is shortest; a geodesic is shorter than a line of angles.
    assert np.all(by_metric["positions"] <= by_metric["geodesic"] * (1 + 1e-5))
    assert np.all(by_metric["geodesic"] <= by_metric["line"] * (1 + 1e-5))
    path = sm.geodesic(clip, first, rest[0])
    assert path.length == pytest.approx(by_metric["geodesic"][0], rel=1e-4)
    assert path.rotations.shape == (11, *first.shape)
    for end, pose in ((0, first), (-1, rest[0])):
        assert np.allclose(np.abs(np.sum(path.rotations[end][1:] * pose[1:], axis=-1)), 1, atol=1e-6)
    # The test computes positions relative to the root by itself.
    place = []
    for frame in (0, 10):
        world = clip.world[frame]
        x, y, z, w = world[0, 3:] * [-1, -1, -1, 1]
        v = world[:, :3] - world[0, :3]
        t = 2 * np.cross([x, y, z], v)
        place.append(v + w * t + np.cross([x, y, z], t))
    assert by_metric["positions"][0] == pytest.approx(np.linalg.norm(place[1] - place[0]), rel=1e-4)
    with pytest.raises(ValueError, match="metric: expected one of angles"):
        sm.pose_distance(clip, first, rest, metric="blue")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"a\[0, 1\]"):
        sm.pose_distance(clip, np.zeros_like(first) + [[0, 0, 0, 1]] * (np.arange(len(first)) != 1)[:, None], rest)
    with pytest.raises(ValueError, match="root Tail"):
        sm.pose_distance(clip, first, rest, root="Tail")


def test_importance_is_the_length_of_the_bones_below(clip: sm.Clip) -> None:
    lengths = np.linalg.norm(clip.offsets, axis=1)
    weights = np.full(len(lengths), 0.1)
    for joint in reversed(range(1, len(lengths))):
        weights[clip.parents[joint]] += 0.9 * (lengths[joint] + weights[joint])
    ours = sm.importance(clip)
    assert list(ours) == clip.joint_names
    assert np.allclose(list(ours.values()), weights / weights.sum(), rtol=1e-5)
    with pytest.raises(ValueError, match="expected one of lengths"):
        sm.importance(clip, "colour")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="discount"):
        sm.importance(clip, discount=2.0)
