"""Puts mistakes into the Python package, one at a time, and counts those that the tests notice.

Usage: python tests/python/mutants.py [MODULE ...] [--sample N] [--seed N], for example `identification/profile.py`; by
default all modules, and all mistakes rather than some drawn at random.

It needs mutmut (`pip install mutmut`), which makes the mistakes, the FMUs of `cargo xtask package`, and the package as
`maturin develop --release` puts it into `python`. A mistake meets the tests that reach its function, as `reach.py`
notes them, the quickest first, until one fails. It works on a copy in target/mutants, and is no part of the tests; what
became of a mistake is kept there, so that a run that was ended goes on where it was. Those tried until then are the
first of the draw, which is a draw as well.
`cd target/mutants && mutmut show NAME` shows a mistake.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import json
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from itertools import islice
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NoReturn

import pytest

ROOT = Path(__file__).parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
WORK = TARGET / "mutants"
COPY = WORK / "mutants"
OUTCOMES = WORK / "outcomes.json"
REACH = WORK / "reach.json"
MADE_OF = WORK / "made-of.txt"
PACKAGE = ROOT / "python" / "pneumatic_servo"

NEEDED = {"jax.py": "jax", "torch.py": "torch"}
"""Modules that are left out where what they are for is not installed."""
ABOUT_FILES = ["test_floors.py", "test_package_wheel.py"]
"""Tests of the files as they are in the source, not of what they do."""
OF_DATA = "test_identification_data.py"
"""It has the package by a study, and measurements beside the repository."""
COPIED = [
    "tests/python", "tests/reference", "packaging/python", "modelDescription", "examples", "docs", "fuzz", "studies",
]  # fmt: skip
"""What the tests read."""
# Each mistake repeats the examples of what it is made in.
OPTIONS = ["-c", "tests/python/pytest.ini", "-k", "not mutmut", "--rootdir=."]
MOST = 8.0
"""So many times as long as its tests a mistake may take."""


def modules() -> list[str]:
    """Those that mistakes can be made in."""
    found = sorted(file.relative_to(PACKAGE).as_posix() for file in PACKAGE.rglob("*.py"))
    return [one for one in found if one not in NEEDED or importlib.util.find_spec(NEEDED[one])]


def prepare() -> None:
    """Copy what is changed and what is run, and let mutmut make all mistakes."""
    ignored = shutil.ignore_patterns("__pycache__", "target", "corpus", "artifacts")
    shutil.copytree(PACKAGE, WORK / "pneumatic_servo", ignore=ignored, dirs_exist_ok=True)
    for folder in COPIED:
        shutil.copytree(ROOT / folder, WORK / folder, ignore=ignored, dirs_exist_ok=True)
    measurements = ROOT.parent / "shared"
    if measurements.is_dir() and not (WORK / "shared").exists():
        (WORK / "shared").symlink_to(measurements, target_is_directory=True)
    settings = {
        "source_paths": ["pneumatic_servo"],
        "only_mutate": [f"pneumatic_servo/{module}" for module in modules()],
        "also_copy": [folder.split("/")[0] for folder in COPIED if not folder.startswith("tests/")],
        "pytest_add_cli_args": ["--collect-only"],
        "pytest_add_cli_args_test_selection": ["tests/python/test_floors.py"],
    }
    lines = ["[tool.mutmut]", *(f"{name} = {value!r}" for name, value in settings.items()), ""]
    (WORK / "pyproject.toml").write_text("\n".join(lines).replace("'", '"'), encoding="utf-8")
    # Having made the mistakes, it ends at once for want of tests.
    mutmut("run", "none")
    digest = hashlib.sha256()
    for folder in ("pneumatic_servo", "tests"):
        for file in sorted((WORK / folder).rglob("*.py")):
            digest.update(file.read_bytes())
    # What became of mistakes in another source, or by other tests, is not what becomes of these.
    if not MADE_OF.exists() or MADE_OF.read_text(encoding="utf-8") != digest.hexdigest():
        OUTCOMES.unlink(missing_ok=True)
        REACH.unlink(missing_ok=True)
        MADE_OF.write_text(digest.hexdigest(), encoding="utf-8")


def tests_of_package() -> list[str]:
    """The files of tests that say something of what the package does."""
    return [
        f"tests/python/{file.name}"
        for file in sorted((ROOT / "tests/python").glob("test_*.py"))
        if file.name == OF_DATA or "pneumatic_servo" in file.read_text(encoding="utf-8")
        if file.name not in ABOUT_FILES
    ]


def mutmut(*arguments: str) -> str:
    """Run mutmut in the folder of the copy, and return what it prints."""
    command = [sys.executable, "-m", "mutmut", *arguments]
    return subprocess.run(command, cwd=WORK, check=False, stdout=subprocess.PIPE, text=True).stdout


def made() -> list[str]:
    """Return the names of all mistakes."""
    lines = mutmut("results", "--all", "true").splitlines()
    return sorted(line.strip().rsplit(": ", 1)[0] for line in lines if "__mutmut_" in line)


def enter() -> None:
    """Go into the copy and import all that the tests import, so that each process has it from its beginning."""
    # Two run at a time, and forks do not survive threads of numerical libraries; the FMUs are those of the source.
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    os.environ["CARGO_TARGET_DIR"] = str(TARGET)
    places = [str(COPY), str(COPY / "tests/python"), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    os.environ["PYTHONPATH"] = os.pathsep.join(places)
    sys.path[:0] = places
    os.chdir(COPY)
    if not REACH.exists():
        found = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "reach", *OPTIONS, *tests_of_package()],
            env=os.environ | {"REACH": str(REACH)},
            check=False,
        )
        if found.returncode > 1:
            raise SystemExit("the tests could not be run")
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        pytest.main(["-q", "--collect-only", *OPTIONS, *tests_of_package()])


def tried(mistake: str, tests: Sequence[str]) -> NoReturn:
    """Run tests with a mistake until one fails, and end with what pytest says."""
    os.environ["MUTANT_UNDER_TEST"] = mistake
    # With a group of its own, what it starts can be ended with it.
    os.setsid()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    sys.exit(int(pytest.main(["-x", "-q", *OPTIONS, *tests])) if tests else 0)


class Tests:
    """Which tests reach which function, and how long they last."""

    def __init__(self) -> None:
        noted = json.loads(REACH.read_text(encoding="utf-8"))
        self._reaching: Mapping[str, list[str]] = noted["reaching"]
        self._lasts: Mapping[str, float] = noted["lasts"]
        print("fail without a mistake, and are left out:", *noted["failed"] or ["none"])

    def of(self, mistake: str) -> list[str]:
        """Those that reach a mistake, the quickest first."""
        return sorted(self._reaching.get(mistake.rsplit("__mutmut_", 1)[0], []), key=self._lasts.__getitem__)

    def most(self, tests: Iterable[str]) -> float:
        """How long in s these may last with a mistake before it is a loop without end."""
        return MOST * (sum(self._lasts[test] for test in tests) + 10.0)


def attempt(drawn: Iterable[str], tests: Tests) -> Iterator[tuple[str, str]]:
    """Try mistakes, two at a time, and yield what became of each."""
    waiting = iter(drawn)
    running: dict[int, tuple[Any, str, float]] = {}
    fork = multiprocessing.get_context("fork")
    try:
        while True:
            for mistake in islice(waiting, 2 - len(running)):
                own = tests.of(mistake)
                process = fork.Process(target=tried, args=(mistake, own))
                process.start()
                running[process.sentinel] = process, mistake, time.monotonic() + tests.most(own)
            if not running:
                return
            wait(list(running), timeout=5.0)
            for sentinel, (process, mistake, until) in list(running.items()):
                is_late = process.is_alive() and time.monotonic() > until
                if is_late or not process.is_alive():
                    del running[sentinel]
                    end(process)
                    ended = {0: "survived", 1: "killed"}.get(process.exitcode, f"ended by {process.exitcode}")
                    yield mistake, "timeout" if is_late else ended
    finally:
        for process, _, _ in running.values():
            end(process)


def end(process: Any) -> None:
    """End a process, and what it has started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.join()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", help="where to make mistakes (default: everywhere)")
    parser.add_argument("--sample", type=int, metavar="N", help="make so many mistakes, drawn at random, not all")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the draw (default: 1)")
    options = parser.parse_args()
    unknown = [module for module in options.modules if module not in modules()]
    if unknown:
        parser.error(f"there is no module {', '.join(unknown)}; there are {', '.join(modules())}")
    prepare()
    begins = tuple("pneumatic_servo." + one.removesuffix(".py").replace("/", ".") + ".x" for one in options.modules)
    every = [mistake for mistake in made() if not begins or mistake.startswith(begins)]
    drawn = random.Random(options.seed).sample(every, min(options.sample or len(every), len(every)))
    print(f"{len(drawn)} of {len(every)} mistakes are drawn", flush=True)
    enter()
    outcomes: dict[str, str] = json.loads(OUTCOMES.read_text(encoding="utf-8")) if OUTCOMES.exists() else {}
    for mistake, outcome in attempt((mistake for mistake in drawn if mistake not in outcomes), Tests()):
        outcomes[mistake] = outcome
        OUTCOMES.write_text(json.dumps(outcomes, indent=1), encoding="utf-8")
        print(outcome, mistake, flush=True)
    found = {mistake: outcomes[mistake] for mistake in drawn}
    # What does not end may loop, which is noticed, or a machine was busy; it is looked at by hand.
    left = [mistake for mistake, outcome in found.items() if outcome in ("survived", "timeout")]
    print("\n".join(left))
    print(f"{len(found) - len(left)} of {len(found)} mistakes were noticed: {dict(Counter(found.values()))}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
