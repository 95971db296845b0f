"""Measures inverse dynamics on one core: rows per second of sinew_motion and of other libraries, in one run.

    pip install pin==4.1.0 cmeel-eigen==3.4.1 mujoco==4.0.0 dynibo==0.5.2
    python bench/dynamics.py

``cargo xtask python --bench`` does both with a new wheel. The model is a humanoid of 18 bodies: a fixed base, and 17
hinges in the tree of the paper's figure. All torques are compared before anything is measured. The candidates take
turns; each number is the best of several turns. With g++, a loop of Pinocchio in C++ (``pinocchio.cpp``) is a
candidate: compiled for any processor of the target, as our wheel is, and for this processor alone.
"""

from __future__ import annotations

import importlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import sinew_motion as sm

PARENTS = [-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 0, 16]
ROWS = 20_000
# Number of rows of candidates that take one row a call.
FEW = 2_000
TURNS = 15
# Definitions that Pinocchio's build files set for users of its headers.
DEFINITIONS = [
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
]

Array = Any
Motion = tuple[Array, Array, Array]


class Candidate:
    """A way to compute efforts: its name, its efforts of the first rows, and a turn, which returns seconds per row."""

    def __init__(self, name: str, efforts: Array, turn: Callable[[], float]) -> None:
        self.name, self.efforts, self.turn, self.seconds = name, efforts, turn, float("inf")


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


