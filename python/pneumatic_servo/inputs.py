"""Inputs as users write them, checked and brought into the form that the extension module takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from reprlib import repr as shortened
from typing import SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneumatic_servo.checks import mapping
from pneumatic_servo.grid import Grid
from pneumatic_servo.variables import Value, Variable, Variables

Array = NDArray[np.float64]
Input = float | tuple[ArrayLike, ArrayLike] | Callable[[float], float]
"""An input over time: a constant, points ``(t, u)``, or a function of time in s.

It is applied as a host applies it to an FMU: the value at each communication point is held over the step that begins
there. Between points it lies on a straight line, beyond them it keeps the value at the end; of points at the same time
the last counts, so that a pair of them makes a step.
"""
Values = Value | Sequence[Value] | Array
"""A value that all runs share, or one per run."""
Inputs = Mapping[str, Input]


def course(inputs: Variables, name: str, given: Input) -> float | tuple[Array, Array] | Callable[[float], float]:
    """Check one input of a single run."""
    variable = _find(inputs, name)
    if callable(given):
        return given
    if isinstance(given, tuple):
        times, values = points(variable, given)
        if values.ndim != 1:
            raise ValueError(
                f"{name}: values have the shape {values.shape}, but one run takes as many as there are times"
            )
        return times, values
    return _constant(variable, given)


def courses(
    inputs: Variables, name: str, given: Input | ArrayLike, number: int, grid: Grid
) -> float | Array | tuple[Array, Array]:
    """Check one input of many runs; a function is called once per communication point, for all runs."""
    variable = _find(inputs, name)
    if callable(given):
        times = grid.points()
        return times, np.array([[_at(variable, given, time) for time in times.tolist()]])
    if isinstance(given, tuple):
        times, values = points(variable, given)
        rows = values.reshape(1, -1) if values.ndim == 1 else values
        if rows.shape[0] not in (1, number):
            raise ValueError(f"{name}: values have the shape {values.shape}, but there are {number} runs")
        return times, np.ascontiguousarray(rows)
    if len(shape(name, given)) == 0:
        return _constant(variable, given)
    values = _numbers(variable, given)
    if values.shape != (number,):
        raise ValueError(f"{name}: there are {number} runs, but the values have the shape {values.shape}")
    return values


def points(variable: Variable, given: tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
    """Check times and values; the last axis of the values is that of the times."""
    if len(given) != 2:
        raise ValueError(f"{variable.name}: points are a pair of times and values, not {len(given)} arrays")
    times, values = (_numbers(variable, array) for array in given)
    if times.ndim != 1 or not len(times) or values.ndim not in (1, 2) or values.shape[-1] != len(times):
        raise ValueError(f"{variable.name}: times of shape {times.shape} do not fit values of shape {values.shape}")
    wrong = np.flatnonzero(~np.isfinite(times))
    if len(wrong):
        raise ValueError(f"{variable.name}: time {wrong[0]} is {times[wrong[0]]}")
    back = np.flatnonzero(np.diff(times) < 0.0)
    if len(back):
        raise ValueError(
            f"{variable.name}: time falls from {times[back[0]]} s to {times[back[0] + 1]} s at point {back[0] + 1}"
        )
    legal = np.isfinite(values)
    if variable.minimum is not None:
        legal &= values >= variable.minimum
    if variable.maximum is not None:
        legal &= values <= variable.maximum
    if not legal.all():
        place = tuple(np.argwhere(~legal)[0])
        limits = f" ({variable.range})" if variable.range else ""
        raise ValueError(
            f"{variable.name} = {values[place]} at t = {times[place[-1]]} s is refused: "
            f"it must be a finite number in {variable.unit}{limits}"
        )
    return times, values


FORMS = "a constant, a pair (t, u) of times and values, or a function of time"


def _constant(variable: Variable, given: object) -> float:
    """Return the value of an input that stays the same."""
    if isinstance(given, str) or not isinstance(given, SupportsFloat) or getattr(given, "ndim", 0) != 0:
        raise ValueError(f"{variable.name} = {shortened(given)} is refused: it must be {FORMS}")
    return float(given)


def shape(name: str, given: ArrayLike) -> tuple[int, ...]:
    """Return the shape of what an input is given as."""
    try:
        return np.shape(given)
    except ValueError as error:
        raise ValueError(f"{name} = {shortened(given)} is refused: {error}") from None


def _at(variable: Variable, given: Callable[[float], float], time: float) -> float:
    """Return what a function of time gives."""
    value = given(time)
    if isinstance(value, str) or not isinstance(value, SupportsFloat):
        raise ValueError(f"at t = {time} s {variable.name} = {shortened(value)} is refused: it must be a number")
    return float(value)


def _numbers(variable: Variable, given: ArrayLike) -> Array:
    """Return an array of numbers."""
    try:
        return np.ascontiguousarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{variable.name} = {shortened(given)} is refused: {error}") from None


def settings_of_runs(
    parameters: Sequence[Mapping[str, Value]] | Mapping[str, Values], number: int | None
) -> list[dict[str, Value]]:
    """Return the settings of each of many runs, from a list of them or from arrays that hold one value per run."""
    if isinstance(parameters, str) or not isinstance(parameters, Mapping | Sequence):
        raise TypeError(f"parameters must be mappings of names to values, not {shortened(parameters)}")
    if not isinstance(parameters, Mapping) and len(parameters):
        return [mapping(f"parameters[{run}]", settings) for run, settings in enumerate(parameters)]
    several: dict[str, list[Value]] = {}
    shared: dict[str, Value] = {}
    for name, value in parameters.items() if isinstance(parameters, Mapping) else ():
        if isinstance(value, bool | int | float | str) or np.ndim(value) == 0:
            shared[name] = value  # type: ignore[assignment]
        else:
            several[name] = list(value)
    lengths = {name: len(values) for name, values in several.items()}
    counts = set(lengths.values()) | (set() if number is None else {number})
    if len(counts) > 1:
        raise ValueError(f"how many runs? The inputs are for {number}, the parameters for {lengths}")
    runs = range(counts.pop() if counts else 1)
    return [shared | {name: values[run] for name, values in several.items()} for run in runs]


def _find(inputs: Variables, name: str) -> Variable:
    try:
        return inputs[name]
    except KeyError as error:
        raise ValueError(f"{name} is not an input; the inputs are {', '.join(inputs)}") from error
