"""State feedback for the cylinder: designed with python-control on the linearised plant, run on the nonlinear one.

The plant is linearised while it slides slowly, with nothing else moving. Position, velocity and acceleration are its
states for the design; the spool, which is ten times faster, is the input. Outside the design the valve's dead zone is
jumped over, and run and design may have different friction laws.

Usage: python examples/state_feedback.py [--law LuGre] [--plot state_feedback.png]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import control
import numpy as np
import pneumatic_servo as ps
from numpy.typing import NDArray

PERIOD = 1e-3
TARGET, START = 0.30, 0.20
STATES = ["position", "velocity", "chamberA.pressure", "chamberB.pressure"]
PLANT: dict[str, ps.Value] = {"supplyPressure": 6e5}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", default="LuGre", help="friction law of the run")
    parser.add_argument("--plot", type=Path, help="figure to write")
    options = parser.parse_args()
    model = ps.Model("PneumaticServoCylinder")
    gains, poles = design(model)
    print("gains on error, velocity, acceleration:", np.array2string(gains, precision=4))
    print("poles of the closed loop (1/s):", np.array2string(poles, precision=1))
    run = simulate(model, gains, options.law)
    error = 1e3 * (TARGET - run["position"])
    late = error[run.time > 1.0]
    print(f"law {options.law}: within {np.abs(late).max():.2f} mm after 1 s, overshoot {max(0.0, -error.min()):.2f} mm")
    if options.plot:
        run.plot("valveVoltage", "position", "velocity").savefig(options.plot)
    return 0 if np.abs(late).max() < 3.0 else 1


def design(model: ps.Model) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """The gains of a linear-quadratic regulator on the spool, and the poles they lead to."""
    full = model.linearise(at=PLANT | {"velocity": 0.05, "valve.hysteresis": 0.0})
    kept = [full.states.index(name) for name in STATES]
    a, b = full.A[np.ix_(kept, kept)], full.A[kept, full.states.index("valve.spool")]
    # Position, velocity and acceleration in place of the two pressures, whose mean moves nothing.
    to_motion = np.vstack([np.eye(2, 4), a[1]])
    a3, b3 = to_motion @ a @ np.linalg.pinv(to_motion), (to_motion @ b)[:, None]
    # An error of 1 mm, 0.1 m/s and 10 m/s2 weigh as much as a tenth of the spool's travel.
    gains, _, poles = control.lqr(a3, b3, np.diag(np.array([1e-3, 0.1, 10.0]) ** -2.0), np.array([[0.1**-2.0]]))
    return np.asarray(gains)[0], np.asarray(poles)


def simulate(model: ps.Model, gains: NDArray[np.float64], law: str) -> ps.Run:
    """Closes the loop around the nonlinear plant for 2 s."""
    plant = model.start(PLANT | {"friction.law": law, "position0": START})
    dead_zone = float(model.parameters["valve.deadZone"].default or 0.0)
    voltages = []
    for _ in range(2000):
        position, velocity, acceleration = plant.get(["position", "velocity", "acceleration"])
        spool = -float(gains @ [position - TARGET, velocity, acceleration])
        spool += dead_zone * np.tanh(spool / 0.01)
        voltages.append(float(np.clip(5.0 + 5.0 * spool, 0.0, 10.0)))
        plant["valveVoltage"] = voltages[-1]
        plant.step(PERIOD)
    # The same voltages once more, with everything recorded.
    times = np.arange(len(voltages)) * PERIOD
    start = PLANT | {"friction.law": law, "position0": START}
    return model.simulate(start, inputs={"valveVoltage": (times, voltages)}, stop=2.0, step=PERIOD)


if __name__ == "__main__":
    sys.exit(main())
