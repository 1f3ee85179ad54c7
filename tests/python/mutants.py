"""Puts mistakes into the numerics of the Python package, one at a time, and counts those that the tests notice.

Usage: python tests/python/mutants.py [MODULE ...] [--sample N] [--seed N], for example `identification/profile.py`; by
default all `MODULES`, and all mistakes rather than some drawn at random.

It needs mutmut (`pip install mutmut`), the FMUs of `cargo xtask package`, and the package as
`maturin develop --release` puts it into `python`. It works on a copy in target/mutants, takes hours, and is no part of
the tests; one that was interrupted goes on where it was.
`cd target/mutants && mutmut show NAME` shows a mistake, `mutmut results` those that were not noticed.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
WORK = TARGET / "mutants"

MODULES = {
    "comparison.py": ["test_package_arguments.py", "test_package_linear.py", "test_package_tables.py"],
    "data_sheet.py": ["test_package_data_sheet.py", "test_package_cli_options.py"],
    "envs/controllers.py": ["test_package_envs.py"],
    "envs/positioning.py": ["test_package_envs.py"],
    "envs/task.py": ["test_package_envs.py"],
    "grid.py": ["test_package.py", "test_package_arguments.py"],
    "identification/compression.py": ["test_identification_solve.py"],
    "identification/fitting.py": ["test_identification_linear.py", "test_identification_refused.py"],
    "identification/intervals.py": ["test_identification_linear.py"],
    "identification/planning.py": ["test_identification_plan.py"],
    "identification/profile.py": ["test_identification_linear.py"],
    "identification/sensor.py": ["test_identification_sensor.py"],
    "linear.py": ["test_package_linear.py"],
    "trim.py": ["test_package_linear.py"],
}
"""Where mistakes are made, and the tests that are to notice: those of the subject, since each costs their time."""
COPIED = ["tests/python", "packaging/python", "modelDescription", "examples", "docs", "fuzz", "studies"]
"""What the tests read."""


def prepare(modules: list[str]) -> None:
    """Copy what is changed and what is run, and write the settings of mutmut."""
    ignored = shutil.ignore_patterns("__pycache__", "fmu_files", "target", "corpus", "artifacts")
    package = ROOT / "python" / "pneumatic_servo"
    shutil.copytree(package, WORK / "pneumatic_servo", ignore=ignored, dirs_exist_ok=True)
    for folder in COPIED:
        shutil.copytree(ROOT / folder, WORK / folder, ignore=ignored, dirs_exist_ok=True)
    tests = sorted({f"tests/python/{test}" for module in modules for test in MODULES[module]})
    settings = {
        "source_paths": ["pneumatic_servo"],
        "only_mutate": [f"pneumatic_servo/{module}" for module in modules],
        "also_copy": [folder.split("/")[0] for folder in COPIED if not folder.startswith("tests/")],
        # Commands that are started elsewhere do not find the settings of mutmut.
        "pytest_add_cli_args": ["-c", "tests/python/pytest.ini", "-k", "not command"],
        "pytest_add_cli_args_test_selection": tests,
    }
    lines = ["[tool.mutmut]", *(f"{name} = {value!r}" for name, value in settings.items()), ""]
    (WORK / "pyproject.toml").write_text("\n".join(lines).replace("'", '"'), encoding="utf-8")


def mutmut(*arguments: str, check: bool = True) -> str:
    """Run mutmut in the copy, and return what `results` prints."""
    # Mistakes are tried in forks, which threads of numerical libraries do not survive.
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}
    # The FMUs are those of the source.
    environment["CARGO_TARGET_DIR"] = str(TARGET)
    command = [sys.executable, "-m", "mutmut", *arguments]
    output = subprocess.PIPE if arguments[0] == "results" else None
    return subprocess.run(command, cwd=WORK, env=environment, check=check, stdout=output, text=True).stdout


def outcomes() -> dict[str, str]:
    """What became of each mistake so far."""
    lines = mutmut("results", "--all", "true").splitlines()
    return dict(line.strip().rsplit(": ", 1) for line in lines if ": " in line)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("modules", nargs="*", metavar="MODULE", help=", ".join(MODULES))
    parser.add_argument("--sample", type=int, metavar="N", help="make so many mistakes, drawn at random, not all")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the draw (default: 1)")
    options = parser.parse_args()
    modules = options.modules or list(MODULES)
    unknown = [module for module in modules if module not in MODULES]
    if unknown:
        parser.error(f"there are no tests for {', '.join(unknown)}; there are {', '.join(MODULES)}")
    prepare(modules)
    if options.sample:
        # A run of no mistake makes the list to draw from, and ends.
        mutmut("run", "none", check=False)
        every = outcomes()
        drawn = random.Random(options.seed).sample(sorted(every), min(options.sample, len(every)))
        print(f"{len(drawn)} of {len(every)} mistakes are drawn", flush=True)
        waiting = [name for name in drawn if every[name] == "not checked"]
        if waiting:
            mutmut("run", "--max-children", "2", *waiting)
    else:
        mutmut("run", "--max-children", "2")
        drawn = list(outcomes())
    found = {name: outcome for name, outcome in outcomes().items() if name in drawn}
    counts = Counter(found.values())
    noticed = counts["killed"] + counts["timeout"] + counts["segfault"]
    left = [name for name, outcome in found.items() if outcome in ("survived", "no tests", "suspicious")]
    print("\n".join(left))
    print(f"{noticed} of {noticed + len(left)} mistakes were noticed: {dict(counts)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
