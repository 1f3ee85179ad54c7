"""Plans a move from rest to rest through stiction, by L-BFGS on 500 voltages with the exact gradient of the run.

Nothing is smoothed: the friction law is Stribeck, which sticks and slips, and the gradient comes from `Run.vjp`.
Beside it Powell's method, which needs no derivatives, with as many runs as it is given. The valve has no play: a
voltage that rests in it has no derivative.

Needs pneumatic_servo, scipy and matplotlib.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from numpy.typing import NDArray
from pneumatic_servo import figures
from scipy.optimize import minimize

START, END, STEPS, STEP = 0.2, 0.25, 500, 1e-3
PARAMETERS = {"position0": START, "valve.hysteresis": 0.0, "solver.relativeTolerance": 1e-6}
WATCHED = ["position", "velocity", "sticking"]
LENGTH, SPEED, TURN = 1e-3, 1e-2, 0.3
"""Scales of equal cost: a millimetre off, 1 cm/s at the end, a change of the voltage by 0.3 V from step to step."""


class Move:
    """A move, its cost and the runs that it has taken."""

    def __init__(self) -> None:
        self.plant, self.runs = ps.Model(), 0

    def run(self, voltage: NDArray) -> ps.Run:
        self.runs += 1
        times = STEP * np.arange(STEPS)
        inputs = {"valveVoltage": (times, voltage)}
        return self.plant.simulate(PARAMETERS, inputs=inputs, stop=STEPS * STEP, step=STEP, outputs=WATCHED)

    def judged(self, voltage: NDArray) -> tuple[float, ps.Run, NDArray]:
        run, turns = self.run(voltage), np.diff(voltage) / TURN
        off, speed = (run["position"][-1] - END) / LENGTH, run["velocity"][-1] / SPEED
        return float(off**2 + speed**2 + np.sum(turns**2)), run, np.array([off / LENGTH, speed / SPEED])

    def gradient(self, voltage: NDArray) -> tuple[float, NDArray]:
        cost, run, off = self.judged(voltage)
        weights = np.zeros((2, STEPS + 1))
        weights[:, -1] = 2.0 * off
        slopes = run.vjp(dict(zip(WATCHED, weights, strict=False))).inputs["valveVoltage"]
        bends = np.diff(voltage, prepend=voltage[0], append=voltage[-1])
        return cost, slopes - 2.0 * np.diff(bends) / TURN**2


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path, help="where to draw")
    parser.add_argument("--runs", type=int, default=300, help="runs of Powell's method")
    arguments = parser.parse_args()
    first = 5.0 + 1.2 * np.sin(2.0 * np.pi * np.arange(STEPS) / STEPS)
    move, other = Move(), Move()
    found = minimize(
        move.gradient, first, jac=True, method="L-BFGS-B", bounds=[(0.1, 9.9)] * STEPS, options={"maxiter": 40}
    )
    powell = minimize(lambda u: other.judged(u)[0], first, method="Powell", options={"maxfev": arguments.runs})
    runs = {"start": move.run(first), "L-BFGS": move.run(found.x), "Powell": other.run(powell.x)}
    print(
        f"L-BFGS: cost {found.fun:.3g} after {found.nfev} gradients; Powell: {powell.fun:.3g} after {powell.nfev} runs"
    )
    for name, run in runs.items():
        print(f"{name}: ends {1e3 * (run['position'][-1] - END):+.3f} mm off at {1e3 * run['velocity'][-1]:+.2f} mm/s")
    if arguments.figure:
        plt.rcParams.update(figures.STYLE | {"axes.prop_cycle": figures.CYCLE})
        figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
        for (name, run), voltage in zip(runs.items(), (first, found.x, powell.x), strict=True):
            top.plot(run.time, 1e3 * run["position"], label=name)
            bottom.step(run.time[:-1], voltage, where="post")
        top.axhline(1e3 * END, color="0.7", linewidth=0.8)
        top.set_ylabel("position (mm)"), top.legend()
        bottom.set_ylabel("valve voltage (V)"), bottom.set_xlabel("time (s)")
        figure.savefig(arguments.figure, dpi=110)
    return 0 if abs(runs["L-BFGS"]["position"][-1] - END) < 1e-4 and found.fun < 0.1 * powell.fun else 1


if __name__ == "__main__":
    sys.exit(main())
