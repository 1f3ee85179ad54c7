"""Records: measured signals over time without gaps, ready to be compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Record:
    """Measured signals in SI units, sampled without gaps.

    Attributes
    ----------
    name : str
        Source of the record.
    time : ndarray of shape (samples,)
        Times in s, from 0.
    begin : float
        Time in s of the table that is 0 here.
    signals : dict
        Signals by name, of shape (samples,).
    """

    name: str
    time: Array
    begin: float
    signals: Mapping[str, Array]

    @cached_property
    def step(self) -> float:
        """The usual interval between samples in s."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def grid(self) -> Array:
        """Communication points of a simulation of this record, in s: its usual interval, up to its end."""
        return np.arange(int(np.floor(self.time[-1] / self.step + 1e-6)) + 1, dtype=np.float64) * self.step

    @property
    def numbers(self) -> tuple[Array, float, dict[str, Array]]:
        """The record as the crate takes it."""
        return plain(self.time), self.begin, {name: plain(values) for name, values in self.signals.items()}

    def on_grid(self, signal: str) -> Array:
        """Return a signal at the communication points, on straight lines between its samples."""
        return np.interp(self.grid, self.time, self.signals[signal])

    def part(self, first: int, last: int) -> Record:
        """Return the samples from one index up to another."""
        cut = slice(first, last)
        signals = {name: values[cut] for name, values in self.signals.items()}
        start = float(self.time[first])
        return Record(self.name, self.time[cut] - start, self.begin + start, signals)


def plain(values: Array) -> Array:
    """Return an array as the crate takes it."""
    return np.ascontiguousarray(values, dtype=np.float64)
