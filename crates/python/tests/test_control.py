"""Tests of the tracker, of the evaluation, and of the ways to end long work."""

from __future__ import annotations

import csv
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import sinew_motion as sm


def test_efforts_are_inverse_dynamics_of_the_command(arm: sm.Rig) -> None:
    kp = 30.0
    tracker = sm.Tracker(arm, "local", rate_hz=500, settings={"kp": kp})
    q, qd = arm.home.copy(), np.linspace(-0.2, 0.2, 6)
    wanted, rates = q + np.linspace(0.01, 0.03, 6), np.linspace(0.1, -0.1, 6)
    step = tracker.step(wanted, q, qd, qd_desired=rates, qdd_desired=np.full(6, 0.5))
    command = 0.5 + kp * (wanted - q) + 2 * np.sqrt(kp) * (rates - qd)
    expected = arm.inverse_dynamics(q, qd, command)
    limited = np.abs(expected) > arm.effort
    assert not limited.any() and step.limited == [None] * 6
    assert np.allclose(step.effort, expected, atol=1e-4 * np.abs(expected).max())


def test_what_limits_an_effort_is_told(arm: sm.Rig) -> None:
    tracker = sm.Tracker(arm, "world", rate_hz=500)
    step = tracker.step(arm.home + 2.0, arm.home)
    assert "torque" in step.limited
    assert np.all(np.abs(step.effort) <= arm.effort * (1 + 1e-6))


@pytest.mark.parametrize("method", sorted(sm.methods()))
def test_every_method_ticks(arm: sm.Rig, method: str) -> None:
    tracker = sm.Tracker(arm, method, rate_hz=500)
    for _ in range(5):
        step = tracker.step(arm.home, arm.home)
        assert np.all(np.isfinite(step.effort))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda arm: sm.Tracker(arm, "wrold"), "unknown variant `wrold`"),
        (lambda arm: sm.Tracker(arm, rate_hz=float("nan")), "rate_hz"),
        (lambda arm: sm.Tracker(arm, settings={"kq": 1}), "unknown field `kq`"),
        (lambda arm: sm.Tracker(arm, settings={"kp": float("nan")}), "settings"),
        (lambda arm: sm.Tracker(arm, rate_hz=100, latency_ticks=3), "10 ms|late|delay"),
        (lambda arm: sm.Tracker(arm).step(arm.home, [float("nan")] * 6), "NaN"),
        (lambda arm: sm.Tracker(arm).step(arm.home, arm.home[:5]), "q: expected 6 numbers"),
        (lambda arm: sm.Tracker(arm).step([arm.home], arm.home), "single row"),
    ],
)
def test_refusals_of_the_tracker(arm: sm.Rig, make, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make(arm)


EXACT = {"plant": {"kind": "articulated"}}


def test_the_evaluation_is_that_of_the_command(program: str) -> None:
    command = [program, "evaluate", "--plant", "articulated", "--seconds", "0.5", "--format", "csv", "--scale", "1.1"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = list(csv.DictReader(output.splitlines()))
    table = sm.evaluate(setup=EXACT, seconds=0.5, scales=[1.1])
    assert len(rows) == 6
    for place, row in enumerate(rows):
        for name, field in row.items():
            assert (field == table[name][place]) or float(field or "nan") == table[name][place] or field == ""


def test_rows_by_clip_and_over_time() -> None:
    common = {"methods": ["world", "recommended"], "scales": [1.1], "setup": EXACT, "seconds": 0.4}
    by_clip = sm.evaluate(rows="clip", **common)
    clips = sorted(set(by_clip["clip"]))
    assert "punches_01" in clips and len(by_clip["clip"]) == len(clips) * 2 * 2
    over_time = sm.evaluate(rows="time", **common)
    assert set(over_time) == {"clip", "scale", "method", "time_s", "angular_mean_deg", "linear_mean_cm"}
    steps = np.array([name == "punches_01" for name in over_time["clip"]])
    assert np.ptp(np.asarray(over_time["time_s"])[steps]) > 0.3
    assert {len(column) for column in over_time.values()} == {len(over_time["clip"])}


def test_a_rig_is_evaluated() -> None:
    table = sm.evaluate(rig=sm.Rig.arm(3), methods=["recommended"], seconds=0.5)
    assert table["method"] == ["recommended"] * 2 and np.all(np.asarray(table["angular_mean_deg"]) < 10)
    performed = sm.evaluate(["punches_01"], rig=sm.Rig.arm(6), methods=["recommended"], seconds=0.5)
    assert len(performed["method"]) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"clips": ["no.bvh"]}, "no.bvh"),
        ({"scales": [float("nan")]}, "scales"),
        ({"setup": {"plant": {"kind": "jelly"}}}, "plant.kind"),
        ({"setup": {"plnt": 1}}, "plnt"),
        ({"seconds": 0.0}, "seconds"),
        ({"rate_hz": 1.0}, "rate_hz"),
        ({"rows": "row", "seconds": 0.1, "methods": ["world"]}, "rows: expected one of total"),
    ],
)
def test_refusals_of_the_evaluation(arguments: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        sm.evaluate(**{"setup": EXACT, **arguments})


def test_a_sweep_resumes(tmp_path: pathlib.Path) -> None:
    lines = ['setup.plant.kind = "articulated"', "[[grid]]", "dimensions.scale = [1.0, 1.1]"]
    lines.append('controller.method = ["world"]')
    (tmp_path / "sweep.toml").write_text("\n".join(lines))
    calls: list[tuple[int, int]] = []
    sweep = lambda: sm.sweep(
        tmp_path / "sweep.toml", seconds=0.3, output=tmp_path / "out", progress=lambda *steps: calls.append(steps)
    )
    first = sweep()
    assert calls[-1][0] == calls[-1][1] > 0
    calls.clear()
    assert {name: list(map(str, column)) for name, column in sweep().items()} == {
        name: list(map(str, column)) for name, column in first.items()
    }
    assert calls[-1] == (0, 0)
    assert list(first["dimensions.scale"]) == [1.0, 1.1]
    assert len(sm.sweep(tmp_path / "sweep.toml", seconds=0.3, rows="clip")["clip"]) > 2
    with pytest.raises(ValueError, match="no.toml"):
        sm.sweep(tmp_path / "no.toml")


def test_progress_is_told_and_its_error_ends_the_work() -> None:
    def stop(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sm.evaluate(progress=stop, setup=EXACT)


def test_other_threads_run_meanwhile() -> None:
    counted, done = [0], threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(1e-3)

    thread = threading.Thread(target=count)
    thread.start()
    sm.evaluate(methods=["world"], scales=[1.0], setup=EXACT, seconds=1.0)
    done.set()
    thread.join()
    assert counted[0] > 10


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
@pytest.mark.parametrize(
    "work",
    [
        "sm.evaluate(methods=['manifold_projection'] * 1, setup={'plant': {'substeps': 200}})",
        "[arm.mass_matrix(q) for _ in range(1000)]",
    ],
)
def test_ctrl_c_ends_the_work(work: str) -> None:
    code = f"""
import numpy as np, sinew_motion as sm
arm = sm.Rig.arm(6)
q = np.zeros((500_000, 6))
print("ready", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout and child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    output, _ = child.communicate(timeout=60)
    assert output == "interrupted\n"
