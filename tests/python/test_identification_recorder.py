"""What is said of readings that stop at an end, of leaps, of rows that are repeated or missing, and from where on."""

from __future__ import annotations

import warnings

import numpy as np
import pneumatic_servo as ps
import pytest
from numpy.typing import NDArray
from pneumatic_servo.identification.recorder import LONG, check, clipped, leaps
from pneumatic_servo.identification.signals import SLIDING, Units
from pneumatic_servo.identification.table import Measured

Array = NDArray[np.float64]

TIME = np.arange(200) * 1e-3


def said(signals: dict[str, Array], units: Units = SLIDING) -> list[str]:
    """Warnings and notes on a table."""
    source = Measured("a.csv", {"time": TIME, **signals}, lambda signal, row: f"line {row + 2}, {signal}")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        notes = check(source, units)
    assert all(one.category is ps.PlantWarning for one in told)
    return [str(one.message) for one in told] + notes


def noisy(seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, 200)


def test_readings_at_both_ends_are_told_and_those_of_a_controller_are_not() -> None:
    force = noisy()
    force[40:50], force[60:61], force[90:99] = 2.0, 2.0, -1.5
    assert said({"force": force, "valveVoltage": force, "supplyPressure": force}, Units(is_rotating=True)) == [
        f"a.csv: force stays at {end} N.m, the end of what it reads, for {count} samples: is its range too small, so "
        "that it is clipped there? Leave these stretches out"
        for end, count in (("2", 11), ("-1.5", 9))
    ]


@pytest.mark.parametrize(
    ("change", "count"),
    [
        ("none", 1),
        # What is unloaded reads 0.
        ("zero", 0),
        # A signal that rests, rises or turns rarely has no noise that tells.
        ("coarse", 0),
        ("smooth", 0),
        ("short", 0),
    ],
)
def test_end_of_a_signal_is_one_where_readings_differ_otherwise(change: str, count: int) -> None:
    values = noisy()
    values[40 : 40 + LONG] = 2.0
    if change == "zero":
        values = values - 2.0
    elif change == "coarse":
        values[values < 2.0] = np.round(values[values < 2.0])
    elif change == "smooth":
        values = np.minimum(np.linspace(0.0, 3.0, 200), 2.0)
    elif change == "short":
        values = values[30 : 30 + 4 * LONG - 1]
    assert len(list(clipped(values))) == count


def test_thirty_two_readings_are_enough() -> None:
    values = noisy()[: 4 * LONG]
    values[4 : 4 + LONG] = 2.0
    assert list(clipped(values)) == [(2.0, LONG)]


def way(*at: int, by: float = 0.1) -> Array:
    """A carriage at 0.1 m/s that leaps after some samples."""
    position = 0.1 * TIME
    for index in at:
        position[index + 1 :] += by
    return position


def test_leaps_are_told_with_the_first_of_them() -> None:
    advice = "were samples dropped, and time counted on? Give the time as it was recorded, or cut the record there"
    words = f", as no mass does: {advice}"
    assert said({"position": way(50)}) == [f"line 53, position: position leaps by 0.1001 m within one sample{words}"]
    assert said({"position": way(50, 90, 120, by=-0.2)}, Units(is_rotating=True)) == [
        f"line 53, position: position leaps by -0.1999 rad within one sample, and at 2 more{words}"
    ]
    assert said({"force": way(50)}) == []


TREMOR = 1e-7 * (-1.0) ** np.arange(200)
"""Keeps a converter from being seen in the leaps themselves."""


@pytest.mark.parametrize(("factor", "is_leap"), [(0.9, False), (1.1, True)])
def test_leap_is_larger_than_steps_beside_it_and_a_share_of_the_way(factor: float, is_leap: bool) -> None:
    expected = [100] * is_leap
    # Ten steps of 0.1 mm.
    assert leaps(TIME, way(100, by=factor * 1e-3 - 1e-4)).tolist() == expected
    # A hundredth of a way of 1 m that is made far from it.
    far = 0.99 * np.clip((np.arange(200) - 150) / 49.0, 0.0, 1.0)
    assert leaps(TIME, TREMOR + far + 0.01 * factor * (np.arange(200) > 100)).tolist() == expected


