"""The cylinder with the arm of examples/mujoco_arm.py as one system, integrated from event to event.

    python arm.py       writes arm.csv: position and sticking each 10 ms

The carriage at ``x`` holds the arm at the angle ``q = asin((x - middle)/radius)``. By Lagrange, with ``I`` the inertia
about the hinge and ``V(q)`` the potential energy, the arm adds ``I*q'^2`` to the mass and ``-I*q'*q''*v^2 - q'*dV/dq``
to the force.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

from gas import Gas
from plant import GRAVITY, Inputs, Plant
from simulation import Run, configure

FILE = Path(__file__).resolve().parent / "arm.csv"
RADIUS, MIDDLE, OUT, UP, LOAD = 0.3, 0.25, 0.35, 0.2, 1.5
INERTIA = LOAD * (OUT**2 + UP**2) + 1e-9
SETTINGS = {"chamberA.pressure0": 4e5, "chamberB.pressure0": 3e5, "position0": 0.2}
SUPPLY, STEP, DURATION, TOLERANCE = 6e5, 1e-3, 2.4, 1e-9


class WithArm(Plant):
    """The plant whose carriage carries the arm."""

    def inertia(self, x: float) -> float:
        _, slope, _ = _angle(x)
        return self.mass + INERTIA * slope**2

    def applied_force(self, x: float, v: float, a: Gas, b: Gas, external_force: float) -> float:
        angle, slope, bend = _angle(x)
        weight = LOAD * GRAVITY * (OUT * math.cos(angle) - UP * math.sin(angle))
        of_arm = -slope * weight - INERTIA * slope * bend * v**2
        return super().applied_force(x, v, a, b, external_force) + of_arm


def _angle(x: float) -> tuple[float, float, float]:
    sine = (x - MIDDLE) / RADIUS
    cosine = math.sqrt(1.0 - sine**2)
    return math.asin(sine), 1.0 / (RADIUS * cosine), sine / (RADIUS**2 * cosine**3)


def lift() -> list[tuple[float, float, int]]:
    """Time, position and whether the carriage sticks, at the end of each tenth step."""
    plant, law = configure(SETTINGS)
    run = Run(WithArm(plant), law, TOLERANCE)
    rows = []
    for k in range(round(DURATION / STEP)):
        time = k * STEP
        voltage = 5.46 if time < 1.6 else 6.5 if time < 1.9 else 4.2
        run.sample(Inputs(voltage, 0.0, SUPPLY), time)
        if k == 0:
            run.start()
        run.advance(STEP)
        if (k + 1) % 10 == 0:
            row = run.row(time + STEP)
            rows.append((row.time, row.position, row.sticking))
    return rows


if __name__ == "__main__":
    with FILE.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["time", "position", "sticking"])
        writer.writerows((time, f"{position:.12g}", sticking) for time, position, sticking in lift())
