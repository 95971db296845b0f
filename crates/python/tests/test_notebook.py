"""The notebook and the examples run without an error."""

from __future__ import annotations

import importlib.util
import pathlib
import subprocess
import sys

import pytest

PACKAGE = pathlib.Path(__file__).resolve().parents[1]
MISSING = [
    name
    for name in ("nbclient", "nbformat", "ipykernel", "matplotlib", "pandas")
    if importlib.util.find_spec(name) is None
]


@pytest.mark.skipif(bool(MISSING), reason=f"needs {', '.join(MISSING)}")
def test_the_notebook_runs() -> None:
    import nbclient
    import nbformat

    notebook = nbformat.read(PACKAGE / "notebooks/tour.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    images = [
        output
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if "image/png" in output.get("data", {})
    ]
    assert len(images) == 2


# `test_lerobot.py` runs the example for LeRobot.
EXAMPLES = sorted(path for path in (PACKAGE / "examples").glob("*.py") if path.stem != "record_lerobot")


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(example: pathlib.Path) -> None:
    done = subprocess.run([sys.executable, str(example)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout
