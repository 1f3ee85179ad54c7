"""Saves the state of the plant and tries several inputs from there: roll-outs for model-predictive control.

At each decision the best of a few constant voltages over the next 50 ms is chosen by simulating all of them from the
same saved state; restoring repeats the plant bit for bit.
"""

from __future__ import annotations

import argparse
import sys

import pneumatic_servo as ps

HORIZON = 0.05
CANDIDATES = [3.0, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0]
TARGET = 0.30


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args()
    plant = ps.Model("PneumaticServoCylinder").start({"friction.law": "LuGre", "supplyPressure": 6e5})
    while plant.time < 1.5:
        apply(plant, best(plant))
    position, velocity = plant.get(["position", "velocity"])
    print(f"target {1e3 * TARGET:.1f} mm, reached {1e3 * position:.2f} mm at {1e3 * velocity:.2f} mm/s")
    return 0 if abs(position - TARGET) < 5e-3 else 1


def best(plant: ps.Simulation) -> float:
    """The voltage with the lowest cost at the end of the horizon."""
    saved = plant.save()
    costs = {}
    for voltage in CANDIDATES:
        apply(plant, voltage)
        position, velocity = plant.get(["position", "velocity"])
        costs[voltage] = (position + 0.1 * velocity - TARGET) ** 2
        plant.restore(saved)
    return min(costs, key=costs.__getitem__)


def apply(plant: ps.Simulation, voltage: float) -> None:
    """Holds a voltage for one horizon."""
    plant["valveVoltage"] = voltage
    plant.step(HORIZON)


if __name__ == "__main__":
    sys.exit(main())
