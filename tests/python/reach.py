"""A plugin of pytest: notes which tests reach which function of a copy that mutmut made, and how long each lasts.

`tests/python/mutants.py` runs it in the copy. What a fixture reaches counts for all tests that share it, and
what is reached while a file is read for all tests of the file. Programs that tests start note it for themselves.
Tests that fail without any mistake are left out.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections import defaultdict
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from mutmut.mutation import trampoline
from mutmut.state import state

reaching: dict[str, set[str]] = defaultdict(set)
lasts: dict[str, float] = defaultdict(float)
failed: set[str] = set()
read: dict[str, set[str]] = defaultdict(set)

trampoline._mutant_under_test = "stats"
by_programs = tempfile.TemporaryDirectory()
os.environ["REACHED"] = by_programs.name
os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).with_name("reached")), os.environ["PYTHONPATH"]])


def _noted(tests: list[str]) -> None:
    functions = set(state()._stats)
    for file in Path(by_programs.name).iterdir():
        functions.update(file.read_text(encoding="utf-8").splitlines())
        file.unlink()
    for function in functions:
        reaching[function].update(tests)
    state()._stats.clear()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    try:
        return (yield)
    finally:
        read[collector.nodeid].update(state()._stats)
        state()._stats.clear()


def pytest_collection_finish(session: pytest.Session) -> None:
    for file, functions in read.items():
        state()._stats.update(functions)
        _noted([item.nodeid for item in session.items if item.nodeid.startswith(f"{file}::")])


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: Any, request: pytest.FixtureRequest) -> Generator[None, Any, Any]:
    before = set(state()._stats)
    state()._stats.clear()
    begun = time.perf_counter()
    try:
        return (yield)
    finally:
        if fixturedef.scope != "function":
            place, name = fixturedef.baseid, fixturedef.argname
            shared = [
                item.nodeid
                for item in request.session.items
                if item.nodeid.startswith(place) and name in getattr(item, "fixturenames", ())
            ]
            _noted(shared)
            # Each of them needs it where it runs alone.
            for test in shared:
                lasts[test] += time.perf_counter() - begun
        state()._stats.update(before)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, Any, Any]:
    try:
        return (yield)
    finally:
        _noted([item.nodeid])


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    lasts[report.nodeid] += report.duration
    if report.failed:
        failed.add(report.nodeid)


def pytest_sessionfinish() -> None:
    found = {name: sorted(tests - failed) for name, tests in reaching.items()}
    written = {"reaching": found, "lasts": lasts, "failed": sorted(failed)}
    Path(os.environ["REACH"]).write_text(json.dumps(written, indent=1), encoding="utf-8")
