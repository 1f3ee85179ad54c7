"""Records: measured signals over time without gaps, ready to be compared."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.chosen_columns import Column
from pneumatic_servo.identification.table import Measured, measured

Array = NDArray[np.float64]

GAP = 5.0
"""Multiple of the usual interval beyond which a gap splits a record."""
LOST = 0.02
"""Shorter intervals, in s, are bridged on straight lines: a few lost samples tell less than a new beginning costs."""
SHORTEST = 50
"""Samples without which a record tells too little."""
FEWEST_POINTS = 5
"""Points without which a table tells too little."""


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


def load(
    data: Iterable[Measured | Any], columns: Mapping[str, Column] | None = None, *, has_time: bool = True
) -> tuple[list[Record], list[str]]:
    """Split the measurements at gaps; return the records, and notes on omitted parts.

    Points without a time are one record, whose times number them.
    """
    records: list[Record] = []
    notes: list[str] = []
    for number, given in enumerate(data, start=1):
        source = given if isinstance(given, Measured) else measured(number, given, columns or None)
        name = source.name
        if not has_time:
            records.append(_points(name, source.signals))
            continue
        _check_arrays(name, source.signals)
        pieces = _pieces(name, source.signals)
        long = [piece for piece in pieces if len(piece.time) >= SHORTEST]
        if not long:
            most = max(len(piece.time) for piece in pieces)
            raise ValueError(f"{name}: too short, {most} samples without a gap; at least {SHORTEST} are needed")
        if len(pieces) > 1:
            notes.append(f"{name}: split at {len(pieces) - 1} gaps, {len(pieces) - len(long)} pieces too short to use")
        records += long
    if has_time:
        _check_motion(records)
    return records, notes


def _points(name: str, signals: Mapping[str, Array]) -> Record:
    """Return points as a record; refuse those of which nothing can be learned."""
    count = len(np.ravel(signals["velocity"]))
    numbers = np.arange(count, dtype=np.float64)
    _check_arrays(name, {"time": numbers, **signals}, "velocity", "point")
    if count < FEWEST_POINTS:
        raise ValueError(f"{name}: too few points, {count}; at least {FEWEST_POINTS} are needed")
    if not np.any(signals["velocity"]):
        raise ValueError(
            f"{name}: velocity = 0 m/s at all points: friction at rest answers the drive; measure while it slides"
        )
    return Record(name, numbers, 0.0, dict(signals))


def _check_arrays(name: str, signals: Mapping[str, Array], clock: str = "time", row: str = "sample") -> None:
    """Refuse arrays that are not as long as a clock, and values that are no numbers."""
    if "time" not in signals:
        raise ValueError(f"{name}: there is no time")
    time = signals["time"]
    for signal, values in signals.items():
        if values.shape != time.shape or values.ndim != 1:
            raise ValueError(f"{name}: {signal} has the shape {values.shape}, {clock} {signals[clock].shape}")
        wrong = np.flatnonzero(~np.isfinite(values))
        if len(wrong):
            raise ValueError(f"{name}: {signal} is {values[wrong[0]]} at {row} {wrong[0]}")
    falls = np.flatnonzero(np.diff(time) <= 0.0)
    if len(falls):
        raise ValueError(f"{name}: time must rise, but {time[falls[0] + 1]} s follows {time[falls[0]]} s")


def _pieces(name: str, signals: Mapping[str, Array]) -> list[Record]:
    time = signals["time"]
    intervals = np.diff(time)
    if not len(intervals):
        raise ValueError(f"{name}: too short, a single sample; at least {SHORTEST} are needed")
    ends = [0, *(np.flatnonzero(intervals > max(GAP * np.median(intervals), LOST)) + 1), len(time)]
    others = {signal: values for signal, values in signals.items() if signal != "time"}
    whole = Record(name, time - time[0], float(time[0]), others)
    return [whole.part(int(first), int(last)) for first, last in pairwise(ends)]


def _check_motion(records: Iterable[Record]) -> None:
    for signal in ("position", "velocity"):
        moved = [np.ptp(record.signals[signal]) for record in records if signal in record.signals]
        if moved and max(moved) == 0.0:
            raise ValueError(f"{signal} never changes: all at rest, so that nothing can be learned of friction")


def plain(values: Array) -> Array:
    """Return an array as the crate takes it."""
    return np.ascontiguousarray(values, dtype=np.float64)
