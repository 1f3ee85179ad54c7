"""Compares all friction laws: steady curve, presliding hysteresis and stick-slip on the bench, and what they cost.

Leaves `FrictionLaws.png` (all laws side by side) and `FrictionLaws.csv` (solver steps and time per law in the default
experiment of the cylinder).
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "packaging" / "python"))

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from client import Client
from common import ROOT
from experiment import LAW, signals
from matplotlib.figure import Figure
from pneumatic_servo.figures import STYLE
from pneumatic_servo.files import write_csv
from portraits import draw_presliding, draw_steady, draw_stick_slip, presliding, steady_curve, stick_slip

COLUMNS = 3
"""Laws side by side in the figure."""

REPEATS = 5
COST = ["solver.steps", "solver.rejectedSteps", "solver.jacobians", "solver.events"]


@dataclass
class Portrait:
    """Results of a law on the bench."""

    law: str
    steady: np.ndarray
    """Rows of velocity in m/s and friction force in N."""
    presliding: np.ndarray
    """Rows of displacement in m and applied force in N."""
    stick_slip: ps.Run
    """Drawn by a soft spring."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fmus", type=Path, help="folder of the FMUs (default: the package's)")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "gallery", help="folder of figure and table")
    arguments = parser.parse_args()
    fmus = arguments.fmus or ps.fmus()[0].parent
    cylinder = fmus / "PneumaticServoCylinder.fmu"
    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    with Client(cylinder) as client:
        laws = list(client.items(LAW))
    portraits, costs = [], []
    for number, law in enumerate(laws, start=1):
        portraits.append(Portrait(law, steady_curve(law), presliding(law), stick_slip(law)))
        costs.append(cost(cylinder, law))
        row = costs[-1]
        print(f"[{number:2}/{len(laws)}] {law}: {row['solver.steps']} steps, {row['µs/step']} µs per call", flush=True)
    draw(portraits, folder / "FrictionLaws.png")
    write_csv(folder / "FrictionLaws.csv", list(costs[0]), (list(row.values()) for row in costs))
    print(f"figure and table: {folder / 'FrictionLaws.png'}, {folder / 'FrictionLaws.csv'}")
    return 0


def cost(fmu: Path, law: str) -> dict[str, float | int | str]:
    """Solver work and time per communication step of 1 ms in the default experiment, FMPy's own time included.

    The run is repeated, and of each step the least time counts: what the operating system does in between does not.
    """
    seconds = np.full(1, np.inf)
    for _ in range(REPEATS):
        with Client(fmu) as client:
            seconds = np.minimum(seconds, timed_run(client, law))
            counts = {name: int(value) for name, value in zip(COST, client.get(COST), strict=True)}
    return {"law": law, **counts, "µs/step": round(1e6 * seconds.mean(), 1), "µs worst": round(1e6 * seconds.max(), 1)}


def timed_run(client: Client, law: str) -> np.ndarray:
    """Time in s of each communication step."""
    default = client.description.defaultExperiment
    step, count = float(default.stepSize), round(float(default.stopTime) / float(default.stepSize))
    moving = signals(client.description.modelName)
    seconds = np.empty(count)
    client.start({LAW: law})
    for index in range(count):
        client.set({name: signal(index * step) for name, signal in moving.items()})
        begin = time.perf_counter()
        client.advance((index + 1) * step)
        seconds[index] = time.perf_counter() - begin
    return seconds


def draw(portraits: Sequence[Portrait], file: Path) -> None:
    """Blocks of laws; three rows each: steady curve, hysteresis, stick-slip. As wide as a page of the site."""
    drawn = [portrait for portrait in portraits if np.any(portrait.steady[:, 1] != 0.0)]
    blocks = -(-len(drawn) // COLUMNS)
    with mpl.rc_context(STYLE | {"axes.titlesize": 12, "axes.titleweight": "bold", "font.size": 10}):
        figure = Figure(figsize=(9, 5.4 * blocks), dpi=100, layout="constrained")
        for block, part in enumerate(np.atleast_1d(figure.subfigures(blocks, 1))):
            grid = part.subplots(3, COLUMNS, squeeze=False)
            chosen = drawn[block * COLUMNS : (block + 1) * COLUMNS]
            for column, portrait in enumerate(chosen):
                draw_portrait(grid[:, column], portrait, first=column == 0)
            for axis in grid[:, len(chosen) :].flat:
                axis.set_visible(False)
        figure.savefig(file, metadata={"Software": None})


def draw_portrait(axes: np.ndarray, portrait: Portrait, first: bool) -> None:
    steady, hysteresis, motion = axes
    steady.set_title(portrait.law)
    draw_steady(steady, portrait.steady)
    draw_presliding(hysteresis, portrait.presliding)
    draw_stick_slip(motion, portrait.stick_slip)
    if first:
        motion.legend(loc="upper left")
    else:
        for axis in axes:
            axis.set_ylabel("")


if __name__ == "__main__":
    sys.exit(main())
