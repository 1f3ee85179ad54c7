"""Generates the reference trajectories listed in ``cases.json``.

    python generate.py                 write the CSV of every scipy case, and accuracy.csv
    python generate.py NAME ...        only the named cases
    python generate.py --check         recompute the cvode cases and print the differences

Needs NumPy and SciPy.
"""

from __future__ import annotations

import argparse
import csv
import json
import time
from collections.abc import Iterable, Mapping
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from simulation import Row, simulate

FOLDER = Path(__file__).resolve().parent
ACCURACY_FILE = FOLDER / "accuracy.csv"
TOLERANCE = 1e-11
COARSE_TOLERANCE = 1e-9
QUANTITIES: dict[str, tuple[str, ...]] = {
    "position": ("position",),
    "velocity": ("velocity",),
    "pressure": ("pressureA", "pressureB"),
    "temperature": ("temperatureA", "temperatureB"),
    "spool": ("spool",),
    "frictionForce": ("frictionForce",),
    "sticking": ("sticking",),
}

Case = Mapping[str, Any]
Differences = dict[str, float]
Table = npt.NDArray[np.float64]


def main() -> None:
    options = _options()
    cases: list[Case] = json.loads((FOLDER / "cases.json").read_text())
    source, task = ("cvode", check) if options.check else ("scipy", generate)
    chosen = [case for case in cases if case["source"] == source and _named(case, options.names)]
    accuracy = {}
    with Pool(options.workers) as pool:
        for name, differences, seconds in pool.imap(task, chosen):
            print(f"{name}: {_summary(differences)} ({seconds:.0f} s)", flush=True)
            accuracy[name] = differences
    if not options.check:
        _record(accuracy, cases)


def generate(case: Case) -> tuple[str, Differences, float]:
    """Writes the trajectory of a case and compares it with a coarser computation."""
    begin = time.perf_counter()
    rows = simulate(case, TOLERANCE)
    _write(FOLDER / case["file"], rows)
    differences = compare(np.array(rows), np.array(simulate(case, COARSE_TOLERANCE)))
    return case["name"], differences, time.perf_counter() - begin


def check(case: Case) -> tuple[str, Differences, float]:
    """Compares a stored trajectory with a recomputed one."""
    begin = time.perf_counter()
    stored = np.loadtxt(FOLDER / case["file"], delimiter=",", skiprows=1)
    differences = compare(stored, np.array(simulate(case, TOLERANCE)))
    return case["name"], differences, time.perf_counter() - begin


def compare(table: Table, other: Table) -> Differences:
    """The largest difference of each kind of quantity between two trajectories."""
    columns = dict(zip(Row._fields, np.abs(table - other).max(axis=0).tolist(), strict=True))
    return {quantity: max(columns[name] for name in names) for quantity, names in QUANTITIES.items()}


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", help="cases to run; all if none is given")
    parser.add_argument("--check", action="store_true", help="recompute the cvode cases")
    parser.add_argument("--workers", type=int, default=2, help="number of processes")
    return parser.parse_args()


def _named(case: Case, names: Iterable[str]) -> bool:
    return not names or case["name"] in names


def _summary(differences: Differences) -> str:
    return ", ".join(f"{quantity} {value:.1e}" for quantity, value in differences.items())


def _write(path: Path, rows: list[Row]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(Row._fields)
        writer.writerows([f"{value:.12g}" for value in row] for row in rows)


def _record(accuracy: Mapping[str, Differences], cases: Iterable[Case]) -> None:
    """Updates accuracy.csv, keeping the lines of cases that were not run."""
    lines = _recorded() | {
        name: [name, *(f"{value:.1e}" for value in differences.values())] for name, differences in accuracy.items()
    }
    with ACCURACY_FILE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", *QUANTITIES])
        writer.writerows(lines[case["name"]] for case in cases if case["name"] in lines)


def _recorded() -> dict[str, list[str]]:
    if not ACCURACY_FILE.exists():
        return {}
    with ACCURACY_FILE.open(newline="") as file:
        lines = csv.reader(file)
        next(lines)
        return {line[0]: line for line in lines}


if __name__ == "__main__":
    main()
