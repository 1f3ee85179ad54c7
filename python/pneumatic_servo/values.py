"""Values as people write them, with units or without, as the plant takes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from reprlib import repr as shortened
from typing import Any, SupportsFloat

import numpy as np

from pneumatic_servo import _native
from pneumatic_servo.checks import mapping
from pneumatic_servo.errors import Refused
from pneumatic_servo.names import did_you_mean, similar
from pneumatic_servo.units import has_unit, in_unit, is_quantity, magnitude, to_si, written
from pneumatic_servo.variables import Unit, Value, Variable, Variables


def settings(argument: str, variables: Variables, given: Mapping[str, object] | None) -> dict[str, Value]:
    """Return values by name as the plant takes them; impossible values are refused by name, value and unit."""
    return {name: value_of(variables, name, value) for name, value in mapping(argument, given).items()}


def value_of(variables: Variables, name: object, given: object) -> Value:
    """Return the value of the variable of a name."""
    if not isinstance(name, str):
        raise ValueError(f"{name!r} is no name of a variable")
    variable = variables.get(name)
    if variable is None:
        # The numbers that stand for enumerations are known to the plant only.
        if name.endswith("Number") and isinstance(given, int):
            return given
        raise ValueError(f"there is no variable {name}{did_you_mean(name, variables)}")
    return checked(variable, given)


def checked(variable: Variable, given: object) -> Value:
    """Return a value that a variable may have, in its SI unit."""
    if variable.kind == "enumeration":
        return _item(variable, given)
    if variable.kind == "real":
        value = number(variable, given)
        check_range(variable, value)
        return value
    if variable.kind == "boolean" and variable.role == "input":
        return flag(variable, given) == 1.0
    return given  # type: ignore[return-value]


def flag(variable: Variable, given: object) -> float:
    """Return 1 or 0 for an input that is true or false."""
    value = given.item() if isinstance(given, np.generic) else given
    if not isinstance(value, bool | int | float) or value not in (0, 1):
        raise ValueError(f"{variable.name} = {shortened(given)} is refused: it must be True or False, or 1 or 0")
    return float(value)


def number(variable: Variable, given: object) -> float:
    """Return a number in SI units, from one, ``"6 bar"``, ``(6, "bar")``, or a quantity of pint."""
    # By far the most frequent.
    if type(given) is float:
        return given
    if isinstance(given, str):
        return written(given, variable.unit, variable.name)
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str):
        return to_si(_plain(variable, given[0]), given[1], variable.unit, variable.name)
    if is_quantity(given):
        given = magnitude(given, variable.unit, variable.name)
    return _plain(variable, given)


def number_in(unit: str, name: str, given: object) -> float:
    """Return a number in an SI unit, of something that is no variable of a model."""
    bare = Variable(name, "fixed", "real", unit, None, None, None, None, Unit(unit), {}, {}, None, "")
    value = number(bare, given)
    check_range(bare, value)
    return value


def seconds(argument: str, given: object) -> float:
    """Return a time in s, given as a number or with its unit."""
    if has_unit(given):
        return number_in("s", argument, given)
    try:
        value = float(given) if not isinstance(given, str) else math.nan  # type: ignore[arg-type]
    except (TypeError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{argument} = {shortened(given)} is refused: it must be a finite number of seconds")
    return value


def _plain(variable: Variable, given: Any) -> float:
    if np.ma.is_masked(given):
        raise ValueError(f"{variable.name} is refused: the value is masked; fill it, or leave it out")
    if not is_number(given):
        what = f"it must be a single number{in_unit(variable.unit)}"
        shown = given if hasattr(given, "shape") else shortened(given)
        raise ValueError(f"{variable.name} = {shown} is refused: {what}")
    return float(given)


def is_number(given: object) -> bool:
    """Tell whether something is a single number. True is 1 to Python, but no voltage and no law to anybody."""
    if type(given) in (float, int):
        # Protocols are asked slowly.
        return True
    is_logical = isinstance(given, bool) or type(given).__name__.startswith("bool")
    return isinstance(given, SupportsFloat) and getattr(given, "ndim", 0) == 0 and not is_logical


def check_range(variable: Variable, value: float, time: float | None = None) -> None:
    """Refuse a value that is not finite or out of range; state the range, and the unit that may have been meant."""
    if variable.kind == "boolean" and value not in (0.0, 1.0):
        raise Refused(variable.name, value, "it must be 1 (True) or 0 (False)", time)
    low, high = variable.minimum, variable.maximum
    if math.isfinite(value) and (low is None or value >= low) and (high is None or value <= high):
        return
    if not math.isfinite(value):
        reason = f"it must be a finite number{in_unit(variable.unit)}"
    else:
        reason = f"it must be {variable.range_in_unit}{_meant(variable, value)}"
    raise Refused(variable.name, value, reason, time, variable.unit)


def _meant(variable: Variable, value: float) -> str:
    """Return the unit in which a value that is out of range would be within it, if there is such a usual one."""
    low, high = variable.plausible or (variable.minimum, variable.maximum)
    bounds = (-math.inf if low is None else low, math.inf if high is None else high)
    usual = variable.default or variable.nominal
    near = abs(usual) if isinstance(usual, float) else None
    return _native.meant(variable.unit, value, *bounds, variable.shown.name, near)


def _item(variable: Variable, given: object) -> Value:
    if isinstance(given, str):
        if given in variable.items:
            return given
        near = similar(given, variable.items, 1)
        meant = f"did you mean {near[0]}? " if near else ""
        raise ValueError(
            f'{variable.name} = "{given}" is refused: {meant}it must be one of {", ".join(variable.items)}'
        )
    if is_number(given) and float(given) in {float(one) for one in variable.ids.values()}:  # type: ignore[arg-type]
        return float(given)  # type: ignore[arg-type]
    every = ", ".join(f"{number} {name}" for name, number in variable.ids.items())
    raise ValueError(f"{variable.name} = {shortened(given)} is refused: it must be one of {every}")
