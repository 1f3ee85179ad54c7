"""A parameter study on all cores of one machine or, unchanged, on a Dask cluster.

Every friction law is run with every combination of dead zone and sonic conductance of the valve through the default
experiment (5 +- 2 V, 1 Hz, 3 s). What an engineer compares is left as a CSV file and a figure: rest at
the reversals, stroke, peak velocity, energy lost to friction, solver steps.

The workers need this package and Dask: pip install 'dask[distributed]'. A task gives the same bits wherever it runs,
and the rows are in the order of the grid.

Usage: python studies/parameters.py [--scheduler tcp://host:8786] [--workers 8] [--laws Stribeck LuGre ...]
"""

from __future__ import annotations

import argparse
import csv
import itertools
import sys
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from pneumatic_servo.figures import BLUE, GREEN, STYLE, VERMILION
from tqdm import tqdm

try:
    from dask.distributed import Client as Cluster
    from dask.distributed import LocalCluster, as_completed
except ImportError as error:
    sys.exit(f"this study needs Dask, here and on the workers: pip install 'dask[distributed]' ({error})")

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
    parser.add_argument("--scheduler", help="address of a Dask scheduler (default: a cluster on this machine)")
    parser.add_argument("--workers", type=int, help="processes of the cluster on this machine (default: one per core)")
    parser.add_argument("--laws", nargs="+", metavar="LAW", help="friction laws (default: all)")
    parser.add_argument("--output", type=Path, default=Path("target/studies"), help="folder of the results")
    arguments = parser.parse_args()
    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    laws = arguments.laws or list(ps.Model("PneumaticServoCylinder").parameters["friction.law"].items)
    cases = [Case(*point) for point in itertools.product(laws, DEAD_ZONES, CONDUCTANCES)]
    if arguments.scheduler:
        with Cluster(arguments.scheduler) as cluster:
            rows = study(cluster, cases)
    else:
        with (
            LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None) as local,
            Cluster(local) as cluster,
        ):
            rows = study(cluster, cases)
    write(rows, folder / "parameters.csv")
    draw(rows, folder / "parameters.png")
    print(f"{len(rows)} runs; results and figure: {folder}")
    return 0


def study(cluster: Cluster, cases: list[Case]) -> list[Row]:
    """Runs all cases on a cluster, with a progress bar."""
    tasks = {cluster.submit(simulate, case, pure=False): case for case in cases}
    rows: dict[Case, Row] = {}
    for task in tqdm(as_completed(tasks), total=len(tasks), unit="run"):
        rows[tasks[task]] = task.result()
    return [rows[case] for case in cases]


def simulate(case: Case) -> Row:
    """Runs one case."""
    times = np.arange(round(STOP / STEP)) * STEP
    run = ps.Model("PneumaticServoCylinder").simulate(
        {"friction.law": case.law, "valve.deadZone": case.dead_zone, "valve.C": case.conductance},
        inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * times))},
        stop=STOP,
        step=STEP,
        outputs=["position", "velocity", "frictionForce", "solver.steps"],
    )
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
