"""Linearises the plant at an operating point, for controller design, and checks the matrices.

    dx/dt = A x + B u,   y = C x + D u

The matrices are exact derivatives of the equations (their code is differentiated); they are checked against
differences. The operating point is a slow outstroke with everything else in balance. The valve is one without
hysteresis: within its play the spool does not react to the voltage, and a carriage that sticks does not react either.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
import pneumatic_servo as ps

INPUTS = ["valveVoltage", "externalForce", "supplyPressure"]
OUTPUTS = ["position", "velocity", "acceleration", "chamberA.pressure", "chamberB.pressure"]
AT: dict[str, ps.Value] = {"velocity": 0.1, "externalForce": 0.0, "supplyPressure": 5e5, "valve.hysteresis": 0.0}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args()
    plant = ps.Model("PneumaticServoCylinder")
    found = plant.linearise(at=AT, inputs=INPUTS, outputs=OUTPUTS)
    print(found)
    print("eigenvalues of A (1/s):", np.array2string(np.sort_complex(np.linalg.eigvals(found.A)), precision=3))
    worst = check_inputs(plant, found)
    print(f"largest relative deviation of B from differences: {worst:.1e}")
    return 0 if worst < 1e-3 else 1


def check_inputs(model: ps.Model, found: ps.Linearisation) -> float:
    """Compares B with the change of the derivatives under small changes of each input."""
    plant = model.start({"velocity0": 0.1, "valve.hysteresis": 0.0})
    plant.move_states(dict(zip(found.states, found.x.tolist(), strict=True)))
    plant.set(dict(zip(found.inputs, found.u.tolist(), strict=True)))
    rates = [next(v.name for v in model.variables.values() if v.derivative_of == state) for state in found.states]
    worst = 0.0
    for column, (name, change) in enumerate(zip(INPUTS, [1e-5, 1e-3, 10.0], strict=True)):
        before, value = plant.get(rates), plant[name]
        plant[name] = value + change
        measured = (plant.get(rates) - before) / change
        plant[name] = value
        scale = np.max(np.abs(found.B[:, column]))
        worst = max(worst, float(np.max(np.abs(measured - found.B[:, column])) / scale))
    return worst


if __name__ == "__main__":
    sys.exit(main())
