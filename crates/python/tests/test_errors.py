"""State errors against golden numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import golden

import sinew_motion as sm

CASES = golden("oracles/errors.json")["cases"]


def poses(state: dict[str, Any]) -> np.ndarray:
    return np.hstack([state["pos"], state["quat"]])


def velocities(state: dict[str, Any]) -> np.ndarray:
    return np.hstack([state["lin_vel"], state["ang_vel"]])


def measured(case: dict[str, Any], method: str, beta: float = 1.0) -> sm.StateErrors:
    return sm.errors(
        poses(case["desired"]),
        poses(case["measured"]),
        method,  # type: ignore[arg-type]
        parents=case["parent"],
        desired_velocity=velocities(case["desired"]),
        measured_velocity=velocities(case["measured"]),
        beta=beta,
    )


def compare(ours: sm.StateErrors, expected: list[dict[str, Any]], bodies: list[int]) -> None:
    for part, key in zip(ours, ("e_rot", "e_lin", "ed_rot", "ed_lin")):
        golden = np.array([body[key] for body in expected])[bodies]
        # In float32, both signs of a half turn are possible.
        if key == "e_rot":
            golden = np.where(np.linalg.norm(golden, axis=1, keepdims=True) > 3.14, np.abs(golden), golden)
            part = np.where(np.linalg.norm(part, axis=1, keepdims=True) > 3.14, np.abs(part), part)
        assert np.abs(part[bodies] - golden).max(initial=0.0) < 3e-5 * max(1.0, np.abs(golden).max(initial=0.0)), key


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
@pytest.mark.parametrize("method", ["local", "world", "egocentric"])
def test_errors_are_those_of_the_golden_file(case: dict[str, Any], method: str) -> None:
    compare(measured(case, method), case["expected"][method], list(range(case["n"])))


@pytest.mark.parametrize("case", [case for case in CASES if "edge" not in case["name"]], ids=lambda case: case["name"])
def test_linear_compensation_is_that_of_the_golden_file(case: dict[str, Any]) -> None:
    for expected in case["expected"]["linear_compensation"]:
        rows = expected["error"]
        # Near a half turn the shortest rotation is undefined.
        good = [body for body, row in enumerate(rows) if row["status"] in ("ok", "leaf", "parallel")]
        compare(measured(case, "linear_compensation", expected["beta"]), rows, good)


def test_time_is_the_first_axis() -> None:
    case = next(case for case in CASES if case["n"] == 18)
    desired, found = poses(case["desired"]), poses(case["measured"])
    one = sm.errors(desired, found, "egocentric", parents=case["parent"])
    many = sm.errors([desired] * 3, [found] * 3, "egocentric", parents=case["parent"])
    assert many.angular.shape == (3, 18, 3)
    for part, rows in zip(one, many):
        assert all(np.array_equal(part, row) for row in rows)


def turned(poses: np.ndarray, angle: float, move: np.ndarray) -> np.ndarray:
    """Turns poses about the vertical axis, and moves them."""
    sine, cosine = np.sin(angle), np.cos(angle)
    out = poses.copy()
    out[..., 0] = cosine * poses[..., 0] + sine * poses[..., 2] + move[0]
    out[..., 1] += move[1]
    out[..., 2] = -sine * poses[..., 0] + cosine * poses[..., 2] + move[2]
    x, y, z, w = np.moveaxis(poses[..., 3:], -1, 0)
    s, c = np.sin(angle / 2), np.cos(angle / 2)
    out[..., 3:] = np.stack([c * x + s * z, c * y + s * w, c * z - s * x, c * w - s * y], axis=-1)
    return out


def test_heading_ignores_place_and_heading_alone() -> None:
    arm = sm.Rig.arm(6)
    desired = arm.fk(np.linspace(-0.5, 0.5, 6))
    drifted = turned(desired, 0.7, np.array([2.0, 0.0, -1.0]))
    zero = sm.errors(desired, drifted, "heading")
    assert np.abs(zero.angular).max() < 2e-6 and np.abs(zero.linear).max() < 2e-6
    assert np.abs(sm.errors(desired, drifted, "world").linear).max() > 1
    # The height is part of the error.
    lifted = turned(desired, 0.7, np.array([2.0, 0.25, -1.0]))
    assert np.allclose(sm.errors(desired, lifted, "heading").linear, [0, -0.25, 0], atol=2e-6)


def test_a_projection_of_the_rigs_own_poses_is_their_world_error() -> None:
    arm = sm.Rig.arm(6)
    desired, found = arm.fk(arm.home), arm.fk(arm.home + 0.2)
    projected = sm.errors([desired] * 3, [found] * 3, "projection", rig=arm)
    world = sm.errors([desired] * 3, [found] * 3, "world")
    assert np.abs(projected.linear - world.linear).max() < 1e-4
    assert np.abs(projected.angular - world.angular).max() < 1e-3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"desired": [[0.0] * 7]}, "quaternion of length 0.0000"),
        ({"desired": [[np.nan, 0, 0, 0, 0, 0, 1]]}, r"desired\[0, 0\]"),
        ({"measured": [[0, 0, 0, 0, 0, 0, 1]] * 2}, "expected 7 numbers in a row"),
        ({"method": "body"}, "method: expected local"),
        ({"method": "local"}, "parents or rig"),
        ({"method": "projection", "parents": [-1]}, "needs the rig"),
        ({"parents": [-1, 0]}, "the tree has 2 bodies"),
        ({"parents": [0]}, "parents"),
        ({"beta": 3.0}, "beta"),
        ({"desired_velocity": [[0.0] * 5]}, "desired_velocity: expected 6 numbers in the last axis"),
        ({"desired": [[0.0] * 6] * 7}, "desired: expected 7 numbers in the last axis"),
        ({"measured_velocity": [[np.inf] * 6]}, r"measured_velocity\[0, 0\]"),
    ],
)
def test_refusals(arguments: dict[str, Any], words: str) -> None:
    pose = [[0, 0, 0, 0, 0, 0, 1]]
    with pytest.raises(ValueError, match=words):
        sm.errors(**{"desired": pose, "measured": pose, **arguments})
