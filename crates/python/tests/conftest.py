"""Fixtures: folders and files that the tests need."""

from __future__ import annotations

import json
import os
import pathlib
import signal
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import pytest

import sinew_motion as sm

ROOT = pathlib.Path(__file__).resolve().parents[3]

# A shell's background jobs ignore Ctrl-C, and pass this on to the programs that the tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


def golden(path: str) -> Any:
    """Reads a golden file of the repository."""
    return json.loads((ROOT / "tests" / path).read_text())


@pytest.fixture(scope="session")
def data() -> pathlib.Path:
    """Returns the folder of motion capture and robots. Without it, tests are skipped."""
    folder = os.environ.get("SINEW_DATA")
    if not folder:
        pytest.skip("SINEW_DATA is not set")
    return pathlib.Path(folder)


@pytest.fixture(scope="session")
def program() -> str:
    """Returns the command ``sinew``. Without it, tests that compare results with it are skipped."""
    path = os.environ.get("SINEW_PROGRAM")
    if not path:
        pytest.skip("SINEW_PROGRAM is not set")
    return path


@pytest.fixture(autouse=True)
def sockets(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> pathlib.Path:
    """Returns the folder of the sockets of consoles, in which no other program has any."""
    folder = tmp_path_factory.mktemp("sockets")
    monkeypatch.setenv("SINEW_SOCKETS", str(folder))
    return folder


@pytest.fixture
def console(program: str, tmp_path: pathlib.Path, sockets: pathlib.Path) -> Iterator[sm.Rig]:
    """Runs ``sinew console`` on a simulated arm, and returns its rig."""
    file = tmp_path / "arm.toml"
    sm.Rig.arm(2).save(file)
    running = subprocess.Popen(
        [program, "console", "--no-open", "--rig", str(file)], stdout=subprocess.DEVNULL, cwd=tmp_path
    )
    try:
        end = time.monotonic() + 60.0
        while not list(sockets.glob("*.sock")):
            assert running.poll() is None and time.monotonic() < end, "the console does not start"
            time.sleep(0.05)
        yield sm.Rig.load(file)
    finally:
        running.send_signal(signal.SIGINT)
        assert running.wait(60.0) == 0


@pytest.fixture(scope="session")
def arm() -> sm.Rig:
    return sm.Rig.arm(6)


@pytest.fixture(scope="session")
def clip() -> sm.Clip:
    return sm.read_clip("punches_01", seconds=1.0)
