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
from itertools import pairwise
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "packaging" / "python"))

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from client import Client
from common import ROOT
from experiment import LAW, signals
from matplotlib.figure import Figure
from pneumatic_servo.figures import BLUE, GREEN, GREY, STYLE, VERMILION
from pneumatic_servo.files import write_csv

SPEEDS = np.geomspace(1e-4, 0.1, 16)
"""Speeds of the steady curve in m/s."""

TURNS = [0.0, 7.0, -7.0, 7.0, 2.0, 6.0, -7.0]
"""Quasi-static load of the presliding test in N, from one turning point to the next: an outer and an inner loop."""

NOTHING = 1e-12
"""A displacement in m below which nothing has moved."""

REPEATS = 5
COST = ["solver.steps", "solver.rejectedSteps", "solver.jacobians", "solver.events"]


@dataclass
class Portrait:
    """What a law does on the bench."""

    law: str
    steady: np.ndarray
    """Rows of velocity in m/s and friction force in N."""
    presliding: np.ndarray
    """Rows of displacement in m and applied force in N."""
    stick_slip: np.ndarray
    """Rows of time in s, position of the mass and of the drive in m."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fmus", type=Path, help="folder of the FMUs (default: those of the package)")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "gallery", help="folder of figure and table")
    arguments = parser.parse_args()
    fmus = arguments.fmus or ps.fmus()[0].parent
    bench, cylinder = fmus / "FrictionBench.fmu", fmus / "PneumaticServoCylinder.fmu"
    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    with Client(bench) as client:
        laws = list(client.items(LAW))
    portraits, costs = [], []
    for number, law in enumerate(laws, start=1):
        portraits.append(Portrait(law, steady_curve(bench, law), *motions(bench, law)))
        costs.append(cost(cylinder, law))
        row = costs[-1]
        print(f"[{number:2}/{len(laws)}] {law}: {row['solver.steps']} steps, {row['µs/step']} µs per call", flush=True)
    draw(portraits, folder / "FrictionLaws.png")
    write_csv(folder / "FrictionLaws.csv", list(costs[0]), (list(row.values()) for row in costs))
    print(f"figure and table: {folder / 'FrictionLaws.png'}, {folder / 'FrictionLaws.csv'}")
    return 0


def steady_curve(fmu: Path, law: str) -> np.ndarray:
    """Friction at constant speed, after 5 mm or 0.3 s, whichever takes longer; both directions."""
    rows = []
    for velocity in [*-SPEEDS[::-1], *SPEEDS]:
        with Client(fmu) as client:
            client.start({LAW: law, "bench.drive": "PrescribedMotion", "driveVelocity": velocity})
            settle = max(0.3, 5e-3 / abs(velocity))
            while client.time < settle:
                client.advance(client.time + settle / 20)
            # A law with noise or samples has no single value: the mean of ten points shows its level.
            forces = []
            for _ in range(10):
                client.advance(client.time + 1e-3)
                forces += client.get(["frictionForce"])
            rows.append((velocity, np.mean(forces)))
    return np.array(rows)


def motions(fmu: Path, law: str) -> tuple[np.ndarray, np.ndarray]:
    return presliding(fmu, law), stick_slip(fmu, law)


def presliding(fmu: Path, law: str, per_turn: int = 60, interval: float = 5e-3) -> np.ndarray:
    """A free mass under a slowly varying load below break-away."""
    loads = np.concatenate([np.linspace(a, b, per_turn, endpoint=False) for a, b in pairwise(TURNS)])
    rows = []
    with Client(fmu) as client:
        client.start({LAW: law, "bench.drive": "Free", "driveVelocity": 0.0})
        for load in loads:
            client.set({"appliedForce": load})
            client.advance(client.time + interval)
            rows.append((*client.get(["position"]), load))
    return np.array(rows)


def stick_slip(fmu: Path, law: str, end: float = 3.0) -> np.ndarray:
    """A mass pulled by a soft spring at 10 mm/s."""
    rows = []
    with Client(fmu) as client:
        client.start({LAW: law, "spring.stiffness": 1000.0, "driveVelocity": 0.01})
        while client.time < end:
            client.advance(client.time + 1e-2)
            rows.append((client.time, *client.get(["position", "drivePosition"])))
    return np.array(rows)


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
    """Blocks of laws; three rows each: steady curve, hysteresis, stick-slip."""
    portraits = [portrait for portrait in portraits if np.any(portrait.steady[:, 1] != 0.0)]
    columns = 4
    blocks = -(-len(portraits) // columns)
    with mpl.rc_context(STYLE | {"axes.titlesize": 12, "axes.titleweight": "bold", "font.size": 10}):
        figure = Figure(figsize=(12, 5.4 * blocks), dpi=100, layout="constrained")
        for block, part in enumerate(np.atleast_1d(figure.subfigures(blocks, 1))):
            grid = part.subplots(3, columns, squeeze=False)
            chosen = portraits[block * columns : (block + 1) * columns]
            for column in range(columns):
                if column < len(chosen):
                    draw_portrait(grid[:, column], chosen[column], first=column == 0)
                else:
                    for axis in grid[:, column]:
                        axis.set_visible(False)
        figure.suptitle("Friction laws on the bench, with their defaults", fontsize=14, fontweight="bold")
        figure.savefig(file, metadata={"Software": None})


def draw_portrait(axes: np.ndarray, portrait: Portrait, first: bool) -> None:
    steady, hysteresis, motion = axes
    steady.set_title(portrait.law)
    steady.axhline(0, color=GREY, linewidth=0.5)
    for half in np.split(portrait.steady, 2):
        steady.plot(1e3 * half[:, 0], half[:, 1], ".-", color=GREEN, markersize=4)
    steady.set_xscale("symlog", linthresh=0.1)
    steady.set_xticks([-100, -1, 0, 1, 100], labels=["−100", "−1", "0", "1", "100"])
    steady.set_ylim(-13, 13)
    steady.set_xlabel("velocity (mm/s)")
    displacement, load = portrait.presliding.T
    hysteresis.plot(1e6 * displacement, load, color=VERMILION, linewidth=1.0)
    if np.ptp(displacement) < NOTHING:
        hysteresis.set_xlim(-1, 1)
        hysteresis.text(0.05, 0.9, "does not move", transform=hysteresis.transAxes, color=GREY)
    hysteresis.set_xlabel("displacement (µm)")
    time, mass, drive = portrait.stick_slip.T
    motion.plot(time, 1e3 * drive, color=GREY, linewidth=0.9, label="drive")
    motion.plot(time, 1e3 * mass, color=BLUE, label="mass")
    motion.set_xlabel("time (s)")
    if first:
        steady.set_ylabel("steady friction (N)")
        hysteresis.set_ylabel("load (N)")
        motion.set_ylabel("position (mm)")
        motion.legend(loc="upper left")


if __name__ == "__main__":
    sys.exit(main())
