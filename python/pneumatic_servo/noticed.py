"""What is unusual about values that are accepted, told as warnings."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import warn
from pneumatic_servo.grid import Grid
from pneumatic_servo.units import to_si
from pneumatic_servo.variables import Variable, Variables

SATURATES: dict[str, tuple[float, float]] = {"valveVoltage": (0.0, 10.0)}
"""Inputs that do no more beyond these values, as their texts say."""
LATE = 1e-6
"""Times are the same within so many steps."""


def tell(variables: Variables, noticed: Iterable[tuple[str, float, str]], where: str = "") -> None:
    """Warn of what the plant noticed: variable, value and remark."""
    for name, value, remark in noticed:
        variable = variables.get(name)
        unit = "" if variable is None or variable.unit == "1" else f" {variable.unit}"
        warn(f"{where}{name} = {value:g}{unit}: {remark}{_meant(variable, value)}")


def _meant(variable: Variable | None, value: float) -> str:
    """Return what a pressure that is far too small may be in bar."""
    if variable is None or variable.unit != "Pa" or not 0.5 <= value < 1000.0:
        return ""
    unit = "bar" if value < 50.0 else "kPa"
    return f"; did you mean {value:g} {unit}, which is {to_si(value, unit, 'Pa', variable.name):g} Pa?"


def tell_saturation(variable: Variable, low: float, high: float) -> None:
    """Warn of an input that goes where it does no more."""
    ends = SATURATES.get(variable.name)
    if ends is None:
        return
    worst = low if low < ends[0] else high
    if not ends[0] <= worst <= ends[1] and math.isfinite(worst):
        warn(
            f"{variable.name} = {worst:g} {variable.unit}: it saturates at {ends[0]:g} and {ends[1]:g} "
            f"{variable.unit}, and does no more beyond"
        )


def tell_ends(variable: Variable, times: NDArray[np.float64], grid: Grid) -> None:
    """Warn of points that do not reach from the begin of a run to its last step."""
    last = grid.start + max(grid.count - 1, 0) * grid.step
    if times[0] > grid.start + LATE * grid.step:
        warn(
            f"{variable.name} is given from {times[0]:g} s on, but the run starts at {grid.start:g} s: "
            "its first value holds before"
        )
    # A table of samples ends one of its intervals early, as `arange` does.
    interval = float(np.median(np.diff(times))) if len(times) > 2 else 0.0
    if times[-1] + interval < last - LATE * grid.step:
        stop = grid.start + grid.count * grid.step
        warn(
            f"{variable.name} is given until {times[-1]:g} s, but the run goes on to {stop:g} s: "
            "its last value holds from there on"
        )
