"""The communication points of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.checks import whole_number
from pneumatic_servo.values import seconds

Array = NDArray[np.float64]

MOST = 2.0**53
"""Steps up to which each has a number of its own."""


@dataclass(frozen=True)
class Grid:
    """Points ``start + index * step``; a row is recorded at the start, at an interval of steps, and at the end.

    Each step ends exactly at its point plus its size, as one of an FMU does.
    """

    start: float
    step: float
    count: int
    every: int

    @staticmethod
    def of(start: float, stop: float, step: float, every: int) -> Grid:
        """Check a duration in s, a step size in s and the number of steps per row."""
        start, stop, step = seconds("start", start), seconds("stop", stop), seconds("step", step)
        if step <= 0.0:
            raise ValueError(f"step = {step} is refused: it must be positive")
        if stop < start:
            raise ValueError(f"stop = {stop} is refused: the run starts at {start} s")
        every = whole_number("every", every, least=1)
        steps = (stop - start) / step
        if steps > MOST:
            raise ValueError(f"stop = {stop} is refused: from {start} s these are {steps:g} steps of {step} s")
        count = round(steps)
        # A quotient of decimal fractions is off by rounding only.
        if abs(steps - count) > 1e-6:
            raise ValueError(f"stop = {stop} is refused: from {start} s it is no whole number of steps of {step} s")
        return Grid(start, step, count, every)

    @property
    def rows(self) -> int:
        """Number of rows of a run that comes to its end."""
        return -(-self.count // self.every) + 1

    def points(self) -> NDArray[np.float64]:
        """Return the times in s at which inputs are applied, and the end."""
        return self._points(1)

    def times(self) -> NDArray[np.float64]:
        """Return the times in s of the rows."""
        # Times of the rows only: a long run of short steps may have few.
        return self._points(self.every)

    def _points(self, every: int) -> NDArray[np.float64]:
        indices = np.arange(0, self.count + 1, every, dtype=np.float64)
        if self.count % every:
            indices = np.append(indices, float(self.count))
        return indices * self.step + self.start

    @property
    def numbers(self) -> tuple[float, float, int, int]:
        """Start, step, count and steps per row, as the extension module takes them."""
        return self.start, self.step, self.count, self.every


def courses_of(inputs: Mapping[str, Any], grid: Grid) -> dict[str, Array]:
    """Return the values of inputs at the begin of each step, by the rules of the extension module."""
    times = grid.points()[:-1]
    found = {}
    for name, given in inputs.items():
        if callable(given):
            found[name] = np.array([float(given(time)) for time in times.tolist()])
        elif isinstance(given, tuple):
            found[name] = _between(times, *given)
        else:
            found[name] = np.full(len(times), float(given))
    return found


def _between(times: Array, points: Array, column: Array) -> Array:
    last = np.searchsorted(points, times, side="right") - 1
    inside = np.clip(last, 0, max(len(points) - 2, 0))
    after = np.minimum(inside + 1, len(points) - 1)
    gap = points[after] - points[inside]
    share = (times - points[inside]) / np.where(gap > 0.0, gap, 1.0)
    between = column[inside] + share * (column[after] - column[inside])
    exact = (last == len(points) - 1) | (points[np.maximum(last, 0)] == times)
    found: Array = np.where(exact, column[np.maximum(last, 0)], between)
    return np.where(last < 0, column[0], found)
