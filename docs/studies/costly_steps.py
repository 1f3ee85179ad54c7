"""Costs of the costliest communication steps beside the median, under every friction law.

The cylinder runs its default experiment (3 s, 5 +- 2 V, 1 Hz, communication steps of 1 ms) ten times, each time from
another phase of the sine. Of each communication step the attempts of the solver are counted, rejected ones among them.
With the program `steps` of the benchmark, a library of the FMUs and valgrind the instructions are counted, too, in the
first of these runs, in the calls of `fmi2DoStep`. Both are the same each time, on a busy machine as well, where
times are not. A table is printed and left in a folder.

Usage: python docs/studies/costly_steps.py [--count PROGRAM LIBRARY] [--laws LAW ...] [--output FOLDER],
       for example with --count target/debug/steps target/binaries/linux64/pneumatic_servo_fmu.so
       (cargo build --package benchmark --bin steps; cargo xtask build --platforms linux64)
"""

from __future__ import annotations

import argparse
import csv
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pneumatic_servo as ps

STOP, STEP, PHASES = 3.0, 1e-3, 10
COUNTED = 3000
"""Communication steps whose instructions are counted."""
SHARES = [0.5, 0.999, 0.9999, 1.0]
HEADER = [
    "law",
    *(f"attempts {name}" for name in ["median", "99.9 %", "99.99 %", "worst"]),
    *(f"instructions {name}" for name in ["median", "99.9 %", "worst"]),
]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known = list(ps.Model("PneumaticServoCylinder").variables["friction.law"].items)
    parser.add_argument(
        "--count",
        nargs=2,
        type=Path,
        metavar=("PROGRAM", "LIBRARY"),
        help="`steps` of the benchmark, and the library whose instructions valgrind counts",
    )
    parser.add_argument("--laws", nargs="+", choices=known, default=known, metavar="LAW", help="some laws alone")
    parser.add_argument("--output", type=Path, default=Path("target/studies"), help="folder of the table")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for law in options.laws:
        row: list[str | int] = [law, *shares(attempts(law), SHARES)]
        if options.count:
            row += shares(instructions(*options.count, law), [0.5, 0.999, 1.0])
        rows.append(row)
        print("  ".join(f"{cell:>16}" for cell in row), flush=True)
    file = options.output / "costly_steps.csv"
    with file.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([HEADER[: len(rows[0])], *rows])
    print(f"table: {file}")
    return 0


def attempts(law: str) -> np.ndarray:
    """Attempts of the solver in each communication step."""
    model, times = ps.Model("PneumaticServoCylinder"), np.arange(round(STOP / STEP)) * STEP
    counts = []
    for phase in np.arange(PHASES) / PHASES:
        run = model.simulate(
            {"friction.law": law},
            inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * (times + phase)))},
            stop=STOP,
            step=STEP,
            outputs=["solver.steps", "solver.rejectedSteps"],
        )
        counts.append(np.diff(run["solver.steps"] + run["solver.rejectedSteps"]))
    return np.concatenate(counts)


def instructions(program: Path, library: Path, law: str) -> np.ndarray:
    """Instructions of each call of `fmi2DoStep`, by callgrind, which leaves a file of each."""
    with tempfile.TemporaryDirectory() as folder:
        valgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts"]
        calls = ["--collect-atstart=no", "--toggle-collect=fmi2DoStep", "--dump-after=fmi2DoStep"]
        run = [program, library, law, str(COUNTED)]
        done = subprocess.run([*valgrind, *calls, *run], text=True, capture_output=True, check=False)
        if done.returncode:
            raise SystemExit(f"valgrind failed: {done.stderr}")
        counts = [re.search(r"^(?:summary|totals): (\d+)", file.read_text(), re.M) for file in Path(folder).iterdir()]
        found = np.array([int(count[1]) for count in counts if count and int(count[1])])
    if len(found) != COUNTED:
        raise SystemExit(f"valgrind saw {len(found)} calls of fmi2DoStep in {library}, not {COUNTED}")
    return found


def shares(counts: np.ndarray, of: list[float]) -> list[int]:
    """Numbers that as large a share of the counts does not exceed."""
    ordered = np.sort(counts)
    return [int(ordered[min(int(share * len(ordered)), len(ordered) - 1)]) for share in of]


if __name__ == "__main__":
    sys.exit(main())
