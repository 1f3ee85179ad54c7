"""Error and cost of a run by the tolerance that is asked for.

The cylinder runs its default experiment (5 +- 2 V, 1 Hz, communication steps of 1 ms) at tolerances from 1e-3 to 1e-9,
four in each decade, under six friction laws. Errors are those against a run at a tolerance of 1e-11: the largest one of
the position, the rms of the friction force. A table and a figure are left in a folder; for each law the slope in
log-log is printed and the largest jump from one tolerance to the next.

Usage: python docs/studies/tolerance_ladder.py [--output FOLDER]
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

LAWS: dict[str, dict[str, float | str]] = {
    "Stribeck": {"friction.law": "Stribeck"},
    "Polito": {"friction.law": "Polito"},
    "Dahl": {"friction.law": "Dahl"},
    "LuGre": {"friction.law": "LuGre"},
    "ElastoPlastic": {"friction.law": "ElastoPlastic"},
    "LuGre, stiff": {
        "friction.law": "LuGre",
        "friction.lugre.sigma0": 8e6,
        "friction.lugre.sigma1": 500.0,
        "friction.lugre.vd": 1e3,
    },
}
TOLERANCES = 10.0 ** np.linspace(-3.0, -9.0, 25)
REFERENCE = 1e-11
STOP, STEP = 3.0, 1e-3


@dataclass(frozen=True)
class Rung:
    """A run at a tolerance: its errors against the reference, and what it took."""

    tolerance: float
    position: float
    """Largest error of the position in m."""
    friction: float
    """Error of the friction force in N, rms."""
    steps: int
    """Solver steps, rejected ones among them."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("target/studies"), help="folder of the results")
    folder: Path = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    ladders = {law: ladder(settings) for law, settings in LAWS.items()}
    write(ladders, folder / "tolerance_ladder.csv")
    draw(ladders, folder / "tolerance_ladder.png")
    print(f"{'law':<16}{'slope: position':>17}{'friction':>10}{'largest jump: position':>24}{'friction':>10}")
    for law, rungs in ladders.items():
        position, friction = column(rungs, "position"), column(rungs, "friction")
        slopes = f"{slope(position):>17.2f}{slope(friction):>10.2f}"
        print(f"{law:<16}{slopes}{largest_jump(position):>24.1f}{largest_jump(friction):>10.1f}")
    print(f"results and figure: {folder}")
    return 0


def ladder(settings: dict[str, float | str]) -> list[Rung]:
    """The runs under a law, with what they lack beside the reference."""
    exact, _ = simulate(settings, REFERENCE)
    rungs = []
    for tolerance in TOLERANCES:
        rows, steps = simulate(settings, tolerance)
        difference = rows - exact
        position = float(np.abs(difference[:, 0]).max())
        friction = float(np.sqrt(np.mean(difference[:, 1] ** 2)))
        rungs.append(Rung(float(tolerance), position, friction, steps))
    return rungs


def simulate(settings: dict[str, float | str], tolerance: float) -> tuple[np.ndarray, int]:
    """Position in m and friction force in N at the communication points, shape (points, 2), and the solver steps."""
    times = np.arange(round(STOP / STEP)) * STEP
    run = ps.Model("PneumaticServoCylinder").simulate(
        {**settings, "solver.relativeTolerance": tolerance},
        inputs={"valveVoltage": (times, 5.0 + 2.0 * np.sin(2.0 * np.pi * times))},
        stop=STOP,
        step=STEP,
        outputs=["position", "frictionForce", "solver.steps", "solver.rejectedSteps"],
    )
    rows = np.column_stack([run["position"], run["frictionForce"]])
    return rows, int(run["solver.steps"][-1] + run["solver.rejectedSteps"][-1])


def column(rungs: list[Rung], name: str) -> np.ndarray:
    return np.array([getattr(rung, name) for rung in rungs])


def slope(errors: np.ndarray) -> float:
    """The slope of the line through errors against tolerances in log-log."""
    return float(np.polyfit(np.log10(TOLERANCES), np.log10(errors), 1)[0])


def largest_jump(errors: np.ndarray) -> float:
    """The largest ratio of errors at neighbouring tolerances, whichever is the larger."""
    return float(np.exp(np.abs(np.diff(np.log(errors))).max()))


def write(ladders: dict[str, list[Rung]], file: Path) -> None:
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["law", "tolerance", "position error (m)", "friction force error, rms (N)", "solver steps"])
        for law, rungs in ladders.items():
            for rung in rungs:
                errors = [f"{rung.position:.3g}", f"{rung.friction:.3g}"]
                table.writerow([law, f"{rung.tolerance:.3g}", *errors, rung.steps])


def draw(ladders: dict[str, list[Rung]], file: Path) -> None:
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 3, figsize=(9.0, 5.4), sharex=True, sharey=True, layout="constrained")
        for axis, (law, rungs) in zip(axes.flat, ladders.items(), strict=True):
            position, friction = column(rungs, "position"), column(rungs, "friction")
            axis.loglog(TOLERANCES, position / 1e-6, "o-", color=BLUE, markersize=3, label="position (µm)")
            axis.loglog(TOLERANCES, friction / 1e-3, "s-", color=VERMILION, markersize=3, label="friction, rms (mN)")
            axis.loglog(TOLERANCES, TOLERANCES / 1e-6, "--", color=GREY, label="in proportion")
            axis.set_title(law)
        for axis in axes[1]:
            axis.set_xlabel("relative tolerance")
        for axis in axes[:, 0]:
            axis.set_ylabel("error")
        axes[0, 0].legend()
        figure.savefig(file)
        plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
