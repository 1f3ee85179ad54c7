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
    return _native.parabolas(_plain(values), step, width)[1]


def smooth(values: Array, step: float, width: float) -> Array:
    """Return the values of the same parabolas."""
    return _native.parabolas(_plain(values), step, width)[0]


def low_pass(values: Array, step: float, lag: float) -> Array:
    """Return equidistant samples after a filter of first order, whose time constant in s is the lag.

    The signal is on straight lines between them, for which this is exact, and has been what it begins with before.
    """
    return _native.low_pass(_plain(values), step, lag)


def follow(values: Array, play: float) -> Array:
    """Return a signal after a backlash: it rests while the signal stays within the play about it.

    A jitter smaller than the play becomes rest; a motion is followed at the distance of the play.
    """
    return _native.follow(_plain(values), play)


def _plain(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)
