"""Finds the fastest move from rest to rest through stick and slip, by L-BFGS on 500 voltages with the exact gradient.

L-BFGS finds the farthest move in a given time, and Newton's method the time in which that is far enough. Behind it the
valve closes, and the carriage stays. Beside it Nelder and Mead's method, without gradient, on 20 voltages and the time.

Needs pneumatic_servo, scipy and matplotlib.
"""

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pneumatic_servo as ps
from numpy.typing import NDArray
from pneumatic_servo import figures
from scipy.optimize import minimize, root_scalar

START, END, STEPS, REST, LOW, HIGH = 0.2, 0.25, 500, 100, 0.1, 9.9
PARAMETERS = {"position0": START, "valve.hysteresis": 0.0, "solver.relativeTolerance": 1e-6}
PLANT, LAST = ps.Model(), [("position", -1), ("velocity", STEPS), ("pressureForce", STEPS), ("pressureForce", -1)]
HELD, UNITS = 8.0, np.array([1e-3, 2e-2, 5.0, 5.0])
"""Force in N that friction holds with some reserve; m off, m/s at the end and N beyond the force that count as much."""


def run(time: float, voltage: NDArray) -> ps.Run:
    """A move in a time in ms, behind which the valve closes."""
    step, held = 1e-3 * time / STEPS, np.append(np.repeat(voltage, STEPS // len(voltage)), np.full(REST, 5.0))
    inputs, outputs = {"valveVoltage": (step * np.arange(len(held)), held)}, list(dict(LAST))
    return PLANT.simulate(PARAMETERS, inputs=inputs, stop=step * len(held), step=step, outputs=outputs)


def missed(made: ps.Run) -> NDArray:
    position, speed, *forces = (made[name][row] for name, row in LAST)
    return np.array([position - END, speed, *(force - np.clip(force, -HELD, HELD) for force in forces)]) / UNITS


def worth(off: NDArray) -> float:
    """The farther the better; speed and forces count by their squares."""
    return float(off[0] - off[1:] @ off[1:])


def cost(voltage: NDArray, time: float) -> tuple[float, NDArray]:
    made = run(time, voltage)
    off, weights = missed(made), {name: np.zeros(len(made.time)) for name, _ in LAST}
    for (name, row), slope in zip(LAST, np.append(-1.0, 2.0 * off[1:]) / UNITS, strict=True):
        weights[name][row] = slope
    return -worth(off), made.vjp(weights).inputs["valveVoltage"][:STEPS]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path, help="where to draw")
    parser.add_argument("--runs", type=int, default=10000, help="runs of Nelder and Mead's method")
    arguments = parser.parse_args()
    levels, time, gradients = np.repeat([HIGH, LOW, HIGH], [12, 6, 2]), 120.0, 0
    voltage, options = np.repeat(levels, STEPS // 20), {"maxfun": 30, "maxcor": 20}
    for UNITS[1] in (2e-2, 2e-2, 1e-2):
        found = minimize(cost, voltage, (time,), "L-BFGS-B", jac=True, bounds=[(LOW, HIGH)] * STEPS, options=options)
        voltage, gradients = found.x, gradients + found.nfev
        off, later, sooner = (missed(run(time * share, voltage)) for share in (1.0, 1.001, 0.999))
        time -= off[0] / (worth(later) - worth(sooner)) * 2e-3 * time
    time = root_scalar(lambda time: missed(run(time, voltage))[0], x0=time, x1=1.001 * time).root
    held = lambda plan: np.clip(plan[1:], LOW, HIGH)  # noqa: E731
    judged = lambda plan: plan[0] + np.sum((missed(run(plan[0], held(plan))) * [10, 1, 1, 1]) ** 2)  # noqa: E731
    options = {"maxfev": arguments.runs, "adaptive": True}
    other = minimize(judged, np.append(120.0, levels), method="Nelder-Mead", options=options).x
    plans = {"start": (120.0, levels), "L-BFGS": (time, voltage), "Nelder-Mead": (other[0], held(other))}
    print(f"L-BFGS: {time:.2f} ms, {gradients} gradients; Nelder-Mead: {other[0]:.2f} ms, {arguments.runs} runs")
    plt.rcParams.update(figures.STYLE | {"axes.prop_cycle": figures.CYCLE})
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
    for name, plan in plans.items():
        made = run(*plan)
        off = 1e6 * (made["position"][STEPS:] - END)
        print(f"{name}: {off[0]:+.1f} um off at its end, {off[-1]:+.1f} um behind it")
        top.plot(1e3 * made.time, 1e3 * made["position"], label=name)
        bottom.stairs(plan[1], np.linspace(0.0, plan[0], len(plan[1]) + 1), baseline=None)
    top.axhline(1e3 * END, color="0.7", linewidth=0.8)
    top.set_ylabel("position (mm)"), top.legend()
    bottom.set_ylabel("valve voltage (V)"), bottom.set_xlabel("time (ms)")
    if arguments.figure:
        figure.savefig(arguments.figure, dpi=110)
    return 0 if np.abs(missed(run(time, voltage))[:2]).max() < 0.1 and time < other[0] else 1


if __name__ == "__main__":
    sys.exit(main())
