"""What is done to measured signals before they are used; it is always reported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter, savgol_filter

Array = NDArray[np.float64]


def noise(values: Array) -> float:
    """Estimate the standard deviation of white noise and of quantisation from third differences, which motion leaves.

    The median does not see the few samples at which a signal jumps. A signal that mostly rests between the steps of
    its converter has differences of 0; then the step itself tells: its length over the root of 12.
    """
    if len(values) < 8:
        return 0.0
    third = np.diff(values, 3)
    # The sum of the squares of 1, 3, 3, 1 is 20; 0.6745 is the median of a normal distribution's magnitude.
    white = float(np.median(np.abs(third))) / 0.6745 / np.sqrt(20.0)
    steps = np.abs(np.diff(values))
    steps = steps[steps > 1e-12 * max(1.0, float(np.max(np.abs(values))))]
    converter = float(np.min(steps)) / np.sqrt(12.0) if len(steps) else 0.0
    return float(max(white, converter))


def fastest(speed: Array) -> float:
    """Return the speed that all samples but the two fastest of a hundred keep: single peaks are noise."""
    return float(np.quantile(np.abs(speed), 0.98)) if len(speed) else 0.0


def slope(values: Array, step: float, width: float) -> Array:
    """Return the slopes of parabolas fitted about each of equidistant samples, over a width in s."""
    return np.asarray(savgol_filter(values, _samples(values, step, width), 2, deriv=1, delta=step))


def smooth(values: Array, step: float, width: float) -> Array:
    """Return the values of the same parabolas."""
    return np.asarray(savgol_filter(values, _samples(values, step, width), 2))


def low_pass(values: Array, step: float, lag: float) -> Array:
    """Return what a filter of first order, whose time constant in s is the lag, makes of equidistant samples.

    The signal is on straight lines between them, for which this is exact, and has been what it begins with before.
    """
    kept = np.exp(-step / lag)
    share = lag / step * (1.0 - kept)
    return np.asarray(values[0] + lfilter([1.0 - share, share - kept], [1.0, -kept], values - values[0]))


def _samples(values: Array, step: float, width: float) -> int:
    """Return how many samples a width has: an odd number, at least five."""
    number = max(5, 2 * round(0.5 * width / step) + 1)
    return min(number, len(values) - 1 + len(values) % 2)


def follow(values: Array, play: float) -> Array:
    """Return what follows a signal with a play: it rests while the signal stays within the play about it.

    A jitter smaller than the play becomes rest; a motion is followed at the distance of the play.
    """
    if play <= 0.0:
        return values
    followed = np.empty_like(values)
    last = values[0]
    for index, value in enumerate(values):
        last = min(max(last, value - play), value + play)
        followed[index] = last
    return followed
