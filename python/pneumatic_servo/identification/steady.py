"""Friction of a fitted law in steady motion, as the bench tells it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.model import Model

Array = NDArray[np.float64]


def steady(fit: Fitted, fastest: float) -> tuple[Array, Array] | None:
    """Return speeds and friction after sliding at each for a while; nothing for laws that cannot be asked so."""
    bench = Model("FrictionBench")
    half = np.geomspace(0.01 * fastest, fastest, 25)
    speeds = np.concatenate([-half[::-1], half])
    settings = {name: value for name, value in fit.settings.items() if name in bench.parameters}
    runs = bench._run_many(
        [{**settings, "bench.drive": "PrescribedMotion", "driveVelocity": float(speed)} for speed in speeds],
        common={}, inputs={}, stop=2.0, step=0.1, outputs=["frictionForce"],
    )  # fmt: skip
    return None if runs.failures else (speeds, runs["frictionForce"][:, -1])
