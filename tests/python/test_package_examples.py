"""The examples in the help of the package run, and every public function and class has one."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
import warnings
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import matplotlib
import pneumatic_servo as ps
import pytest
from pneumatic_servo import envs, identification

MODULES = (ps, identification, envs)
"""Names that users import."""

LEFT_OUT = {"pneumatic_servo.__main__"} | ({"pneumatic_servo.torch"} if find_spec("torch") is None else set())
"""The command line, and what needs PyTorch where it is not: it brings gigabytes, and has tests of its own."""


def documented() -> Iterator[tuple[str, Any]]:
    """Everything of the package that has a docstring with an example."""
    names = [module.name for module in pkgutil.walk_packages(ps.__path__, "pneumatic_servo.")]
    for name in ["pneumatic_servo", *(name for name in names if name not in LEFT_OUT)]:
        for test in doctest.DocTestFinder(exclude_empty=True).find(importlib.import_module(name)):
            if test.examples:
                yield test.name, test


TESTS = dict(documented())


@pytest.fixture(autouse=True)
def _quiet(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Examples draw without a screen, and write into a folder of their own."""
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", TESTS)
def test_example_runs(name: str) -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    with warnings.catch_warnings():
        told: list[str] = []
        runner.run(TESTS[name], out=told.append, clear_globs=False)
    assert runner.summarize(verbose=False).failed == 0, "".join(told)


def functions() -> Iterator[tuple[str, Any]]:
    """Every public function, and every method of a model."""
    for module in MODULES:
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isfunction(thing) and thing is not envs.register:
                yield name, thing
    for name, method in vars(ps.Model).items():
        if inspect.isfunction(method) and not name.startswith("_"):
            yield f"Model.{name}", method


def classes() -> Iterator[tuple[str, Any]]:
    """Every class that users make or are given, but `NotConverged`, which the command line raises."""
    for module in MODULES:
        for name in module.__all__:
            if inspect.isclass(thing := getattr(module, name)) and name != "NotConverged":
                yield name, thing


def test_every_public_function_and_class_has_an_example() -> None:
    documented = [*functions(), *classes()]
    lacking = [name for name, thing in documented if ">>>" not in (inspect.getdoc(thing) or "")]
    assert lacking == []


def test_every_method_says_what_it_does() -> None:
    """Also where it is shown by completion alone."""
    lacking = []
    for module in MODULES:
        for name in module.__all__:
            thing = getattr(module, name)
            for method in vars(thing) if inspect.isclass(thing) else ():
                member = inspect.getattr_static(thing, method)
                is_shown = callable(member) or isinstance(member, (property, staticmethod, classmethod))
                if (
                    is_shown
                    and not method.startswith("_")
                    and not (inspect.getdoc(getattr(thing, method)) or "").strip()
                ):
                    lacking.append(f"{name}.{method}")
    assert lacking == []
