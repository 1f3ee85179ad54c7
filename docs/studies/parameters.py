"""A parameter study on all cores of this machine, in its processes, or on a Dask cluster: by `executor=`.

Every friction law is run with every combination of dead zone and sonic conductance of the valve through the default
experiment (5 +- 2 V, 1 Hz, 3 s). What an engineer compares is left as a CSV file and a figure: rest at
the reversals, stroke, peak velocity, energy lost to friction, solver steps.

The runs have the same bits wherever they are made, and the rows are in the order of the grid. A cluster needs Dask
here, and Dask and this package on its workers: pip install 'dask[distributed]'.

Usage: python docs/studies/parameters.py [--laws Stribeck LuGre ...] [--workers 8 | --processes 8 | --scheduler tcp://host:1]
"""

from __future__ import annotations

import argparse
import csv
import itertools
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from pneumatic_servo.figures import BLUE, GREEN, STYLE, VERMILION

DEAD_ZONES = [0.04, 0.08, 0.12]
CONDUCTANCES = [2e-9, 3.93e-9, 6e-9]
STOP, STEP = 3.0, 1e-3

AT_REST = 1e-4
"""Speed in m/s below which a carriage counts as resting, also under laws that only creep."""


@dataclass(frozen=True)
class Case:
    """A point of the grid."""

    law: str
    dead_zone: float
    conductance: float


@dataclass(frozen=True)
class Row:
    """A case and what came out."""

    law: str
    dead_zone: float
    conductance: float
    rest: float
    """Share of the time at rest after the first motion."""
    stroke: float
    """Distance in m between the extreme positions."""
    peak_velocity: float
    """In m/s."""
    friction_loss: float
    """Energy in J lost to friction."""
    solver_steps: int


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--workers", type=int, help="threads of this process (default: one per core)")
    who.add_argument("--processes", type=int, help="processes of this machine instead")
    who.add_argument("--scheduler", help="address of a Dask scheduler, whose workers make the runs")
    parser.add_argument("--laws", nargs="+", metavar="LAW", help="friction laws (default: all)")
    parser.add_argument("--output", type=Path, default=Path("target/studies"), help="folder of the results")
    arguments = parser.parse_args()
    laws = arguments.laws or list(ps.Model("PneumaticServoCylinder").parameters["friction.law"].items)
    cases = [Case(*point) for point in itertools.product(laws, DEAD_ZONES, CONDUCTANCES)]
    with executor_of(arguments.scheduler, arguments.processes) as executor:
        rows = study(cases, executor, arguments.workers)
    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    write(rows, folder / "parameters.csv")
    draw(rows, folder / "parameters.png")
    print(f"{len(rows)} runs; results and figure: {folder}")
    return 0


@contextmanager
def executor_of(scheduler: str | None, processes: int | None) -> Iterator[Executor | None]:
    """Executor of the runs: workers of a cluster, processes, or none."""
    if scheduler:
        try:
            from dask.distributed import Client
        except ImportError as error:
            sys.exit(f"a scheduler needs Dask, here and on the workers: pip install 'dask[distributed]' ({error})")
        with Client(scheduler) as client:  # type: ignore[no-untyped-call]
            yield client.get_executor()
    elif processes:
        with ProcessPoolExecutor(processes) as pool:
            yield pool
    else:
        yield None


def study(cases: list[Case], executor: Executor | None, workers: int | None) -> list[Row]:
    """Runs all cases, with a progress bar on a terminal."""
    times = np.arange(round(STOP / STEP)) * STEP
    runs = ps.Model("PneumaticServoCylinder").simulate_many(
        [{"friction.law": case.law, "valve.deadZone": case.dead_zone, "valve.C": case.conductance} for case in cases],
        inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * times))},
        stop=STOP,
        step=STEP,
        outputs=["position", "velocity", "frictionForce", "solver.steps"],
        workers=workers,
        executor=executor,
    )
    return [row_of(case, run) for case, run in zip(cases, runs, strict=True)]


def row_of(case: Case, run: ps.Run) -> Row:
    """Result of one run."""
    # The rows after the start.
    position, velocity, force = (run[name][1:] for name in ("position", "velocity", "frictionForce"))
    speeds = np.abs(velocity)
    moving = np.flatnonzero(speeds > AT_REST)
    return Row(
        **asdict(case),
        rest=float(np.mean(speeds[moving[0] :] <= AT_REST)) if moving.size else 1.0,
        stroke=float(np.ptp(position)),
        peak_velocity=float(speeds.max()),
        friction_loss=float(np.sum(force * velocity) * STEP),
        solver_steps=int(run["solver.steps"][-1]),
    )


def write(rows: list[Row], file: Path) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def draw(rows: list[Row], file: Path) -> None:
    """Rest and friction loss by law; one mark per valve setting, coloured by dead zone."""
    laws = list(dict.fromkeys(row.law for row in rows))
    colours = dict(zip(DEAD_ZONES, [BLUE, GREEN, VERMILION], strict=True))
    sizes = dict(zip(CONDUCTANCES, [15, 40, 80], strict=True))
    panels = [("rest", "share of time at rest (%)", 100.0), ("friction_loss", "friction loss (J)", 1.0)]
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(panels), 1, figsize=(0.35 * len(laws) + 4, 6), sharex=True, layout="constrained"
        )
        for axis, (quantity, label, factor) in zip(axes, panels, strict=True):
            for row in rows:
                place, value = laws.index(row.law), factor * getattr(row, quantity)
                axis.scatter(
                    place, value, s=sizes[row.conductance], color=colours[row.dead_zone], alpha=0.6, linewidth=0
                )
            axis.set_ylabel(label)
        for dead_zone, colour in colours.items():
            axes[0].scatter([], [], color=colour, label=f"dead zone {100 * dead_zone:g} %")
        for conductance, size in sizes.items():
            axes[0].scatter(
                [], [], s=size, color="none", edgecolor="black", label=f"C = {1e8 * conductance:g} dm³/(s·bar)"
            )
        axes[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        axes[-1].set_xticks(range(len(laws)), labels=laws, rotation=90)
        figure.savefig(file)
        plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