def optional(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: left out")
        return None


def timed(call: Callable[[], Any], rows: int) -> Callable[[], float]:
    """Returns a turn that measures a call, which computes this number of rows."""

    def turn() -> float:
        start = time.perf_counter()
        call()
        return (time.perf_counter() - start) / rows

    return turn


def ours(rig: sm.Rig, motion: Motion) -> list[Candidate]:
    def rows_a_call(size: int) -> Candidate:
        count = ROWS if size == ROWS else FEW
        pieces = [tuple(part[row : row + size] for part in motion) for row in range(0, count, size)]
        return Candidate(
            f"sinew_motion, {size:,} rows a call",
            np.concatenate([rig.inverse_dynamics(*piece) for piece in pieces]),
            timed(lambda: [rig.inverse_dynamics(*piece) for piece in pieces], count),
        )

    single = list(zip(*(part[:FEW] for part in motion)))
    return [
        Candidate(
            "sinew_motion, one row a call",
            np.array([rig.inverse_dynamics(*row) for row in single]),
            timed(lambda: [rig.inverse_dynamics(*row) for row in single], FEW),
        ),
        rows_a_call(100),
        rows_a_call(ROWS),
    ]


def ordered(motion: Motion, places: list[int]) -> Motion:
    """Returns a motion in the order of another library, which has our dofs at these places."""
    q, qd, qdd = (np.ascontiguousarray(part[:, np.argsort(places)]) for part in motion)
    return q, qd, qdd


def of_pin(path: pathlib.Path, rig: sm.Rig, motion: Motion) -> list[Candidate]:
    pin = optional("pinocchio")
    if not pin:
        return []
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    places = [model.joints[model.getJointId(name)].idx_v for name in rig.dof_names]
    there = ordered(motion, places)
    rows = list(zip(*(part[:FEW] for part in there)))
    candidates = [
        Candidate(
            f"pin {pin.__version__}, one row a call",
            np.array([pin.rnea(model, data, *row).copy() for row in rows])[:, places],
            timed(lambda: [pin.rnea(model, data, *row) for row in rows], FEW),
        )
    ]
    compiler = shutil.which("g++")
    if not compiler:
        print("g++ is not installed: the loop in C++ is left out")
        return candidates
    saved, numbers, out = (path.with_name(name) for name in ("model", "rows", "efforts"))
    model.saveToBinary(str(saved))
    numbers.write_bytes(b"".join(part.tobytes() for part in there))
    prefix = next(p for p in (pathlib.Path(entry) / "cmeel.prefix" for entry in sys.path) if p.is_dir())
    headers, libraries = prefix / "include", prefix / "lib"
    for processor, options in [("any processor", []), ("this processor", ["-march=native"])]:
        program = path.with_name(processor.replace(" ", "-"))
        source = pathlib.Path(__file__).with_name("pinocchio.cpp")
        build = [compiler, "-std=c++17", "-O3", "-DNDEBUG", "-w", *options, *DEFINITIONS]
        build += ["-isystem", headers / "eigen3", "-isystem", headers, source, "-o", program, f"-L{libraries}"]
        subprocess.run([*build, "-lboost_serialization", f"-Wl,-rpath,{libraries}"], check=True)

        def turn(program: pathlib.Path = program) -> float:
            told = subprocess.run([program, saved, numbers, out, "2"], check=True, capture_output=True, text=True)
            return float(told.stdout) * 1e-9

        turn()
        efforts = np.fromfile(out).reshape(ROWS, rig.nv)[:, places]
        candidates.append(Candidate(f"Pinocchio, a loop in C++ for {processor}", efforts, turn))
    return candidates


def of_mujoco(path: pathlib.Path, rig: sm.Rig, motion: Motion) -> list[Candidate]:
    mujoco = optional("mujoco")
    if not mujoco:
        return []
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    places = [model.joint(name).dofadr[0] for name in rig.dof_names]
    rows = list(zip(*(part[:FEW] for part in ordered(motion, places))))

    def inverse(row: tuple[Array, ...]) -> Array:
        data.qpos[:], data.qvel[:], data.qacc[:] = row
        mujoco.mj_inverse(model, data)
        return data.qfrc_inverse

    return [
        Candidate(
            f"mujoco {mujoco.__version__}, one row a call, with collisions",
            np.array([inverse(row).copy() for row in rows])[:, places],
            timed(lambda: [inverse(row) for row in rows], FEW),
        )
    ]


def of_dynibo(path: pathlib.Path, rig: sm.Rig, motion: Motion) -> list[Candidate]:
    dynibo = optional("dynibo")
    if not dynibo:
        return []
    robot = dynibo.Robot.from_urdf(str(path))
    # Its gravity is 9.80665 m/s².
    more = 9.81 / 9.80665 - 1.0
    places = [robot.link_id(name) - 1 for name in rig.body_names[1:]]
    rows = list(zip(*(part[:FEW] for part in ordered(motion, places))))
    return [
        Candidate(
            f"dynibo {dynibo.distribution_version('dynibo')}, one row a call",
            np.array([robot.inverse_dynamics(*row) + more * robot.gravity(row[0]) for row in rows])[:, places],
            timed(lambda: [robot.inverse_dynamics(*row) for row in rows], FEW),
        )
    ]


def difference(candidate: Candidate, reference: Candidate) -> float:
    """Returns the largest difference of efforts relative to the largest effort, and refuses wrong efforts."""
    expected = reference.efforts[: len(candidate.efforts)]
    relative = float(np.abs(candidate.efforts - expected).max() / np.abs(expected).max())
    # Float32 has 24 bits; a model that was read differently is off by much more.
    if not relative < 2e-5:
        raise SystemExit(f"{candidate.name}: the efforts differ by {relative:.1e} of the largest")
    return relative


def main() -> None:
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "humanoid.urdf"
        path.write_text(urdf())
        rig = sm.Rig.load(path)
        motion = (random.uniform(-1.0, 1.0, (ROWS, rig.nv)), *random.normal(size=(2, ROWS, rig.nv)))
        candidates = ours(rig, motion)
        for others in (of_pin, of_mujoco, of_dynibo):
            candidates += others(path, rig, motion)
        reference = candidates[2]
        differences = [difference(candidate, reference) for candidate in candidates]
        for _ in range(TURNS):
            for candidate in candidates:
                candidate.seconds = min(candidate.seconds, candidate.turn())
    print(f"{'':<52} {'difference':>10} {'rows/s':>12} {'us/row':>8} {'ratio':>7}")
    for candidate, off in zip(candidates, differences):
        ratio = candidate.seconds / reference.seconds
        rate, microseconds = 1 / candidate.seconds, 1e6 * candidate.seconds
        print(f"{candidate.name:<52} {off:>10.1e} {rate:>12,.0f} {microseconds:>8.3f} {ratio:>7.1f}")
    print(f"difference: largest difference from '{reference.name}', relative to the largest effort;")
    print("ratio: time relative to that of the same candidate")


if __name__ == "__main__":
    main()
