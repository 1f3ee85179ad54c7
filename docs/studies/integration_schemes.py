"""Compares the fixed-step schemes with the adaptive one: with the law LuGre explicit Euler needs 10 us where implicit
Euler is content with 1 ms.

The cylinder runs its default experiment (5 +- 2 V, 1 Hz) under every scheme and step size; a table and a figure are
left in a folder. A step that a scheme cannot complete ends its run with an error, never with numbers of no meaning.

Usage: python docs/studies/integration_schemes.py [--output FOLDER]
"""

from __future__ import annotations

import argparse
import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from pneumatic_servo.figures import BLUE, GREY, STYLE, VERMILION

LAW = "LuGre"
BRISTLE = {"friction.lugre.sigma0": 1e4, "friction.lugre.sigma1": 2500.0, "friction.lugre.vd": 1e3}
"""The strongly damped bristle of the set TransitionLuGre."""
STOP, STEP = 3.0, 1e-3
SCHEMES = ["ExplicitEuler", "ImplicitEuler", "RK3", "RK4"]
SIZES = [1e-3, 1e-4, 1e-5]
SIGNALS = ["position", "frictionForce"]


@dataclass(frozen=True)
class Run:
    """A run of the experiment, up to its end or to where the scheme gave up."""

    scheme: str
    size: float
    rows: np.ndarray
    """Position and friction force at the communication points."""

    @property
    def is_complete(self) -> bool:
        return len(self.rows) == round(STOP / STEP) + 1

    def deviations(self, reference: Run) -> np.ndarray:
        """The largest deviation of each signal from another run, as far as this one goes."""
        return np.abs(self.rows - reference.rows[: len(self.rows)]).max(axis=0)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("target/studies"), help="folder of the results")
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    reference = simulate("Adaptive", SIZES[0])
    runs = [simulate(scheme, size) for scheme in SCHEMES for size in SIZES]
    write(runs, reference, folder / "integration_schemes.csv")
    draw(runs, reference, folder / "integration_schemes.png")
    print(f"results and figure: {folder}")
    return 0


def simulate(scheme: str, size: float) -> Run:
    """Runs the experiment under a scheme."""
    times = np.arange(round(STOP / STEP)) * STEP
    try:
        run = ps.Model("PneumaticServoCylinder").simulate(
            {"friction.law": LAW, **BRISTLE, "solver.scheme": scheme, "solver.step": size},
            inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * times))},
            stop=STOP,
            step=STEP,
            outputs=SIGNALS,
        )
    except ps.SimulationError as error:
        print(f"{scheme} at {size:g} s: {error}")
        if not isinstance(error.finished, ps.Run):
            raise
        run = error.finished
    return Run(scheme, size, np.column_stack([run[name] for name in SIGNALS]))


def write(runs: list[Run], reference: Run, file: Path) -> None:
    """One row per run; also printed."""
    header = ["scheme", "step (s)", "reached (s)", "position deviation (m)", "friction deviation (N)"]
    print("  ".join(f"{title:>22}" for title in header))
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        for run in runs:
            reached = (len(run.rows) - 1) * STEP
            deviations = run.deviations(reference) if run.is_complete else ["", ""]
            row = [run.scheme, run.size, round(reached, 6), *deviations]
            writer.writerow(row)
            print("  ".join(f"{cell:>22.3g}" if isinstance(cell, float) else f"{cell or '-':>22}" for cell in row))


def draw(runs: list[Run], reference: Run, file: Path) -> None:
    """Position under both Euler schemes at the largest and the smallest step, over the adaptive scheme."""
    panels = [("ExplicitEuler", SIZES[-1]), ("ExplicitEuler", SIZES[0]), ("ImplicitEuler", SIZES[0])]
    chosen = {(run.scheme, run.size): run for run in runs}
    times = np.arange(len(reference.rows)) * STEP
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, len(panels), figsize=(11, 3), sharey=True, layout="constrained")
        for axis, panel in zip(axes, panels, strict=True):
            run = chosen[panel]
            axis.plot(times, 1e3 * reference.rows[:, 0], color=GREY, linewidth=2.5, alpha=0.4, label="adaptive")
            colour = BLUE if run.is_complete else VERMILION
            axis.plot(times[: len(run.rows)], 1e3 * run.rows[:, 0], color=colour, label="fixed step")
            if not run.is_complete:
                axis.plot(times[len(run.rows) - 1], 1e3 * run.rows[-1, 0], "x", color=colour, label="gives up")
            axis.set_title(f"{run.scheme}, {1e3 * run.size:g} ms")
            axis.set_xlabel("time (s)")
            axis.legend()
        axes[0].set_ylabel("position (mm)")
        figure.savefig(file)
        plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
