"""Operating conditions of a fit: which of its windows were measured at which pressure, load, amplitude or speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pneumatic_servo.argument_names import quoted
from pneumatic_servo.identification.kinds import measured_speed
from pneumatic_servo.identification.problem import Problem
from pneumatic_servo.identification.records import Record
from pneumatic_servo.identification.smoothing import fastest

SAME = 0.1
"""Values that differ by less than this share belong to one condition."""


def _mean(signal: str) -> Callable[[Record], float]:
    return lambda record: float(np.mean(record.signals[signal]))


QUANTITIES: dict[str, tuple[tuple[str, ...], str, Callable[[Record], float]]] = {
    "pressure": (("pressure",), "Pa", _mean("pressure")),
    "load": (("normalForce",), "N", _mean("normalForce")),
    "supplyPressure": (("supplyPressure",), "Pa", _mean("supplyPressure")),
    "amplitude": (("position",), "m", lambda record: 0.5 * float(np.ptp(record.signals["position"]))),
    "speed": (("position", "velocity"), "m/s", lambda record: fastest(measured_speed(record))),
}
"""Quantities that distinguish conditions: the signals of which one is needed, the unit, and the value of a record."""


@dataclass(frozen=True)
class Condition:
    """Windows of one condition.

    Attributes
    ----------
    quantity : str
        ``record``, or what is about the same in all windows.
    value : float
        Its mean over the windows; of records their number.
    name : str
        The condition in words.
    windows : tuple of int
        Places of the windows in the problem.
    """

    quantity: str
    value: float
    name: str
    windows: tuple[int, ...]


def conditions(problem: Problem, records: list[Record], quantity: str) -> list[Condition]:
    """Tell the windows of a problem apart by a quantity, or by the table that they are from.

    Parameters
    ----------
    problem : Problem
        A problem.
    records : list of Record
        Records of its windows: stretches without gaps.
    quantity : str
        ``record``, or one of `QUANTITIES`.

    Raises
    ------
    ValueError
        For an unknown quantity, one that was not measured, and one that is the same everywhere.
    """
    if quantity == "record":
        names = list(dict.fromkeys(window.record.name for window in problem.windows))
        places = [[k for k, window in enumerate(problem.windows) if window.record.name == name] for name in names]
        found = [
            Condition(quantity, float(number), name, tuple(own))
            for number, (name, own) in enumerate(zip(names, places, strict=True), start=1)
        ]
    else:
        found = _by_quantity(problem, records, quantity)
    if len(found) < 2:
        raise ValueError(f"{quoted('cross_validate', quantity)}: there is only one condition, {found[0].name}")
    return found


def _by_quantity(problem: Problem, records: list[Record], quantity: str) -> list[Condition]:
    if quantity not in QUANTITIES:
        raise ValueError(f"{quoted('cross_validate', quantity)}: it must be record, {', '.join(QUANTITIES)}")
    signals, unit, of = QUANTITIES[quantity]
    if not problem.experiment.signals & set(signals):
        raise ValueError(f"{quoted('cross_validate', quantity)}: {' or '.join(signals)} was not measured")
    values = [of(record) for record in records]
    own = np.array([values[_whole(records, window.record)] for window in problem.windows])
    order = np.argsort(own, kind="stable")
    jumps = np.diff(own[order]) > SAME * np.maximum(np.abs(own[order][1:]), np.abs(own[order][:-1]))
    groups = np.split(order, np.flatnonzero(jumps) + 1)
    means = [float(np.mean(own[group])) for group in groups]
    unit = unit if quantity == "load" else problem.experiment.units.of(unit)
    return [
        Condition(quantity, mean, f"{quantity} {mean:.4g} {unit}", tuple(sorted(group.tolist())))
        for mean, group in zip(means, groups, strict=True)
    ]


def _whole(records: list[Record], part: Record) -> int:
    """Return the place of the record that a window was cut from."""
    return next(
        place
        for place, record in enumerate(records)
        if record.name == part.name and record.begin <= part.begin <= record.begin + record.time[-1]
    )
