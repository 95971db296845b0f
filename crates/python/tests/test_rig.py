"""Tests of rigs: shapes, refusals, kinematics and dynamics."""

from __future__ import annotations

import importlib.util
import pathlib

import numpy as np
import pytest
from conftest import ROOT, golden

import sinew_motion as sm

RANDOM = np.random.default_rng(20261128)


def states(rig: sm.Rig, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns random states of a rig without ball joints."""
    assert rig.nq == rig.nv
    return RANDOM.uniform(-1.5, 1.5, (count, rig.nq)), *RANDOM.normal(size=(2, count, rig.nv))


def test_names_and_limits(arm: sm.Rig) -> None:
    assert arm.body_names[0] == arm.joint_names[0] == "base"
    assert arm.joint_kinds == ["fixed"] + ["revolute"] * 6
    assert arm.parents[0] == -1 and all(parent < body for body, parent in enumerate(arm.parents))
    for limit in (arm.lower, arm.upper, arm.speed, arm.acceleration, arm.effort):
        assert limit.shape == (arm.nv,)
    assert np.all(arm.lower < arm.upper) and np.all(arm.speed > 0) and np.all(arm.effort > 0)
    assert arm.home.shape == (arm.nq,) and arm.mass.shape == (7,)
    assert len(arm.dof_names) == arm.nv and arm.followers == []
    assert "nq=6" in repr(arm)


def test_one_row_or_many(arm: sm.Rig) -> None:
    q, qd, qdd = states(arm, 11)
    calls = [
        lambda q, qd, qdd: arm.fk(q),
        lambda q, qd, qdd: arm.jacobian(q, 3, (0.1, 0.2, 0.3)),
        arm.inverse_dynamics,
        arm.forward_dynamics,
        lambda q, qd, qdd: arm.mass_matrix(q),
        lambda q, qd, qdd: arm.gravity(q),
    ]
    for call in calls:
        many = call(q, qd, qdd)
        assert many.dtype == np.float64 and len(many) == 11
        for row in range(11):
            one = call(q[row], qd[row], qdd[row])
            # Results must be identical, also if rows are computed side by side.
            assert np.array_equal(one, many[row])


def test_arrays_of_any_kind(arm: sm.Rig) -> None:
    q, qd, qdd = states(arm, 6)
    expected = arm.inverse_dynamics(q, qd, qdd)
    wide = np.zeros((6, 12))
    wide[:, ::2] = q
    assert np.array_equal(arm.inverse_dynamics(wide[:, ::2], qd, qdd), expected)
    assert np.array_equal(arm.inverse_dynamics(np.asfortranarray(q), qd.tolist(), qdd), expected)
    assert arm.inverse_dynamics(np.zeros((0, 6)), None, None).shape == (0, 6)
    one = arm.inverse_dynamics(q, qd[0], None)
    assert np.array_equal(one, arm.inverse_dynamics(q, np.tile(qd[0], (6, 1)), np.zeros((6, 6))))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda arm: arm.fk([0.0] * 5), "q: expected 6 numbers in a row, found 5"),
        (lambda arm: arm.gravity([np.nan] + [0.0] * 5), "NaN"),
        (lambda arm: arm.gravity([np.inf] + [0.0] * 5), "inf"),
        (lambda arm: arm.mass_matrix([2e6] + [0.0] * 5), "-1e6 to 1e6"),
        (lambda arm: arm.inverse_dynamics(np.zeros((3, 6)), np.zeros((2, 6)), None), "expected 3 rows"),
        (lambda arm: arm.forward_dynamics([0.0] * 6, [0.0] * 6, [0.0] * 5 + [np.nan]), "tau"),
        (lambda arm: arm.fk("joint"), "expected numbers"),
        (lambda arm: arm.fk(np.zeros((2, 2, 6))), "expected an array of 1 axes"),
        (lambda arm: arm.fk([[0.0] * 6, [0.0] * 5]), "expected numbers in rows of equal length"),
        (lambda arm: arm.jacobian(arm.home, "hand"), "expected one of base"),
        (lambda arm: arm.jacobian(arm.home, 7), "expected 0 to 6"),
        (lambda arm: arm.jacobian(arm.home, 1, (0, np.nan, 0)), "three finite numbers"),
        (lambda arm: sm.Rig.arm(0), "joints"),
    ],
)
def test_refusals_say_what_is_expected(arm: sm.Rig, call, words: str) -> None:
    with pytest.raises(ValueError) as refused:
        call(arm)
    assert words in str(refused.value)


def test_the_row_with_an_error_is_named(arm: sm.Rig) -> None:
    q = np.zeros((10, 6))
    q[6, 2] = np.nan
    for call in (arm.fk, arm.gravity, arm.mass_matrix):
        with pytest.raises(ValueError, match=r"row 6: q\[2\]"):
            call(q)


def test_jacobians_are_derivatives_of_kinematics(arm: sm.Rig) -> None:
    q, qd, _ = states(arm, 1)
    q, qd, step = q[0], qd[0], 1e-6
    after, before = (arm.fk(q + sign * step * qd) for sign in (1, -1))
    for body in range(len(arm.body_names)):
        linear = (after[body, :3] - before[body, :3]) / (2 * step)
        assert np.allclose(arm.jacobian(q, body)[:3] @ qd, linear, atol=1e-8)
        x, y, z, w = after[body, 3:]
        a, b, c, d = before[body, 3:] * [-1, -1, -1, 1]
        turn = np.array([w * a + d * x + y * c - z * b, w * b + d * y + z * a - x * c, w * c + d * z + x * b - y * a])
        assert np.allclose(arm.jacobian(q, body)[3:] @ qd, 2 * turn / (2 * step), atol=1e-7)


def test_power_at_a_point_is_power_at_the_joints(arm: sm.Rig) -> None:
    q, qd, _ = states(arm, 1)
    point = (0.1, -0.2, 0.3)
    pose = arm.fk(q[0])[4]
    x, y, z, w = pose[3:]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    at_origin, at_point = arm.jacobian(q[0], 4) @ qd[0], arm.jacobian(q[0], 4, point) @ qd[0]
    expected = at_origin[:3] + np.cross(at_origin[3:], rotation @ point)
    assert np.allclose(at_point[:3], expected) and np.allclose(at_point[3:], at_origin[3:])


def test_dynamics_agree_with_each_other(arm: sm.Rig) -> None:
    q, qd, qdd = states(arm, 50)
    tau = arm.inverse_dynamics(q, qd, qdd)
    back = arm.forward_dynamics(q, qd, tau)
    assert np.allclose(back, qdd, atol=2e-3 * np.abs(qdd).max())
    matrix = arm.mass_matrix(q)
    bias = arm.inverse_dynamics(q, qd, None)
    assert np.allclose(np.einsum("tij,tj->ti", matrix, qdd) + bias, tau, atol=1e-5 * np.abs(tau).max())
    assert np.array_equal(matrix, matrix.transpose(0, 2, 1))


def test_a_travelling_base_has_a_free_joint(tmp_path: pathlib.Path) -> None:
    sm.Rig.arm(2).save(tmp_path / "arm.toml")
    rig = sm.Rig.load(tmp_path / "arm.toml", base="driven")
    assert (rig.nq, rig.nv) == (9, 8) and rig.joint_kinds[0] == "free"
    q = rig.home.copy()
    with pytest.raises(ValueError, match="unit quaternion"):
        rig.fk(np.r_[0.5, q[1:]])
    # The total force is the weight of all bodies.
    weight = rig.gravity(q)[:6]
    turned = rig.fk(q)[0, 3:]
    assert np.isclose(np.linalg.norm(weight[3:]), 9.81 * rig.mass.sum(), rtol=1e-5), turned
    with pytest.raises(ValueError, match='expected "stand" or "driven"'):
        sm.Rig.load(tmp_path / "arm.toml", base="wheels")  # type: ignore[arg-type]


ROBOTS = ["poppy", "op3", "open_duck_urdf", "open_duck_mjcf", "panda", "so100", "h1", "allegro", "anymal", "talos"]


def of_golden(name: str, folder: pathlib.Path) -> tuple[dict, sm.Rig, np.ndarray]:
    """Returns a golden file, its rig, and the index of each dof in the file."""
    file = golden(f"golden/rigs/{name}.json")
    rig = sm.Rig.load(folder / file["file"], rotors=False, repair_inertia=file["repair_inertia"])
    return file, rig, np.array([file["joints"].index(dof) for dof in rig.dof_names])


def torques(file: dict, rig: sm.Rig, order: np.ndarray) -> tuple[float, float]:
    """Returns the largest error of a golden file's torques, and the largest torque."""
    column = lambda key: np.array([state[key] for state in file["states"]])[:, order]
    q, qd, qdd, tau = map(column, ("q", "qd", "qdd", "tau"))
    rotors = np.array(file["rotor_inertia"])[order] * qdd
    ours = rig.inverse_dynamics(q, qd, qdd) + rotors
    return float(np.abs(ours - tau).max()), float(np.abs(tau).max())


@pytest.mark.parametrize("name", ROBOTS)
def test_torques_of_robots_are_those_of_pinocchio(name: str, data: pathlib.Path) -> None:
    error, largest = torques(*of_golden(name, data))
    assert error < 2e-5 * largest


def test_torques_of_a_model_of_all_joints_are_those_of_mujoco() -> None:
    error, largest = torques(*of_golden("quirks", ROOT / "tests/golden/rigs"))
    assert error < 2e-5 * largest


@pytest.mark.skipif(importlib.util.find_spec("pinocchio") is None, reason="needs the package pin")
@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "open_duck_mjcf"])
def test_dynamics_of_robots_beside_the_installed_pinocchio(name: str, data: pathlib.Path) -> None:
    import pinocchio

    file, rig, _ = of_golden(name, data)
    if file["repair_inertia"]:
        pytest.skip("its file has impossible inertia, which Pinocchio keeps")
    model = pinocchio.buildModelFromUrdf(str(data / file["file"]))
    state = model.createData()
    places = [model.joints[model.getJointId(dof)] for dof in rig.dof_names]
    if rig.followers or model.nv != rig.nv or any(joint.nq != 1 for joint in places):
        pytest.skip("joints without limits or with followers have other coordinates there")
    order = [joint.idx_v for joint in places]
    q, qd, qdd = states(rig, 20)
    for row in range(20):
        theirs = []
        for numbers in (q, qd, qdd):
            own = np.zeros(model.nv)
            own[order] = numbers[row]
            theirs.append(own)
        tau = pinocchio.rnea(model, state, *theirs)[order]
        ours = rig.inverse_dynamics(q[row], qd[row], qdd[row])
        assert np.abs(ours - tau).max() < 2e-5 * max(1.0, np.abs(tau).max())
        matrix = pinocchio.crba(model, state, theirs[0])
        matrix = (np.triu(matrix) + np.triu(matrix, 1).T)[np.ix_(order, order)]
        assert np.abs(rig.mass_matrix(q[row]) - matrix).max() < 2e-5 * max(1.0, np.abs(matrix).max())
