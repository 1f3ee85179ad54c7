"""Kinds of motion: at rest, at break-away, at reversals, slow and fast."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import fastest, slope

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NEAR = 0.05
"""Time in s about a reversal, or after a rest, that counts to it."""
SLOW = 0.2
"""Share of the fast velocities below which a motion is slow."""
REST = 0.01
"""The same below which there is none."""


def kinds(problem: Problem) -> dict[str, list[Mask]]:
    """Tell for each kind of motion which samples of each window belong to it."""
    found: dict[str, list[Mask]] = {}
    speeds = [measured_speed(window.record) for window in problem.windows]
    fast = fastest(np.concatenate(speeds))
    if problem.experiment.is_steady:
        slow = [np.abs(speed) < SLOW * fast for speed in speeds]
        pairs = [(inside, window.used) for inside, window in zip(slow, problem.windows, strict=True)]
        return {
            "in slow motion": [inside & used for inside, used in pairs],
            "in fast motion": [~inside & used for inside, used in pairs],
        }
    for window, speed in zip(problem.windows, speeds, strict=True):
        around = max(1, 2 * round(NEAR / window.record.step) + 1)
        still = np.abs(speed) < REST * fast
        turns = np.zeros(len(speed), dtype=bool)
        moving = np.flatnonzero(~still)
        signs = np.sign(speed[moving])
        turns[moving[1:][signs[1:] != signs[:-1]]] = True
        near = maximum_filter1d(turns, around).astype(bool)
        leaves = np.concatenate([[False], still[:-1] & ~still[1:]])
        breaks = maximum_filter1d(leaves, around).astype(bool) & ~still & ~near
        slow = ~still & ~near & ~breaks & (np.abs(speed) < SLOW * fast)
        for name, inside in (
            ("at rest", still & ~near), ("at break-away", breaks), ("at reversals", near), ("in slow motion", slow),
            ("in fast motion", ~still & ~near & ~breaks & ~slow),
        ):  # fmt: skip
            found.setdefault(name, []).append(inside & window.used)
    return found


def measured_speed(record: Record) -> Array:
    """Return the velocity of each sample as it was measured, or as the slope of the position; 0 without either."""
    signals, time, step = record.signals, record.time, record.step
    if "velocity" in signals:
        return np.asarray(signals["velocity"])
    if "position" not in signals:
        return np.zeros(len(time))
    return slope(np.asarray(signals["position"]), step, max(NEAR / 2.0, 5.0 * step))
