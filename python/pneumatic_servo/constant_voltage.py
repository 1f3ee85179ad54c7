"""Derivatives by a constant valve voltage: a valve with hysteresis follows a change to one side only.

The left and right derivatives differ. Nearby runs, whose voltage rises or falls very slowly, have one or the other:
elements of Clarke's generalized gradient.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import NoDerivative

Array = NDArray[np.float64]
AtRest = Literal["mean", "zero", "refuse"]
"""Choices of the derivative by a voltage at rest.

The mean of both sides, with which a search can begin; 0, the side without motion; or none, with an error.
"""
CHOICES = ("mean", "zero", "refuse")
VOLTAGE = "valveVoltage"
HARDLY = 1e-6
"""Volts by which the voltage of a run nearby rises or falls at each step."""
REASON = "left and right derivatives by a constant voltage differ unless valve.hysteresis is 0; see at_rest"


def check(at_rest: str) -> None:
    """Refuse a treatment that there is not."""
    if at_rest not in CHOICES:
        raise ValueError(f"at_rest = {at_rest!r} is refused: it must be one of {', '.join(CHOICES)}")


def nearby(course: Array) -> tuple[Array, Array]:
    """Return a course that rises a little all along, and one that falls."""
    ramp = HARDLY * np.arange(1.0, len(course) + 1.0)
    return course + ramp, course - ramp


def lacking(names: Sequence[str], by_inputs: Array) -> NDArray[np.bool_]:
    """Return at which steps the voltage alone has no derivative, of derivatives of shape (inputs, steps)."""
    if VOLTAGE not in names:
        return np.zeros(by_inputs.shape[1], dtype=np.bool_)
    row = list(names).index(VOLTAGE)
    others = np.delete(by_inputs, row, axis=0)
    return np.asarray(np.isnan(by_inputs[row]) & np.isfinite(others).all(axis=0))


def settled(
    names: Sequence[str], by_inputs: Array, at_rest: str, course: Callable[[], Array], again: Callable[[Array], Array]
) -> Array:
    """Return derivatives by inputs, of shape (inputs, steps), those by a constant voltage as they are chosen.

    Parameters
    ----------
    names : sequence of str
        The inputs.
    by_inputs : ndarray
        The derivatives, with NaN.
    at_rest : str
        One of `CHOICES`.
    course : callable
        Returns the voltage over each step.
    again : callable
        Returns the derivatives of a run with another voltage.
    """
    where = lacking(names, by_inputs)
    if at_rest == "refuse" or not where.any():
        return by_inputs
    row, found = list(names).index(VOLTAGE), by_inputs.copy()
    found[row, where] = 0.0
    if at_rest == "mean":
        for side in nearby(course()):
            found[row, where] += 0.5 * again(side)[row, where]
    return found


def refuse(names: Sequence[str], by_inputs: Array, points: Array) -> None:
    """Refuse derivatives by inputs, of shape (inputs, steps), of which some do not exist."""
    rests = lacking(names, by_inputs)
    for name, row in zip(names, np.isnan(by_inputs), strict=True):
        if row.any():
            first = int(np.argmax(row))
            why = REASON if name == VOLTAGE and rests[first] else "its left and right derivatives differ"
            raise NoDerivative(float(points[first]), name, why)
