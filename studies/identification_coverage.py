"""How often the 95 % intervals of a fit contain what is true.

Rigs that are integrated independently of this library (synthetic_rig.py), seen by sensors with noise and 12 bits, are
fitted again and again with other noise. For every law and parameter the number of repetitions is counted in which the
true value lies within its interval; and how the law Coulomb predicts what is held out, beside the true law.

Usage: python studies/identification_coverage.py [--laws Stribeck ...] [--repetitions 100] [--duration 3]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import pneumatic_servo as ps
from numpy.typing import NDArray
from pneumatic_servo.files import write_csv
from synthetic_rig import COMMON, LAWS, SUPPLY, measured, truth
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]
COLUMNS = ["law", "parameter", "true", "repetitions", "covered", "mean error (%)", "half interval (%)"]

Array = NDArray[np.float64]


def fitted(seen: dict[str, Array], law: str, start: dict[str, float], hold_out: float = 0.0) -> ps.Fit:
    """A fit of everything that is unknown; it starts at given values, since coverage is no matter of the start."""
    free = [f"{name}={value}" for name, value in start.items()]
    known: dict[str, ps.Value] = {"supplyPressure": SUPPLY}
    return ps.fit(seen, experiment="rig", law=law, fit=free, settings=known, starts=0, hold_out=hold_out)


def rows(law: str, duration: float, repetitions: int) -> list[tuple[object, ...]]:
    """The table of a law."""
    true = truth(law, duration)
    values = {**LAWS[law], **COMMON}
    covered = dict.fromkeys(values, 0)
    errors: dict[str, list[float]] = {name: [] for name in values}
    halves: dict[str, list[float]] = {name: [] for name in values}
    for seed in tqdm(range(repetitions), law, disable=None):
        found = fitted(measured(true, seed), law, values)
        for name, value in values.items():
            estimate = found.parameters[name]
            covered[name] += estimate.low <= value <= estimate.high
            errors[name].append(estimate.value / value - 1.0)
            halves[name].append(0.5 * (estimate.high - estimate.low) / value)
    return [
        (law, name, value, repetitions, covered[name], f"{100 * np.mean(np.abs(errors[name])):.3f}",
         f"{100 * np.mean(halves[name]):.3f}")
        for name, value in values.items()
    ]  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laws", nargs="+", default=list(LAWS), choices=LAWS)
    parser.add_argument("--repetitions", type=int, default=100)
    parser.add_argument("--duration", type=float, default=3.0, help="of the record in s")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "studies", help="folder of the table")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    table: list[tuple[object, ...]] = []
    for law in options.laws:
        table += rows(law, options.duration, options.repetitions)
        write_csv(options.output / "coverage.csv", COLUMNS, table)
    for row in table:
        print(*row)
    return 0


if __name__ == "__main__":
    sys.exit(main())
