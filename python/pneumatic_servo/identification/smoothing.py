"""Smoothing of measured signals before they are used; it is always reported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo import _native

Array = NDArray[np.float64]


def noise(values: Array) -> float:
    """Estimate the standard deviation of white noise and of quantisation from third differences, which motion leaves.

    The median does not see the few samples at which a signal jumps. A signal that mostly rests between the steps of
    its converter has differences of 0; then the step itself tells: its length over the root of 12.
    """
    return _native.noise(_plain(values))


def fastest(speed: Array) -> float:
    """Return the speed that all samples but the two fastest of a hundred keep: single peaks are noise."""
    return float(np.quantile(np.abs(speed), 0.98)) if len(speed) else 0.0


def slope(values: Array, step: float, width: float) -> Array:
    """Return the slopes of parabolas fitted about each of equidistant samples, over a width in s."""
    return _native.slopes(_plain(values), step, width)


def _plain(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)
