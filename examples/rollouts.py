"""Saves the state of the plant and tries several inputs from there: roll-outs for model-predictive control.

At each decision the best of a few constant voltages over the next 50 ms is chosen by simulating all of them from the
same saved state; restoring repeats the plant bit for bit.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "packaging" / "python"))
from client import Client  # noqa: E402

HORIZON = 0.05
CANDIDATES = [3.0, 4.0, 4.5, 5.0, 5.5, 6.0, 7.0]
TARGET = 0.30


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmu", type=Path, nargs="?", default=Path("target/fmu/PneumaticServoCylinder.fmu"))
    fmu: Path = parser.parse_args().fmu
    with Client(fmu) as plant:
        plant.start({"friction.law": "LuGre", "supplyPressure": 6e5})
        while plant.time < 1.5:
            voltage = best(plant)
            apply(plant, voltage)
        position, velocity = plant.get(["position", "velocity"])
    print(f"target {1e3 * TARGET:.1f} mm, reached {1e3 * position:.2f} mm at {1e3 * velocity:.2f} mm/s")
    return 0 if abs(position - TARGET) < 5e-3 else 1


def best(plant: Client) -> float:
    """The voltage with the lowest cost at the end of the horizon."""
    saved, time = plant.slave.getFMUState(), plant.time
    costs = {}
    for voltage in CANDIDATES:
        apply(plant, voltage)
        position, velocity = plant.get(["position", "velocity"])
        costs[voltage] = (position + 0.1 * velocity - TARGET) ** 2
        plant.slave.setFMUState(saved)
        plant.time = time
    plant.slave.freeFMUState(saved)
    return min(costs, key=costs.__getitem__)


def apply(plant: Client, voltage: float) -> None:
    """Holds a voltage for one horizon."""
    plant.set({"valveVoltage": voltage})
    plant.advance(plant.time + HORIZON)


if __name__ == "__main__":
    sys.exit(main())
