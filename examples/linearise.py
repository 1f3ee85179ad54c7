"""Linearises the plant at an operating point, for controller design, with nothing but the FMU.

    dx/dt = A x + B u,   y = C x + D u

The matrices are directional derivatives of the FMU (exact, by differentiating its code) with respect to its continuous
states and inputs; they are checked against differences of short simulations.

While a set-valued law sticks, the plant that is linearised is the stuck one: position and velocity do not react. Within
the play of the valve's hysteresis the spool does not react to the voltage, so the example takes a valve without it.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "packaging" / "python"))
from client import Client  # noqa: E402

INPUTS = ["valveVoltage", "externalForce", "supplyPressure"]
OUTPUTS = ["position", "velocity", "acceleration", "chamberA.pressure", "chamberB.pressure"]
STEP = 1e-6
"""Length of the simulations for the check, in s: short enough for a difference, long enough for its rounding."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, nargs="?", default=Path("target/fmu/PneumaticServoCylinder.fmu"))
    with Client(parser.parse_args().fmu) as plant:
        states, derivatives = states_of(plant)
        move_to_operating_point(plant)
        a = jacobian(plant, derivatives, states)
        b = jacobian(plant, derivatives, INPUTS)
        c = jacobian(plant, OUTPUTS, states)
        d = jacobian(plant, OUTPUTS, INPUTS)
        print("operating point:", dict(zip(states, np.round(plant.get(states), 6), strict=True)))
        for name, matrix in [("A", a), ("B", b), ("C", c), ("D", d)]:
            print(f"{name} =\n{np.array2string(matrix, precision=4, suppress_small=False, max_line_width=160)}")
        worst = max(check_inputs(plant, derivatives, b), check_states(plant, derivatives, a))
        print(f"largest relative deviation from differences of simulations: {worst:.1e}")
        eigenvalues = np.sort_complex(np.linalg.eigvals(a))
        print("eigenvalues of A (1/s):", np.array2string(eigenvalues, precision=3))
        return 0 if worst < 1e-3 else 1


def states_of(plant: Client) -> tuple[list[str], list[str]]:
    """Names of the states that take part under the default law and rig, and of their derivatives."""
    variables = plant.description.modelVariables
    pairs = [(v.derivative.name, v.name) for v in variables if v.derivative is not None]
    pairs = [(state, rate) for state, rate in pairs if not state.startswith(("friction.state", "regulator."))]
    return [state for state, _ in pairs], [rate for _, rate in pairs]


def move_to_operating_point(plant: Client) -> None:
    """Slow outstroke with pressures in balance."""
    start = {"valveVoltage": 6.0, "position0": 0.05, "valve.hysteresis": 0.0, "solver.relativeTolerance": 1e-10}
    plant.start(start)
    while plant.time < 0.8:
        plant.advance(plant.time + 1e-3)


def jacobian(plant: Client, unknowns: list[str], knowns: list[str]) -> np.ndarray:
    """Partial derivatives of the unknowns (rows) with respect to the knowns (columns)."""
    rows = [plant.variables[name].valueReference for name in unknowns]
    columns = [plant.variables[name].valueReference for name in knowns]
    return np.array([plant.slave.getDirectionalDerivative(rows, [column], [1.0]) for column in columns]).T


def check_inputs(plant: Client, derivatives: list[str], b: np.ndarray) -> float:
    """Compares B with the change of the derivatives under small changes of each input."""
    worst = 0.0
    for column, (name, change) in enumerate(zip(INPUTS, [1e-5, 1e-3, 10.0], strict=True)):
        before, [value] = np.array(plant.get(derivatives)), plant.get([name])
        plant.set({name: value + change})
        measured = (np.array(plant.get(derivatives)) - before) / change
        plant.set({name: value})
        scale = np.max(np.abs(b[:, column]))
        worst = max(worst, float(np.max(np.abs(measured - b[:, column])) / scale))
    return worst


def check_states(plant: Client, derivatives: list[str], a: np.ndarray) -> float:
    """Compares A times the motion of a short simulation with the change of the derivatives over it.

    Along the solution with constant inputs, d(dx/dt)/dt = A dx/dt: one direction of A, in which all states take part.
    """
    before = np.array(plant.get(derivatives))
    predicted = a @ before
    plant.advance(plant.time + STEP)
    after = np.array(plant.get(derivatives))
    measured = (after - before) / STEP
    scale = np.abs(a) @ np.abs(before) + 1e-9
    return float(np.max(np.abs(measured - predicted) / scale))


if __name__ == "__main__":
    sys.exit(main())
