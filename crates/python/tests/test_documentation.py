"""Every public function has a docstring with an example, and every example has the result that it shows."""

from __future__ import annotations

import doctest
import inspect
from collections.abc import Iterator
from typing import Any

import pytest

import sinew_motion as sm


def documented() -> Iterator[tuple[str, Any]]:
    yield "sinew_motion", sm
    for name in sm.__all__:
        thing = getattr(sm, name)
        yield name, thing
        if not inspect.isclass(thing):
            continue
        for part, of in vars(thing).items():
            if not part.startswith("_"):
                yield f"{name}.{part}", getattr(of, "__func__", of)


PARTS = dict(documented())


@pytest.mark.parametrize("name", PARTS)
def test_has_a_docstring_and_a_true_example(name: str) -> None:
    part = PARTS[name]
    text = inspect.getdoc(part)
    assert text, name
    globs = {key: getattr(sm, key) for key in sm.__all__}
    test = doctest.DocTestParser().get_doctest(text, globs, name, None, None)
    if inspect.isfunction(part):
        assert test.examples, f"{name} has no example"
    runner = doctest.DocTestRunner()
    out: list[str] = []
    runner.run(test, out=out.append)
    assert not runner.failures, "".join(out)


def test_all_parts_are_documented() -> None:
    assert len(PARTS) > 60
