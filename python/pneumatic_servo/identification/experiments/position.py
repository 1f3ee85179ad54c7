"""Velocity and acceleration from a measured position."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.identification.experiments.base import Beginning
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import noise, slope, smooth

Array = NDArray[np.float64]


def velocity(record: Record, width: float) -> Array:
    """Return the velocity at the communication points: measured, or the slope of the position."""
    if "velocity" in record.signals:
        return record.on_grid("velocity")
    return slope(record.on_grid("position"), record.step, width)


def smoothed(record: Record, width: float) -> Array:
    """Return the position at the communication points without its noise."""
    return smooth(record.on_grid("position"), record.step, width)


def resting(record: Record, width: float) -> NDArray[np.bool_]:
    """Tell at which samples the position stays within its noise over a width in s about them."""
    position = record.signals["position"]
    half = max(1, round(0.5 * width / record.step))
    padded = np.pad(position, half, mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.asarray(np.ptp(around, axis=1) <= 8.0 * noise(position))


def start_velocity(record: Record, width: float) -> float:
    """Return the velocity that a window begins with: exactly 0 where the carriage rests."""
    if resting(record, width)[0]:
        return 0.0
    return float(velocity(record, width)[0])


def begin(record: Record, width: float) -> Beginning:
    """Begin with the smoothed position and its slope; at rest the slope is exactly 0."""
    speed = start_velocity(record, width)
    measured = {"position0": float(smoothed(record, width)[0])}
    if speed == 0.0:
        return Beginning({"velocity0": 0.0}).with_more(measured)
    return Beginning().with_more({**measured, "velocity0": speed})
