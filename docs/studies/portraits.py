"""Portraits of a friction law on the bench: steady curve, presliding loops, stick-slip on a soft spring."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import pneumatic_servo as ps
from matplotlib.axes import Axes
from numpy.typing import NDArray
from pneumatic_servo.figures import BLUE, GREEN, GREY, VERMILION

LAW = "friction.law"
BENCH = "FrictionBench"
SOFT = {"spring.stiffness": 1000.0}
"""The spring through which the mass is drawn."""

SPEEDS = np.geomspace(1e-4, 0.1, 16)
"""Speeds of the steady curve in m/s."""

TURNS = [0.0, 7.0, -7.0, 7.0, 2.0, 6.0, -7.0]
"""Quasi-static load of the presliding loops in N, from one turning point to the next: an outer and an inner loop."""

NOTHING = 1e-12
"""A displacement in m below which nothing has moved."""

Rows = NDArray[np.float64]


def steady_curve(law: str) -> Rows:
    """Friction after 5 mm or 0.3 s at constant speed, whichever is longer; rows of velocity in m/s and force in N."""
    return np.array([(velocity, steady_force(law, velocity)) for velocity in [*-SPEEDS[::-1], *SPEEDS]])


def steady_force(law: str, velocity: float) -> float:
    bench = ps.Model(BENCH).start({LAW: law, "bench.drive": "PrescribedMotion", "driveVelocity": velocity})
    bench.step(max(0.3, 5e-3 / abs(velocity)))
    # A law with noise or samples has no single value: the mean of ten points shows its level.
    forces = []
    for _ in range(10):
        bench.step(1e-3)
        forces.append(bench["frictionForce"])
    return float(np.mean(forces))


def presliding(law: str, per_turn: int = 60, interval: float = 5e-3) -> Rows:
    """A free mass under a slowly varying load below break-away; rows of displacement in m and load in N."""
    bench = ps.Model(BENCH).start({LAW: law, "bench.drive": "Free", "driveVelocity": 0.0})
    rows = []
    for load in loads(per_turn):
        bench["appliedForce"] = load
        bench.step(interval)
        rows.append((bench["position"], load))
    return np.array(rows)


def loads(per_turn: int) -> Iterable[float]:
    return np.concatenate([np.linspace(begin, end, per_turn, endpoint=False) for begin, end in pairwise(TURNS)])


def stick_slip(law: str) -> ps.Run:
    """A mass drawn by a soft spring at 10 mm/s."""
    return ps.Model(BENCH).simulate({LAW: law, **SOFT, "driveVelocity": 0.01}, stop=3.0, step=1e-2)


def draw_steady(axis: Axes, rows: Rows) -> None:
    axis.axhline(0, color=GREY, linewidth=0.6)
    for half in np.split(rows, 2):
        axis.plot(1e3 * half[:, 0], half[:, 1], ".-", color=GREEN, markersize=5)
    axis.set_xscale("symlog", linthresh=0.1)
    axis.set_xticks([-100, -1, 0, 1, 100], labels=["-100", "-1", "0", "1", "100"])
    axis.set(ylim=(-14, 14), xlabel="Velocity in mm/s", ylabel="Friction in N")


def draw_presliding(axis: Axes, rows: Rows) -> None:
    displacement, load = rows.T
    axis.plot(1e6 * displacement, load, color=VERMILION)
    if np.ptp(displacement) < NOTHING:
        axis.set_xlim(-1, 1)
        axis.text(0.05, 0.9, "does not move", transform=axis.transAxes, color=GREY)
    axis.set(xlabel="Displacement in µm", ylabel="Load in N")


def draw_stick_slip(axis: Axes, run: ps.Run) -> None:
    axis.plot(run.time, 1e3 * run["drivePosition"], "--", color=GREY, label="drive")
    axis.plot(run.time, 1e3 * run["position"], color=BLUE, label="mass")
    axis.set(xlabel="Time in s", ylabel="Position in mm")
