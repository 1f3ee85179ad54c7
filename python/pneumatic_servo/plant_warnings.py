"""Warnings about accepted values that are unusual."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pneumatic_servo.errors import warn
from pneumatic_servo.grid import Grid
from pneumatic_servo.variables import Variable, Variables

SATURATES: dict[str, tuple[float, float]] = dict.fromkeys(
    ("valveVoltage", "valveVoltageA", "valveVoltageB"), (0.0, 10.0)
)
"""Inputs that do no more beyond these values, as the text of the first says."""
HARDLY = 1.0
"""Acceleration in m/s2, by the push of `PUSH` on the piston, below which a machine hardly moves."""
PUSH = 1e6
"""Pressure in Pa beyond any usual supply."""
FAR = 50.0
"""Length of an input, relative to the run's, from which it is probably a mistake."""
LATE = 1e-6
"""Tolerance of equal times, in steps."""


def warn_saturation(variable: Variable, low: float, high: float) -> None:
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


def warn_size(variables: Variables, runs: Iterable[Mapping[str, object]]) -> None:
    """Warn of the first run with a mass that the piston hardly moves, or a force that it cannot hold by far."""
    if "cylinder.bore" not in variables:
        return
    every = list(runs)
    for number, values in enumerate(every):
        told = _size(variables, values)
        if told is not None:
            warn(f"run {number} of {len(every)}: {told}" if len(every) > 1 else told)
            return


def _size(variables: Variables, values: Mapping[str, object]) -> str | None:
    names = ("cylinder.bore", "mass.moving", "externalForce")
    if not any(name in values for name in names):
        return None
    bore, mass, force = (_number(values.get(name, variables[name].default)) for name in names)
    push = PUSH * 0.25 * math.pi * bore**2
    piston = f"the piston of cylinder.bore = {bore:g} m pushes with {push:.3g} N at {1e-5 * PUSH:g} bar"
    if push < HARDLY * mass:
        return (
            f"mass.moving = {mass:g} kg: {piston}, which hardly moves it; did you mean {mass:g} g, "
            f"which is {1e-3 * mass:g} kg?"
        )
    if abs(force) > FAR * push:
        return f"externalForce = {force:g} N: {piston}; so much more only holds the carriage at an end of its stroke"
    return None


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan


def warn_ends(variable: Variable, times: NDArray[np.float64], grid: Grid) -> None:
    """Warn of points that do not reach from the begin of a run to its last step."""
    last = grid.start + max(grid.count - 1, 0) * grid.step
    if times[0] > grid.start + LATE * grid.step:
        warn(
            f"{variable.name} is given from {times[0]:g} s on, but the run starts at {grid.start:g} s: "
            "its first value holds before"
        )
    whole = grid.count * grid.step
    if times[-1] - times[0] > FAR * whole:
        warn(
            f"{variable.name} is given until {times[-1]:g} s, but the run ends at {grid.start + whole:g} s: the rest "
            f"does nothing; if its times are in ms, write 1e-3 * t"
        )
    # A table of samples ends one of its intervals early, as `arange` does.
    # Points that are held have two of the same time, but for rounding.
    intervals = np.diff(times)[np.diff(times) > LATE * grid.step]
    interval = float(np.median(intervals)) if len(intervals) > 1 else 0.0
    if times[-1] + interval < last - LATE * grid.step:
        stop = grid.start + grid.count * grid.step
        warn(
            f"{variable.name} is given until {times[-1]:g} s, but the run goes on to {stop:g} s: "
            "its last value holds from there on"
        )