@pytest.mark.parametrize(("apart", "is_leap"), [(3, False), (4, True)])
def test_carriage_that_moves_beside_it_does_not_leap(apart: int, is_leap: bool) -> None:
    index = np.arange(200)
    position = TREMOR + np.where(index > 100, 0.1, 0.0) + np.where(index > 100 + apart, 0.02, 0.0)
    assert (100 in leaps(TIME, position)) is is_leap
    assert (98 in leaps(TIME, position[::-1])) is is_leap


def test_lost_samples_whose_times_are_lost_too_are_no_leap() -> None:
    late = TIME.copy()
    late[101:] += 2e-3
    assert leaps(late, way(100)).tolist() == [] and leaps(TIME, way(100)).tolist() == [100]
    assert leaps(TIME[:12], way(5)[:12]).tolist() == [] and leaps(TIME[:13], way(5)[:13]).tolist() == [5]


def repeated(rows: list[int], *columns: Array) -> list[Array]:
    """Columns in which some rows repeat the one before."""
    for column in columns:
        for row in rows:
            column[row] = column[row - 1]
    return list(columns)


def test_rows_that_repeat_are_told_with_the_first_of_them() -> None:
    rows = [20, 40, 60, 80, 100, 101]
    position, force = repeated(rows, noisy(1), noisy(2))
    told = (
        "a.csv: 6 rows repeat the one before, the first line 22, time, though signals have noise: has the recorder "
        "lost samples, and held the last ones? Remove these rows"
    )
    # Voltages are often held; a single signal may repeat by chance.
    signals = {"frictionForce": position, "force": force}
    assert said({**signals, "valveVoltage": np.ones(200)}) == [told]
    assert said({"force": force, "valveVoltage": np.ones(200)}) == []
    assert said(dict(zip(signals, repeated(rows[:5], noisy(1), noisy(2)), strict=True))) == []


def test_rows_of_coarse_readings_repeat_by_chance() -> None:
    """Each of two converters repeats a tenth of its readings, and so both two of 200 rows."""
    alone = [np.arange(5, 200, 10), np.arange(9, 200, 10)]
    together = list(range(21, 181, 20))
    columns = [repeated(list(rows), noisy(seed))[0] for seed, rows in enumerate(alone, start=1)]
    signals = dict(zip(("frictionForce", "force"), repeated(together, *columns), strict=True))
    # Eight are more than five, but not by five times the two of chance.
    assert said(signals) == []
    more = [row + after for after in (0, 2, 10, 12) for row in together]
    signals = dict(zip(("frictionForce", "force"), repeated(more, *columns), strict=True))
    assert [text.split(",")[0] for text in said(signals)] == ["a.csv: 32 rows repeat the one before"]


def lost(*counts: int, usual: float = 1e-3) -> list[str]:
    """Notes on a table that lacks so many rows after every tenth."""
    intervals = np.full(199, usual)
    for place, count in enumerate(counts, start=1):
        intervals[10 * place] *= 1 + count
    time = np.concatenate([[0.0], np.cumsum(intervals)])
    return check(Measured("a.csv", {"time": time}, lambda signal, row: f"line {row + 2}, {signal}"), SLIDING)


def test_missing_rows_are_counted() -> None:
    said = "samples are missing, the first before line 13, time; single ones are bridged on straight lines"
    assert lost(1, 3, 1) == [f"a.csv: 5 {said}"] and lost(2) == [f"a.csv: 2 {said}"]
    assert lost() == []
    # Of 199 intervals a tenth may be long; where more are, samples are just not even.
    assert lost(*[1] * 19) == [f"a.csv: 19 {said}"]
    uneven = np.where(np.arange(199) % 9 == 0, 2e-3, 1e-3)
    time = np.concatenate([[0.0], np.cumsum(uneven)])
    assert check(Measured("a.csv", {"time": time}, lambda *_: ""), SLIDING) == []
    assert check(Measured("a.csv", {"time": np.zeros(1)}, lambda *_: ""), SLIDING) == []
    # An interval that is less than half as long again is jitter.
    jitter = 1e-3 * np.where(np.arange(199) % 20 == 0, 1.45, 1.0)
    time = np.concatenate([[0.0], np.cumsum(jitter)])
    assert check(Measured("a.csv", {"time": time}, lambda *_: ""), SLIDING) == []
