"""A rig that is not ours: the equations of tests/reference, integrated by SciPy, seen by imperfect sensors.

Positions have a noise of 10 um, pressures one of 0.5 kPa; both go through a converter of 12 bits, over 0.5 m and over
6 bar above 0.5 bar. The voltage is exact.

Usage: python docs/studies/synthetic_rig.py --law Stribeck --out rig.csv
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "reference"))

from plant import Inputs, Plant
from simulation import Run, configure

Array = NDArray[np.float64]

STEP = 1e-3
SUPPLY = 6e5
NOISES = {"position": 1e-5, "pressure": 500.0}
RANGES = {"position": (0.0, 0.5), "pressure": (0.5e5, 6.5e5)}
LEVELS = 4095

COMMON: dict[str, float] = {"valve.deadZone": 0.065, "valve.C": 4.4e-9}
LAWS: dict[str, dict[str, float]] = {
    "Coulomb": {"friction.coulomb.Fc": 7.1, "friction.coulomb.sigma2": 42.0},
    "Stribeck": {
        "friction.stribeck.Fs": 12.4, "friction.stribeck.Fc": 7.6, "friction.stribeck.vs": 0.018,
        "friction.stribeck.sigma2": 38.0,
    },
    "LuGre": {
        "friction.lugre.Fs": 12.1, "friction.lugre.Fc": 7.9, "friction.lugre.vs": 0.016, "friction.lugre.sigma2": 36.0,
    },
    "Polito": {
        "friction.polito.Fs": 11.8, "friction.polito.Fc1": 8.4, "friction.polito.Fc2": 7.0, "friction.polito.c1": 36.0,
        "friction.polito.c2": 29.0,
    },
    "GMS": {
        "friction.gms.Fs": 12.2, "friction.gms.Fc": 7.8, "friction.gms.vs": 0.015, "friction.gms.sigma2": 37.0,
    },
}  # fmt: skip
"""True values, which a fit has to find."""


def voltage(time: float) -> float:
    """Valve voltage in V: two sines that never meet in the same way."""
    return float(5.0 - np.sin(2.0 * np.pi * 0.5 * time) + 0.8 * np.sin(2.0 * np.pi * 1.7 * time))


def truth(
    law: str, duration: float, tolerance: float = 1e-6, driven: Callable[[float], float] = voltage
) -> dict[str, Array]:
    """Response of the rig under a law and a voltage, at intervals of 1 ms."""
    parameters: dict[str, Any] = {"friction.law": law, **COMMON, **LAWS[law]}
    plant, friction = configure(parameters)
    run = Run(Plant(plant), friction, tolerance)
    inputs = [Inputs(driven(k * STEP), 0.0, SUPPLY) for k in range(round(duration / STEP) + 1)]
    run.sample(inputs[0], 0.0)
    run.start()
    rows = [run.row(0.0)]
    for k, given in enumerate(inputs[:-1]):
        run.sample(given, k * STEP)
        run.advance(STEP)
        rows.append(run.row((k + 1) * STEP))
    return {
        "time": np.arange(len(rows)) * STEP,
        "valveVoltage": np.array([given.voltage for given in inputs]),
        "position": np.array([row.position for row in rows]),
        "velocity": np.array([row.velocity for row in rows]),
        "frictionForce": np.array([row.frictionForce for row in rows]),
        "chamberA.pressure": np.array([row.pressureA for row in rows]),
        "chamberB.pressure": np.array([row.pressureB for row in rows]),
    }


def measured(true: dict[str, Array], seed: int, *, is_rounded: bool = True) -> dict[str, Array]:
    """Readings of the sensors, through their converters or without."""
    rng = np.random.default_rng(seed)
    seen = {"time": true["time"], "valveVoltage": true["valveVoltage"]}
    for signal in ("position", "chamberA.pressure", "chamberB.pressure"):
        kind = signal.rpartition(".")[2]
        low, high = RANGES[kind]
        size = (high - low) / LEVELS
        noisy = true[signal] + NOISES[kind] * rng.standard_normal(len(true[signal]))
        seen[signal] = low + size * np.round((noisy - low) / size) if is_rounded else noisy
    return seen


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", default="Stribeck", choices=LAWS)
    parser.add_argument("--duration", type=float, default=4.0, help="in s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    seen = measured(truth(options.law, options.duration), options.seed)
    columns = {"t": seen["time"], "u": seen["valveVoltage"], "x_mm": 1e3 * seen["position"],
               "pa_bar": 1e-5 * seen["chamberA.pressure"], "pb_bar": 1e-5 * seen["chamberB.pressure"]}  # fmt: skip
    digits = {"t": 3, "u": 5, "x_mm": 3, "pa_bar": 5, "pb_bar": 5}
    with options.out.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*([f"{v:.{digits[name]}f}" for v in row] for name, row in columns.items()), strict=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())
