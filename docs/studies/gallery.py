"""Runs the default experiment of FMUs under every friction law.

Leaves a CSV and a figure per law in a folder per model, and one figure of all laws. It needs FMPy and the package.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "packaging" / "python"))

import matplotlib as mpl
import numpy as np
import pneumatic_servo as ps
from common import ROOT
from experiment import EXPERIMENTS, LAW, Run, laws_of, timed, write_csv
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from pneumatic_servo import figures

STYLE = figures.STYLE | {"figure.dpi": 150, "font.size": 9, "axes.titlelocation": "left"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", type=Path, nargs="*", metavar="FMU", help="default: the package's")
    parser.add_argument("--laws", nargs="+", help="some laws only")
    parser.add_argument("--output", type=Path, default=ROOT / "target" / "gallery", help="where the folders are made")
    arguments = parser.parse_args()
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as processes:
        for fmu in arguments.fmus or [file for file in ps.fmus() if file.suffix == ".fmu"]:
            run_every_law(fmu, arguments.output / fmu.stem, arguments.laws, processes)
    return 0


def run_every_law(fmu: Path, folder: Path, wanted: Sequence[str] | None, processes: Executor) -> None:
    laws = [law for law in laws_of(fmu) if not law or wanted is None or law in wanted]
    runs = list(processes.map(run_law, repeat(fmu), laws, repeat(folder)))
    if len(runs) > 1:
        draw_overview(runs, folder / "laws.png")


def run_law(fmu: Path, law: str, folder: Path) -> Run:
    """Leaves a CSV and a figure of a law."""
    run = timed(fmu, law)
    write_csv(run, folder / f"{law or run.model}.csv")
    draw_run(run, folder / f"{law or run.model}.png")
    return run


def draw_run(run: Run, file: Path) -> None:
    """Everything about one run: curves over time on the left, friction (if any) against velocity on the right."""
    recorded = in_package(run)
    # The plant lists the curve that is looked at last.
    panels = [(panel["label"], panel["curves"][::-1]) for panel in EXPERIMENTS[run.model]["panels"]]
    with mpl.rc_context(STYLE):
        if figures.contact(recorded.variables):
            figure = Figure(figsize=(12, 8), layout="constrained")
            left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1))
            figures.draw_panels(left, recorded, panels)
            whole, near = right.subplots(2, 1)
            figures.draw_contact(whole, recorded)
            figures.draw_standstill(near, recorded)
            right.align_ylabels([whole, near])
        else:
            figure = Figure(figsize=(9, 7), layout="constrained")
            figures.draw_panels(figure, recorded, panels)
        figure.suptitle(title(run), fontsize=12, fontweight="bold", x=0.01, ha="left")
        figure.savefig(file, metadata={"Software": None})


def draw_overview(runs: Sequence[Run], file: Path) -> None:
    """Friction against velocity under every law with friction; each on its own axes, so that none squeezes others."""
    recorded = {run.law: in_package(run) for run in runs}
    _, force = figures.contact(next(iter(recorded.values())).variables) or ("", "")
    recorded = {law: run for law, run in recorded.items() if np.any(run[force] != 0.0)}
    columns = 4
    rows = -(-len(recorded) // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12, 2.7 * rows), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        for axis, (law, run) in zip(grid.flat, recorded.items(), strict=False):
            figures.draw_contact(axis, run)
            axis.set_title(law)
            axis.xaxis.set_major_locator(MaxNLocator(4))
        figure.supxlabel(grid[0, 0].get_xlabel(), fontsize=9)
        figure.supylabel(grid[0, 0].get_ylabel(), fontsize=9)
        for axis in grid.flat:
            axis.set(xlabel="", ylabel="")
        for axis in list(grid.flat)[len(recorded) :]:
            axis.set_visible(False)
        figure.suptitle(
            f"{runs[0].model}: friction force against velocity in the default experiment (dots: samples far apart)",
            fontsize=12,
            fontweight="bold",
        )
        figure.savefig(file, metadata={"Software": None})


def in_package(run: Run) -> ps.Run:
    """A run of an FMU as one of the package, with its units."""
    table = ps.Model(run.model).variables
    names = [name for name in run.columns if name != "time"]
    variables = ps.Variables(table[name] for name in names)
    values = np.array([run.columns[name] for name in names])
    return ps.Run(run.columns["time"], values, variables, {LAW: run.law} if run.law else {})


def title(run: Run) -> str:
    text = f"{run.model}, friction law {run.law}" if run.law else run.model
    return f"{text} (shaded: sticking)" if np.any(run.columns.get("sticking", np.zeros(1)) > 0.5) else text


if __name__ == "__main__":
    sys.exit(main())
