"""Measures inverse dynamics from Python: rows per second of sinew_motion, Pinocchio (pin) and MuJoCo, in one run.

    pip install pin mujoco
    python bench/dynamics.py

The model is a humanoid of 18 bodies: a fixed base, and 17 hinges in the tree of the paper's figure. The torques
are compared before anything is measured. Each number is the best of five rounds.
"""

from __future__ import annotations

import importlib
import pathlib
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import sinew_motion as sm

PARENTS = [-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16]
ROWS = 20_000


def urdf() -> str:
    """Returns a URDF of the humanoid, whose hinges have alternating axes."""
    axes = ["1 0 0", "0 1 0", "0 0 1"]
    links, joints = [], []
    for body, parent in enumerate(PARENTS):
        mass = 1.0 + 0.2 * body
        links.append(
            f'<link name="b{body}"><inertial><origin xyz="0.02 0.01 -{0.1 + 0.005 * body:.3f}"/><mass value="{mass}"/>'
            f'<inertia ixx="{0.02 * mass}" iyy="{0.018 * mass}" izz="{0.008 * mass}" ixy="0.001" ixz="0" iyz="0.0005"/>'
            "</inertial></link>"
        )
        if parent >= 0:
            side = 0.05 * (body % 3 - 1)
            joints.append(
                f'<joint name="j{body}" type="revolute"><parent link="b{parent}"/><child link="b{body}"/>'
                f'<origin xyz="{side} 0.02 -0.2" rpy="0.1 {0.02 * body:.2f} -0.1"/><axis xyz="{axes[body % 3]}"/>'
                '<limit lower="-3" upper="3" effort="100" velocity="10"/></joint>'
            )
    return f'<robot name="humanoid">{"".join(links + joints)}</robot>'


def best(call: Callable[[], Any], count: int) -> float:
    """Returns the rows per second of the best of five rounds."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return count / min(times)


def optional(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: left out")
        return None


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "humanoid.urdf"
        path.write_text(urdf())
        rig = sm.Rig.load(path)
        pin, mujoco = optional("pinocchio"), optional("mujoco")
        model = pin.buildModelFromUrdf(str(path)) if pin else None
        other = mujoco.MjModel.from_xml_path(str(path)) if mujoco else None
    random = np.random.default_rng(1)
    q = random.uniform(-1.0, 1.0, (ROWS, rig.nv))
    qd, qdd = random.normal(size=(2, ROWS, rig.nv))
    ours = rig.inverse_dynamics(q, qd, qdd)
    few = 2_000
    rates = {
        "sinew_motion, one row a call": best(
            lambda: [rig.inverse_dynamics(q[row], qd[row], qdd[row]) for row in range(few)], few
        ),
        "sinew_motion, all rows in a call": best(lambda: rig.inverse_dynamics(q, qd, qdd), ROWS),
    }
    if pin:
        state = model.createData()
        order = [model.joints[model.getJointId(name)].idx_v for name in rig.dof_names]
        there = [np.ascontiguousarray(part[:, np.argsort(order)]) for part in (q, qd, qdd)]
        theirs = np.array([pin.rnea(model, state, *row).copy() for row in zip(*there)])[:, order]
        off = np.abs(ours - theirs).max() / np.abs(theirs).max()
        print(f"against pin {pin.__version__}: {off:.1e} of the largest torque")
        rows = list(zip(*(part[:few] for part in there)))
        rates["pin, one row a call"] = best(lambda: [pin.rnea(model, state, *row) for row in rows], few)
    if mujoco:
        data = mujoco.MjData(other)
        order = [other.joint(name).dofadr[0] for name in rig.dof_names]
        there = [np.ascontiguousarray(part[:, np.argsort(order)]) for part in (q, qd, qdd)]

        def inverse(row: int) -> Any:
            data.qpos[:], data.qvel[:], data.qacc[:] = there[0][row], there[1][row], there[2][row]
            mujoco.mj_inverse(other, data)
            return data.qfrc_inverse

        theirs = np.array([inverse(row).copy() for row in range(few)])[:, order]
        off = np.abs(ours[:few] - theirs).max() / np.abs(theirs).max()
        print(f"against mujoco {mujoco.__version__}: {off:.1e} of the largest torque")
        rates["mujoco, one row a call (with its collisions)"] = best(lambda: [inverse(row) for row in range(few)], few)
    for name, rate in rates.items():
        print(f"{rate:12,.0f} rows/s  {name}")


if __name__ == "__main__":
    main()
