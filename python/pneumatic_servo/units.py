"""Units that values may be given in, by name; and numbers written with one."""

from __future__ import annotations

import math
import re
from reprlib import repr as shortened
from typing import Any

import numpy as np

from pneumatic_servo import _native

AMBIENT = _native.STANDARD_ATMOSPHERE
"""Pressure of the standard atmosphere in Pa, above which bar g, kPa g and psi g count; all others are absolute."""
REFERENCE_DENSITY = 1.185
"""Density in kg/m3 of air in the standard reference atmosphere (ANR, ISO 8778: 1 bar, 20 degC, 65 % humidity)."""

NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.DOTALL)


def scale(unit: str, si: str, where: str, *, is_above_ambient: bool = False) -> tuple[float, float]:
    """Return factor and offset from a unit to an SI unit; `where` begins the message of an error.

    A gauge unit of a pressure above ambient has no offset.
    """
    try:
        return _native.unit_scale(unit, si, is_above_ambient)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def factor(unit: str, si: str, where: str) -> float:
    """Return the factor from a unit to an SI unit; `where` begins the message of an error."""
    return scale(unit, si, where)[0]


def to_si(value: float, unit: str, si: str, where: str) -> float:
    """Return a value in an SI unit."""
    times, offset = scale(unit, si, where)
    # 250 mm are 250/1000 m, which is 0.25; 250 times 1e-3 is not.
    inverse = round(1.0 / times)
    is_exact = times < 1.0 and math.isclose(inverse * times, 1.0, rel_tol=1e-14)
    return (value / inverse if is_exact else value * times) + offset


def units_of(si: str) -> list[str]:
    """Return the units that values of an SI unit may have, it first."""
    return [si, *(name for name in _native.units_of(si) if name != si)]


def in_unit(si: str) -> str:
    """Return the end of a sentence about a number: the unit that it has to be in, if there is one."""
    return "" if si == "1" else f" in {si}"


def written(text: str, si: str, where: str, *, is_bare_allowed: bool = False) -> float:
    """Return the value in an SI unit of a text as ``6 bar``."""
    match = NUMBER.fullmatch(text)
    comma = re.fullmatch(r"\s*([-+]?\d+),(\d+)(.*)", text)
    if match is None or comma is not None:
        hint = f"; did you mean {comma[1]}.{comma[2]}{comma[3]}?" if comma else ""
        raise ValueError(f"{where}: {text!r} is no number{in_unit(si)}{hint}")
    if not match[2]:
        if is_bare_allowed:
            return float(match[1])
        with_unit = "" if si == "1" else f" or '{text.strip()} {si}'"
        raise ValueError(f"{where}: the text {text!r} has no unit; write {text.strip()}{with_unit}")
    return to_si(float(match[1]), match[2], si, where)


def has_unit(given: object) -> bool:
    """Tell whether something is a number with a unit: ``"6 bar"``, ``(6, "bar")``, or a quantity."""
    if isinstance(given, str):
        match = NUMBER.fullmatch(given)
        return match is not None and bool(match[2])
    return (isinstance(given, tuple) and len(given) == 2 and isinstance(given[1], str)) or is_quantity(given)


def is_quantity(given: object) -> bool:
    """Tell whether something carries a unit: a quantity of pint, astropy, unyt or quantities, or a list of such."""
    if isinstance(given, list) and given and not isinstance(given[0], list):
        return is_quantity(given[0])
    has_unit_of = hasattr(given, "units") or hasattr(given, "unit")
    return has_unit_of and (hasattr(given, "to") or hasattr(given, "rescale")) and not isinstance(given, type)


def magnitude(given: Any, si: str, where: str) -> Any:
    """Return the number, or array of numbers, of a quantity in an SI unit."""
    if isinstance(given, list):
        return np.array([magnitude(one, si, where) for one in given])
    # For N.s/m and kg/(s.Pa2) of the table, packages read N*s/m and kg/(s*Pa**2).
    name = "" if si == "1" else re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", si.replace(".", "*"))
    try:
        found = given.to(name) if hasattr(given, "to") else given.rescale(name or "dimensionless")
    except Exception as error:
        raise ValueError(f"{where} = {shortened(given)} is refused: it must be in {si} ({error})") from None
    # Of pint and quantities it is the magnitude, of astropy and unyt the value.
    return found.magnitude if hasattr(found, "magnitude") else found.value
