"""Faults of converters and recorders: clipped readings, samples that are lost or repeated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import warn
from pneumatic_servo.identification.signals import Units
from pneumatic_servo.identification.smoothing import noise
from pneumatic_servo.identification.table import Measured

Array = NDArray[np.float64]

LONG = 8
"""Readings in a row at the very end of a signal that are no chance where readings differ otherwise."""
RARELY, OFTEN = 0.2, 0.1
"""A signal with noise repeats a reading for at most this share of its samples, and turns for at least that one."""
NEAR = 3
"""Samples before and after a leap in which a carriage that moved by itself would have moved, too."""
LEAP = 10.0
"""Ratio of a leap to the steps near it."""
LOUD = 20.0
"""And than the noise."""
DROPPED, STEADY = 2.5, 0.5
"""Least step over the largest near a leap, where steps are alike; a leap by this ratio is then enough.

No mass is that fast for one sample.
"""
ABRUPT, AHEAD, COARSE = 0.7, 5, 4.0
"""Share of the way, samples, and smallest steps of a position that leaves its end at speed: it was clipped.

The share is compared with the way in as many samples after them."""
QUICK = 5e-3
"""Between samples farther apart, in s, a carriage that has rested may well be at speed."""
SMALL = 0.01
"""And than this share of the way."""
MISSING = 1.5
"""Ratio of an interval to the usual one that shows lost samples."""
FEW = 0.1
"""Share of irregular intervals from which samples count as uneven."""
CHANCE, CERTAIN = 5.0, 5
"""Repeated rows are no chance beyond this multiple of the expected number, and beyond this number."""


ASKED = ("time", "valveVoltage", "supplyPressure")
"""Signals of a controller, which may stay at an end, leap, and be repeated."""


def check(source: Measured, units: Units) -> list[str]:
    """Warn of likely effects of a recorder on a table; return notes of harmless ones.

    Warns
    -----
    PlantWarning
        For readings that stop at an end, positions that leap, and rows that are repeated.
    """
    time = source.signals["time"]
    for signal, values in source.signals.items():
        if signal not in ASKED:
            is_quick = len(time) > 1 and float(np.median(np.diff(time))) <= QUICK
            found = [*clipped(values), *(stopped(values) if signal == "position" and is_quick else ())]
            for end, count in dict(found).items():
                first = int(_longest(values == end)[0])
                warn(
                    f"{source.name}: {signal} stays at {end:.6g} {units.of_signal(signal)}, the end of what it reads, "
                    f"for {count} samples, as from {time[first]:.6g} s ({source.where(signal, first)}): is its range "
                    "too small, so that it is clipped there? Leave these stretches out"
                )
    _check_leaps(source, units)
    _check_repeats(source)
    return _missing(source)


def clipped(values: Array) -> Iterator[tuple[float, int]]:
    """Yield each end at which a signal with noise stays for many samples in a row, and for how many.

    A position that rests repeats its reading, and so does whatever has no noise: of these nothing is said.
    """
    if len(values) < 4 * LONG:
        return
    ends = (float(np.max(values)), float(np.min(values)))
    at_end = np.isin(values, ends)
    has_noise = _has_noise(np.diff(values)[~(at_end[1:] & at_end[:-1])])
    for end in ends:
        longest = int(np.max(_runs(values == end)[1]))
        # A signal at rest, or unloaded, is exactly 0.
        if has_noise and end != 0.0 and longest >= LONG:
            yield end, int(np.sum(values == end))


def stopped(position: Array) -> Iterator[tuple[float, int]]:
    """Yield each end at which a position stops dead and from which it leaves at full speed, and for how many samples.

    A carriage leaves an end stop from rest, and goes farther in the next few samples than in the first; one that was
    behind the end of a sensor's range comes back at speed.
    """
    if len(position) < 4 * LONG:
        return
    steps = np.abs(np.diff(position))
    # A converter moves by whole steps of its own.
    floor = max(AHEAD * float(np.max(steps)) / LEAP, COARSE * float(np.min(steps[steps > 0.0], initial=np.inf)))
    for end in (float(np.max(position)), float(np.min(position))):
        first, length = _runs(position == end)
        long = length >= LONG
        leaving = first[long] + length[long]
        leaving = leaving[leaving + 2 * AHEAD < len(position)]
        if not len(leaving):
            continue
        first_way, second_way = (np.abs(position[leaving + k + AHEAD] - position[leaving + k]) for k in (0, AHEAD))
        if np.mean((first_way > ABRUPT * second_way) & (first_way > floor)) >= 0.5:
            yield end, int(np.sum(position == end))


def _has_noise(steps: Array) -> bool:
    """Tell whether steps from sample to sample show noise that the converter resolves."""
    turns = np.mean(steps[1:] * steps[:-1] < 0.0) if len(steps) > 1 else 0.0
    return bool(turns > OFTEN and np.mean(steps == 0.0) < RARELY)


def _longest(inside: NDArray[np.bool_]) -> tuple[int, int]:
    """Return where the longest run begins, and how long it is."""
    first, length = _runs(inside)
    longest = int(np.argmax(length))
    return int(first[longest]), int(length[longest])


def _runs(inside: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return where runs begin, and how long they are."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return ends[::2], ends[1::2] - ends[::2]


def leaps(time: Array, position: Array) -> NDArray[np.int64]:
    """Return after which samples a position leaps as nothing with a mass does, at the usual interval."""
    steps, intervals = np.abs(np.diff(position)), np.diff(time)
    if len(steps) < 4 * NEAR:
        return np.zeros(0, dtype=np.int64)
    padded = np.pad(steps, NEAR)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR + 1)
    others = np.max(np.delete(around, NEAR, axis=1), axis=1)
    least = max(LOUD * noise(position), SMALL * float(np.ptp(position)))
    usual = intervals < MISSING * float(np.median(intervals))
    is_far = (steps > LEAP * others) & (steps > least)
    signed = np.pad(np.diff(position), NEAR, mode="edge")
    beside = np.delete(np.lib.stride_tricks.sliding_window_view(signed, 2 * NEAR + 1), NEAR, axis=1)
    one_way = np.where(np.diff(position) > 0.0, np.min(beside, axis=1), -np.max(beside, axis=1))
    is_dropped = (one_way > STEADY * others) & (steps > DROPPED * others) & (steps - others > LOUD * noise(position))
    return np.flatnonzero((is_far | is_dropped) & usual)


def _check_leaps(source: Measured, units: Units) -> None:
    if "position" not in source.signals:
        return
    time, position = source.signals["time"], source.signals["position"]
    found = leaps(time, position)
    if len(found):
        first = int(found[0])
        more = f", and at {len(found) - 1} more" if len(found) > 1 else ""
        leap = f"{position[first + 1] - position[first]:.4g} {units.of_signal('position')}"
        warn(
            f"{source.where('position', first + 1)}: position leaps by {leap} within one sample, at "
            f"{time[first + 1]:.6g} s{more}, as no mass does: were samples dropped, and time counted on? Give the time "
            "as it was recorded, or cut the record there"
        )


def _check_repeats(source: Measured) -> None:
    """Warn where all signals together repeat a row more often than each by itself makes likely.

    A machine at rest repeats all that has no noise, for long; a recorder that has lost samples does so for a few.
    """
    steps = [np.diff(values) for signal, values in source.signals.items() if signal not in ASKED]
    if len(steps) < 2 or not len(steps[0]):
        return
    same = [one == 0.0 for one in steps]
    every = np.logical_and.reduce(same)
    others = ~every
    if not any(_has_noise(one[others]) for one in steps):
        return
    chance = len(every) * float(np.prod([np.mean(one[others]) for one in same]))
    first, length = _runs(every)
    short = length < LONG
    count = int(np.sum(length[short]))
    if count > CERTAIN + CHANCE * chance:
        warn(
            f"{source.name}: {count} rows repeat the one before, the first {source.where('time', first[short][0] + 1)}"
            ", though signals have noise: has the recorder lost samples, and held the last ones? Remove these rows"
        )


def _missing(source: Measured) -> list[str]:
    intervals = np.diff(source.signals["time"])
    usual = float(np.median(intervals)) if len(intervals) else 0.0
    wide = np.flatnonzero(intervals > MISSING * usual)
    if not len(wide) or len(wide) > FEW * len(intervals):
        return []
    count = int(np.sum(np.round(intervals[wide] / usual) - 1.0))
    return [
        f"{source.name}: {count} samples are missing, the first before {source.where('time', int(wide[0]) + 1)}; "
        "single ones are bridged on straight lines"
    ]
